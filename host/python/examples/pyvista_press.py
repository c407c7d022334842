"""A picture of a press: `pip install pyvista`, then `python pyvista_press.py press.png`; no screen is needed."""

import sys

import numpy as np
import pyvista

import chaincell

model = chaincell.Model.bake_mesh("organ:1000", young_pa=5000)
tissue = chaincell.Tissue(model, tools=["sphere:0.012"])
top_m = model.rest_m[model.rest_m[:, 2].argmax()]
for position_m in top_m + np.linspace([0, 0, 0.014], [0, 0, 0.0], 300):
    output = tissue.tick(position_m)

corners = np.searchsorted(model.node_ids, model.triangles)
body = pyvista.PolyData.from_regular_faces(tissue.positions_m, corners)
body["displacement [mm]"] = 1e3 * np.linalg.norm(tissue.positions_m - model.rest_m, axis=1)
plotter = pyvista.Plotter(off_screen=True)
plotter.add_mesh(body, smooth_shading=True, cmap="magma_r")
plotter.add_mesh(pyvista.Sphere(0.012, center=position_m), color="lightsteelblue")
plotter.add_title(f"{np.linalg.norm(output.force_n):.2f} N", font_size=12)
plotter.screenshot(sys.argv[1])
