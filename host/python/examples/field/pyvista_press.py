"""A picture of a press by PyVista: the body at its largest force, coloured by displacement.

`python pyvista_press.py press.png` needs `pip install pyvista`, and no screen; without a file it opens a
window. Nothing is served: the tissue ticks in this process.
"""

import sys

import numpy as np
import pyvista as pv

import chaincell

file = sys.argv[1] if len(sys.argv) > 1 else None
model = chaincell.Model.bake_mesh("organ:500", young_pa=5000)
path_m = np.linspace([0, 0, 0.08], [0, 0, 0.035], 400)
result = chaincell.run(model, path_m, tools=["sphere:0.012"], sweeps=2)
force_n = np.linalg.norm(result.force_n, axis=1)
peak = int(force_n.argmax())

tissue = chaincell.Tissue(model, tools=["sphere:0.012"], sweeps=2)
for position_m in path_m[: peak + 1]:
    tissue.tick(position_m)
corners = np.searchsorted(model.node_ids, model.triangles)
body = pv.PolyData.from_regular_faces(tissue.positions_m, corners)
body["displacement in mm"] = 1e3 * np.linalg.norm(tissue.positions_m - model.rest_m, axis=1)
plotter = pv.Plotter(off_screen=file is not None)
plotter.add_mesh(body, scalars="displacement in mm", smooth_shading=True)
plotter.add_mesh(pv.Sphere(radius=0.012, center=path_m[peak]), color="white", opacity=0.5)
plotter.add_text(f"{force_n[peak]:.2f} N", font_size=12)
plotter.show(screenshot=file or False)
