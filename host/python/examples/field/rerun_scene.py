"""Shows a running scene in Rerun: the body, coloured by displacement, and the contact forces.

`python rerun_scene.py left liver.chaincell` opens Rerun; a third argument names a .rrd file to write
instead. Needs `pip install rerun-sdk`, a `chaincell serve --scene left` with a tool, and a controller.
"""

import sys

import numpy as np
import rerun as rr

from chaincell import Model, Session

model = Model.load(sys.argv[2])
corners = np.searchsorted(model.node_ids, model.triangles)
rr.init("chaincell", spawn=len(sys.argv) == 3)
if len(sys.argv) > 3:
    rr.save(sys.argv[3])
with Session(sys.argv[1], role="viewer") as session:
    while session.is_served:
        if (state := session.state(timeout_s=0.2)) is None:
            continue
        rr.set_time("session", duration=1e-3 * state.tick)
        moved_mm = 1e3 * np.linalg.norm(state.positions_m - model.rest_m, axis=1)
        red = np.uint8(np.clip(25 * moved_mm, 0, 255))
        colours = np.stack([red, 90 + red // 4, 255 - red], axis=1)
        rr.log("body", rr.Mesh3D(vertex_positions=state.positions_m, triangle_indices=corners, vertex_colors=colours))
        if (contacts := session.contacts(timeout_s=0)) is not None:
            newtons = contacts.normal_n + contacts.tangential_n
            rr.log("contacts", rr.Arrows3D(origins=contacts.positions_m, vectors=0.1 * newtons))
            rr.log("force_n", rr.Scalars(float(np.linalg.norm(newtons.sum(axis=0)))))
