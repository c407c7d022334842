# %% [markdown]
# # A press in a notebook
#
# A force curve and a body in one line each. Jupyter opens this file by jupytext, VS Code as it is;
# `pip install matplotlib pyvista` brings what draws. Nothing is served: the tissue ticks in this process.

# %%
import numpy as np

import chaincell

# %% [markdown]
# A generated liver of 5 kPa; `Model.bake_mesh("liver.stl", unit_m=0.001, fill_m=0.01, ...)` takes yours.

# %%
model = chaincell.Model.bake_mesh("organ:500", young_pa=5000)
model.show()

# %% [markdown]
# A ball of 12 mm radius comes down on it, a row for each millisecond.

# %%
path_m = np.linspace([0, 0, 0.08], [0, 0, 0.035], 400)
result = chaincell.run(model, path_m, tools=["sphere:0.012"], sweeps=2)
result.plot_force(against="depth")

# %% [markdown]
# The body at the end, coloured by displacement.

# %%
result.show()
