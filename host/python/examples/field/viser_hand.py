"""A hand in the browser: viser's handle is the tool of a running scene, at 1 kHz.

`python viser_hand.py left liver.chaincell` prints the page's address. Needs `pip install viser` and a
`chaincell serve liver.chaincell --tool sphere:0.012 --scene left`. A third argument ends it after so
many seconds.
"""

import sys

import numpy as np
import viser

from chaincell import Model, Rate, Session

STEP_M = 0.0004  # of a tick: a tool that jumps is a bad sample
model = Model.load(sys.argv[2])
low_m, high_m = model.rest_m.min(axis=0), model.rest_m.max(axis=0)
tool_m = np.append((low_m + high_m)[:2] / 2, high_m[2] + 0.03)
server = viser.ViserServer(host="127.0.0.1")  # without it, on every network
corners = np.searchsorted(model.node_ids, model.triangles)
body = server.scene.add_mesh_simple("/body", model.rest_m.astype(np.float32), corners)
hand = server.scene.add_transform_controls("/hand", 0.05, disable_rotations=True, position=tool_m)
server.scene.add_icosphere("/hand/ball", 0.012)
shown = server.gui.add_text("Force", "0 N", disabled=True)
with Session(sys.argv[1]) as session:
    for tick in Rate(1000, seconds=float(sys.argv[3]) if len(sys.argv) > 3 else None):
        way_m = hand.position - tool_m
        tool_m += way_m * min(1.0, STEP_M / max(np.linalg.norm(way_m), 1e-9))
        force_n = session.step(tool_m, engaged=tick > 0)
        if tick % 40 == 0 and (state := session.state(timeout_s=0)) is not None:
            body.vertices = state.positions_m.copy()
            shown.value = f"{np.linalg.norm(force_n):.2f} N"
server.stop()
