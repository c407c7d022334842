"""Soft tissue for haptics: bake meshes, tick tissue offline, drive a running scene.

Bake. `Model.bake` takes points and tetrahedra, or closed triangles with `fill_m`; `Model.bake_mesh` takes a
mesh file, a generator such as "organ:500", or an object with `points` and `cells` or `cells_dict`, as meshio
has them, with its `point_sets`, `cell_sets` and Gmsh's physical groups. Arguments are the options of
`chaincell bake` with underscores, see `chaincell.options`: `fixed` stands for --fix (ids, a mask of all
nodes, or a selector such as "group:back"), `unit_m` for --units, `materials` for --material. `young_pa`,
`poisson`, `alpha` and `stiffness_n_per_m` are a number, an array with one value for each node, or a text such
as "5000,group:hard=20000". A filled surface has new nodes: take `fixed` as a selector, or from `Model.rest_m`
of a first bake. `Model.load`, `Model.from_bytes` and `bytes(model)` move models, and they can be pickled.

Tick and run. A pose is [x, y, z] in metres, 7 numbers with a unit quaternion x, y, z, w after them, or a
tuple of both; of several tools an array (tools, 3) or (tools, 7), and forces are then (tools, 3). `engaged`
is True by default, or one truth value for each tool. `run` takes (ticks, 3), (ticks, 7), (ticks, tools, 3)
or (ticks, tools, 7). `contact` may be ids of nodes, and `tools=["sphere:0.01"]` stands for --tool.
`tick(..., sweeps=n)` and `run(..., sweeps_made=...)` repeat ticks of a session that ended early, by
`answer.sweeps`. A snapshot belongs to one model, one set of options and one release; those of
`chaincell command snapshot` are of the same kind.

Sessions. `Session.step` sends a pose and returns the force to show: that of the last answer for
`watchdog_ms`, then along a ramp to 0. It waits at most `timeout_s` for the answer to its own pose;
`session.answer` is the whole answer. A tool has no force until a pose with `engaged=False` has released it
once, after another server too (`Flags.RELEASE_FIRST`, `Notes.NEW_SESSION`). Without an answer for `lost_s`
a step raises `NoServer`; later steps go on when a server answers again. `state` and `contacts` return those
of the newest tick not yet taken. `Session(scene, role="viewer")` looks and commands next to a controller.
Commands wait for the server's reply: they are not for the loop of a device. `Rate` sleeps until shortly
before each turn and polls for the last 60 us; a turn that is more than a period late begins at once, is
counted in `late`, and moves the schedule.

Errors are all `chaincell.Error` and name the place and the remedy: `ArgumentError`, `ModelError`,
`SnapshotError` and `PoseError`, which are `ValueError` too; `Refused`, a command that was not carried out;
and those of `SessionError`: `NoServer`, `OtherVersion`, `Taken`, `Full`, `NoPermission`, `NoReply`, `Closed`.
An argument of a wrong type raises `TypeError`: truth values and complex numbers are no numbers, and floats
are no whole ones. Bad input changes nothing: no tick is made, and nothing is sent.

Copies and views. `Model.image`, and `positions_m` and `node_ids` of a `State`, which lie in shared memory,
are views that cannot be written. They stay as they are, also when the session is closed. A session may hold
two states: drop one, with its arrays, before the next. Everything else is copied, each time anew. The rows of
`Tissue.positions_m` and of a state are those of `Model.node_ids`.

Threads, signals, forks. Python runs on while the library bakes, ticks, runs or waits. Threads may share every
object; calls of one object take turns. Ctrl-C ends every wait, `bake` and `run` within some 20 ms. A handler
of signals may not use the session or tissue that its own thread is using: that raises `Error`. A forked child
has no session: its calls raise `Closed`. A process has one copy of iceoryx2: its own Python package, or the
client for C, would take the sessions of this one for those of a dead program.
"""

from chaincell import options as options
from chaincell._native import (
    Answer,
    Contacts,
    Model,
    Output,
    Rate,
    Reply,
    Run,
    Session,
    SessionStress,
    State,
    Stress,
    Surface,
    Tissue,
    __version__,
    run,
)
from chaincell.errors import (
    ArgumentError,
    Closed,
    Error,
    Full,
    ModelError,
    NoPermission,
    NoReply,
    NoServer,
    OtherVersion,
    PoseError,
    Refused,
    SessionError,
    SnapshotError,
    Taken,
)
from chaincell.flags import Flags, Notes

__all__ = [
    "Answer",
    "ArgumentError",
    "Closed",
    "Contacts",
    "Error",
    "Flags",
    "Full",
    "Model",
    "ModelError",
    "NoPermission",
    "NoReply",
    "NoServer",
    "Notes",
    "OtherVersion",
    "Output",
    "PoseError",
    "Rate",
    "Refused",
    "Reply",
    "Run",
    "Session",
    "SessionStress",
    "SessionError",
    "SnapshotError",
    "State",
    "Stress",
    "Surface",
    "Taken",
    "Tissue",
    "__version__",
    "run",
]
