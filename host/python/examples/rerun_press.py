"""A press as a Rerun recording: `pip install rerun-sdk`, then `python rerun_press.py press.rrd`, `rerun press.rrd`."""

import sys

import numpy as np
import rerun as rr

import chaincell

model = chaincell.Model.bake_mesh("organ:1000", young_pa=5000)
top_m = model.rest_m[model.rest_m[:, 2].argmax()]
down_m = np.linspace([0, 0, 0.014], [0, 0, 0.0], 300)
path_m = top_m + np.concatenate([down_m, down_m[::-1]])
force_n = chaincell.run(model, path_m, tools=["sphere:0.012"]).force_n

rr.init("chaincell press")
rr.save(sys.argv[1])
tissue = chaincell.Tissue(model, tools=["sphere:0.012"])
corners = np.searchsorted(model.node_ids, model.triangles)
for tick, position_m in enumerate(path_m):
    tissue.tick(position_m)
    rr.set_time("tick", sequence=tick)
    rr.log("force_n", rr.Scalars(np.linalg.norm(force_n[tick])))
    if tick % 10 == 0:
        rr.log("body", rr.Mesh3D(vertex_positions=tissue.positions_m, triangle_indices=corners))
        rr.log("tool", rr.Ellipsoids3D(centers=[position_m], half_sizes=[[0.012] * 3]))
