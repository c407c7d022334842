from collections.abc import Sequence
from os import PathLike
from types import TracebackType
from typing import Any, Literal, TypeAlias, final

import numpy as np
import numpy.typing as npt
from typing_extensions import Self, Unpack

from chaincell.flags import Flags, Notes
from chaincell.options import BakeOptions, TissueOptions

__all__ = [
    "__version__",
    "Model",
    "Tissue",
    "Output",
    "Run",
    "Contacts",
    "Stress",
    "Surface",
    "Session",
    "SessionStress",
    "Reply",
    "Answer",
    "State",
    "Rate",
    "run",
    "tissue_options",
    "bake_options",
]

__version__: str

_F32: TypeAlias = npt.NDArray[np.float32]
_U32: TypeAlias = npt.NDArray[np.uint32]
_Path: TypeAlias = str | PathLike[str]
_Pose: TypeAlias = npt.ArrayLike | tuple[npt.ArrayLike, npt.ArrayLike]
_Engaged: TypeAlias = bool | npt.ArrayLike

@final
class Model:
    """A baked body: what `chaincell bake` writes. It never changes, threads may share it, and it can be
    pickled; `bytes(model)` are those of the model file.

    >>> model = chaincell.Model.bake_mesh("organ:500", young_pa=5000)
    >>> model
    <chaincell.Model: 499 cells, 2685 links, checksum ...>
    >>> model.rest_m.shape
    (499, 3)"""
    @staticmethod
    def bake(
        points: npt.ArrayLike,
        tets: npt.ArrayLike | None = None,
        *,
        triangles: npt.ArrayLike | None = None,
        **options: Unpack[BakeOptions],
    ) -> Model:
        """Bakes arrays: a mesh of tetrahedra, or a closed surface that it fills with tetrahedra.

        - `points`: nodes, (nodes, 3), in units of `unit_m` metres.
        - `tets`: corners of the tetrahedra, (tetrahedra, 4), ids of points from 0.
        - `triangles`: corners of a closed surface, (triangles, 3), in place of `tets`, with `fill_m`.
        - `options`: as of `chaincell bake`, with their units, see `chaincell.options.BakeOptions`.

        Raises `ModelError` for a mesh that cannot be baked, `ArgumentError` for a wrong shape or value.

        >>> points = [[0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 10], [10, 10, 10]]  # mm
        >>> tets = [[0, 1, 2, 3], [1, 2, 3, 4]]
        >>> chaincell.Model.bake(points, tets, unit_m=0.001, young_pa=5000, fixed=[0, 1, 2]).cells
        5"""
    @staticmethod
    def bake_mesh(mesh: _Path | object, **options: Unpack[BakeOptions]) -> Model:
        """Bakes a mesh file, a generator, or an object with `points` and `cells` as meshio's.

        - `mesh`: a path; a text such as "organ:500", "box:7x7x5x0.01"; or the object.
        - `options`: as of `chaincell bake`, with their units, see `chaincell.options.BakeOptions`;
          a surface (STL, OBJ, PLY) takes `fill_m`, a file in millimetres `unit_m=0.001`.

        Raises `ModelError` for a mesh that cannot be read or baked, `ArgumentError` for a wrong value.

        >>> chaincell.Model.bake_mesh("box:7x7x5x0.01", young_pa=5000, poisson=0.45).cells
        245"""
    @staticmethod
    def load(path: _Path) -> Model:
        """Reads a model file of `chaincell bake` or `save`, from `path`.

        Raises `ModelError` where the file is missing, damaged, or of another release.

        >>> chaincell.Model.load("liver.chaincell").checksum == model.checksum
        True"""
    @staticmethod
    def from_bytes(image: bytes | bytearray) -> Model:
        """Reads the bytes of a model file; `image` is bytes or a bytearray.

        Raises `ModelError` where they are no model of this release.

        >>> chaincell.Model.from_bytes(bytes(model)).cells == model.cells
        True"""
    def save(self, path: _Path) -> None:
        """Writes the model file to `path`, whole or not at all.

        Raises `ModelError` where it cannot be written.

        >>> model.save("liver.chaincell")"""
    def __bytes__(self) -> bytes: ...
    def __reduce__(self) -> tuple[Any, tuple[bytes]]: ...
    @property
    def image(self) -> npt.NDArray[np.uint8]:
        """Bytes of the model file, uint8 (bytes,): a view that cannot be written."""
    @property
    def cells(self) -> int:
        """Number of cells, the nodes whose positions are computed."""
    @property
    def links(self) -> int:
        """Number of links, the edges between two cells."""
    @property
    def nodes(self) -> int:
        """Number of nodes that results show: that of the cells, without `cells` in the options."""
    @property
    def unit_m(self) -> float:
        """Mean link length [m]."""
    @property
    def checksum(self) -> str:
        """Checksum of the bytes, 8 hexadecimal digits."""
    @property
    def has_contact_surface(self) -> bool:
        """Whether tools such as "probe:0.012" can press on the triangles of the surface."""
    @property
    def node_ids(self) -> _U32:
        """Ids of the nodes that results show, ascending, uint32 (nodes,), a copy."""
    @property
    def rest_m(self) -> npt.NDArray[np.float64]:
        """Positions at rest [m], float64 (nodes, 3), in the order of `node_ids`, a copy."""
    @property
    def fixed(self) -> _U32:
        """Ids of the nodes of fixed cells, ascending, uint32 (fixed,), a copy."""
    @property
    def triangles(self) -> _U32:
        """Ids of the corners of the surface's triangles, counter-clockwise from outside, uint32
        (triangles, 3), a copy."""
    @property
    def tetrahedra(self) -> _U32:
        """Ids of the corners of the tetrahedra, uint32 (tetrahedra, 4), a copy."""
    @property
    def groups(self) -> dict[str, _U32]:
        """Ids of the nodes of each named group of the mesh: name to uint32 (nodes,), copies."""
    def show(self, **options: Any) -> Any:
        """Shows the body at rest by PyVista: in a notebook in place, else in a window.

        `options` go to `pyvista.Plotter.show`, such as `screenshot="body.png"`. Returns what that
        returns. Raises `ImportError` where PyVista is not installed.

        >>> model.show()  # doctest: +SKIP"""

@final
class Tissue:
    """A body with its tools, advanced by `tick` without a server. Threads may share it: each call
    waits for its turn.

    - `model`: a `Model`.
    - `options`: as of `chaincell run`, with their units, see `chaincell.options.TissueOptions`.

    Raises `ArgumentError` for a wrong value, a contact that the model does not have, or `force_error` where no error
    of a force is known.

    >>> tissue = chaincell.Tissue(model, contact="probe:0.012", sweeps=2)
    >>> output = tissue.tick([0.0, 0.0, 0.07])
    >>> tissue.ticks, output.force_n.shape
    (1, (3,))"""
    def __new__(cls, model: Model, **options: Unpack[TissueOptions]) -> Self: ...
    def tick(
        self,
        pose: _Pose,
        engaged: _Engaged = True,
        *,
        opening_rad: npt.ArrayLike | None = None,
        sweeps: int | None = None,
    ) -> Output:
        """Advances the tissue by a millisecond, and returns the `Output`.

        - `pose`: position [m], (3,), or with a unit quaternion x, y, z, w behind it, (7,); of several
          tools (tools, 3) or (tools, 7).
        - `engaged`: whether the tool acts on the tissue; of several tools (tools,).
        - `opening_rad`: opening angle of scissors [rad], 0 to pi; of several tools (tools,). Closed by default.
        - `sweeps`: repeats a tick of a session that made fewer sweeps than `sweeps` of the tissue.

        Raises `PoseError` for a pose that is none, `ArgumentError` for other values; no tick is made then.

        >>> tissue.tick([0.0, 0.0, 0.05], engaged=True).force_n.shape
        (3,)"""
    def reset(self) -> None:
        """Puts the tissue back to rest, its tools released.

        >>> tissue.reset()
        >>> tissue.ticks
        0"""
    def grip(self, tool: int = 0) -> None:
        """Makes a tool hold what it touches, until it lets go or is not engaged.

        `tool` is its number from 0. Raises `Refused` where it touches nothing.

        >>> tissue.grip()"""
    def let_go(self, tool: int = 0, ticks: int = 20) -> None:
        """Makes a tool let go; its pull falls to 0.

        - `tool`: its number from 0.
        - `ticks`: length of the fall in ticks, 1 to 65,535.

        Raises `Refused` where it holds nothing.

        >>> tissue.grip()
        >>> tissue.let_go(ticks=20)"""
    def pin_at(
        self, point_m: npt.ArrayLike, radius_m: float, stiffness_n_per_m: float | None = None
    ) -> int:
        """Pins the surface around a point where it is now: it is held in the world. Returns the pin's number.

        - `point_m`: the point [m], (3,).
        - `radius_m`: radius around it [m].
        - `stiffness_n_per_m`: stiffness of the pin [N/m]; rigid by default.

        Pinning makes no force. Raises `Refused` where no surface is near enough, or without tools.

        >>> pin = tissue.pin_at([0.0, 0.0, 0.05], 0.02)
        >>> pin in tissue.pins
        True"""
    def pin(self, tool: int = 0, stiffness_n_per_m: float | None = None) -> int:
        """Pins what a tool grips, or what it touches, where it is now. Returns the pin's number.

        - `tool`: its number from 0. It keeps its grip: `let_go` passes its pull to the pin.
        - `stiffness_n_per_m`: stiffness of the pin [N/m]; rigid by default.

        Raises `Refused` where it touches nothing.

        >>> pin = tissue.pin(tool=0)"""
    def unpin(self, pin: int, ticks: int = 20) -> None:
        """Releases a pin; its force falls to 0, and it is gone.

        - `pin`: its number.
        - `ticks`: length of the fall in ticks, 1 to 65,535.

        Raises `Refused` where no pin has this number.

        >>> tissue.unpin(tissue.pin(), ticks=20)"""
    def pin_force_n(self, pin: int) -> npt.NDArray[np.float64] | None:
        """Force of the tissue on a pin [N], float64 (3,); None without such a pin.

        `pin` is its number.

        >>> tissue.pin_force_n(tissue.pin())
        array([0., 0., 0.])"""
    @property
    def pins(self) -> list[int]:
        """The numbers of the pins, in the order in which they were set.

        >>> pins = tissue.pins"""
    def snapshot(self) -> bytes:
        """Returns the whole state as bytes, for `restore`.

        >>> saved = tissue.snapshot()"""
    def restore(self, snapshot: bytes | bytearray) -> None:
        """Takes over the state of a `snapshot`, bytes, of a tissue with the same model and options.

        Raises `SnapshotError` where it is damaged, or of another model, options or release.

        >>> tissue.restore(tissue.snapshot())"""
    def stress(self) -> Stress | None:
        """Returns strain and stress at the nodes, as `Stress`; None for a body of links.

        A tick computes none of it; the call takes as long as some twenty ticks.

        >>> tissue.stress().stretches.shape == tissue.positions_m.shape
        True"""
    def surface(self) -> Surface | None:
        """Returns the surface as it is cut now, as `Surface`; None for a model that cannot be cut.

        >>> tissue.surface() is None
        True"""
    def contacts(self) -> Contacts:
        """Returns what the tools touch, as `Contacts`; nothing for held cells.

        >>> len(tissue.contacts()) > 0
        True"""
    @property
    def model(self) -> Model:
        """The `Model` of the body."""
    def opening_torque_n_m(self, tool: int = 0) -> float | None:
        """Torque of the tissue on the handles of a tool's scissors in the last tick [N m]; None without scissors.

        `tool` is its number from 0. Above 0 it resists closing.

        >>> tissue.opening_torque_n_m() is None
        True"""
    @property
    def ticks(self) -> int:
        """Number of ticks since it was at rest."""
    @property
    def state_hash(self) -> str:
        """Hash of the state, 16 hexadecimal digits: of equal states alone it is equal."""
    @property
    def cuts(self) -> dict[str, float] | None:
        """Cuts since it was at rest, by the names of `chaincell run`; None for a model that cannot be cut.

        `cut_area_m2` is the area that blades have swept [m2], `cut_work_j` the work that it took to part the tissue
        there [J]; `opened_faces` counts the faces between tetrahedra that are open, `copied_cells` the copies of
        split cells, `refused_splits` the splits for which there was no spare cell, `loose_pieces` the pieces that
        hang on no fixed cell, `loose_cells` their cells. Of a model that tears `torn_cells` counts the cells at which
        it has torn by itself.

        >>> tissue.cuts is None
        True"""
    @property
    def relaxed_j(self) -> float | None:
        """Energy that its branches have relaxed since it was at rest [J]; None for a model baked without branches.

        >>> tissue.relaxed_j is None
        True"""
    @property
    def positions_m(self) -> _F32:
        """Positions of the nodes [m], float32 (nodes, 3), in the order of `Model.node_ids`, a copy."""

@final
class Output:
    """The answer of a tick; its arrays are copies.

    >>> tissue.tick([0.0, 0.0, 0.05]).sweeps
    2"""
    @property
    def tick(self) -> int:
        """Number of the tick, from 1."""
    @property
    def force_n(self) -> _F32:
        """Force of the tissue on the tool [N], float32 (3,), or on each of several, (tools, 3)."""
    @property
    def torque_n_m(self) -> _F32:
        """Torque on the tool about its position [N m], float32 (3,), or on each of several, (tools, 3)."""
    @property
    def force_error_n(self) -> list[float | None]:
        """Estimated distance of each tool's force, of held cells one, from that of the body in equilibrium [N]: within it
        are 99 of 100 errors. None where it is not known: away from the tissue, in a tick whose motion is shortened, in
        late ticks after one, a release or a restore and of cells held in a body that relaxes, where an output stage
        changes the force, under another scheme than predict, and for a model of links, cut, or without a coarse
        level."""
    @property
    def torque_error_n_m(self) -> list[float | None]:
        """Estimated distance of each tool's torque from that of the body in equilibrium [N m], likewise; None for held
        cells too."""
    @property
    def energy_j(self) -> float:
        """Certified upper bound of the elastic energy [J]."""
    @property
    def work_j(self) -> float:
        """Work of the tool's motion on the tissue [J]."""
    @property
    def stiffness_n_per_m(self) -> float:
        """Upper bound of the stiffness that the tool meets within a tick [N/m]."""
    @property
    def contacts(self) -> int:
        """Number of held cells, or of triangles in contact with a tool."""
    @property
    def sweeps(self) -> int:
        """Number of sweeps made, 0 in a late tick."""
    @property
    def flags(self) -> Flags:
        """Limits and faults that acted during the tick, `Flags`."""

@final
class Run:
    """The result of `run`: a row for each tick. A tick is a millisecond; arrays are copies.

    >>> result = chaincell.run(model, path_m, contact="probe:0.012", sweeps=2)
    >>> len(result), result.force_n.shape, result.positions_m.shape
    (100, (100, 3), (499, 3))"""
    def __len__(self) -> int: ...
    @property
    def model(self) -> Model:
        """The `Model` of the body."""
    @property
    def path_m(self) -> _F32:
        """Positions of the tool [m], float32 (ticks, 3), or of the tools of the path, (ticks, tools, 3)."""
    @property
    def positions_m(self) -> _F32:
        """Positions of the nodes after the last tick [m], float32 (nodes, 3), in the order of
        `Model.node_ids`."""
    def plot_force(
        self, axes: Any = None, *, against: Literal["time", "depth"] = "time"
    ) -> Any:
        """Draws the magnitude of the force [N] by matplotlib, a line for each tool, and returns the axes.

        - `axes`: where to draw; None for new ones.
        - `against`: "time" [ms], or "depth" [mm], the distance from where a tool first touched.

        Raises `ArgumentError` for another word, `ImportError` where matplotlib is not installed.

        >>> result.plot_force(against="depth")  # doctest: +SKIP"""
    def show(self, **options: Any) -> Any:
        """Shows the body after the last tick by PyVista, coloured by displacement: in a notebook in place,
        else in a window.

        `options` go to `pyvista.Plotter.show`, such as `screenshot="press.png"`. Returns what that
        returns. Raises `ImportError` where PyVista is not installed.

        >>> result.show()  # doctest: +SKIP"""
    @property
    def force_n(self) -> _F32:
        """Forces on the tool [N], float32 (ticks, 3), or on several, (ticks, tools, 3)."""
    @property
    def torque_n_m(self) -> _F32:
        """Torques about the tool's position [N m], float32, of the shape of `force_n`."""
    @property
    def energy_j(self) -> _F32:
        """Certified upper bounds of the elastic energy [J], float32 (ticks,)."""
    @property
    def work_j(self) -> _F32:
        """Work of the tool's motion on the tissue in each tick [J], float32 (ticks,)."""
    @property
    def contacts(self) -> _U32:
        """Numbers of held cells, or of triangles in contact with a tool, uint32 (ticks,)."""
    @property
    def sweeps(self) -> npt.NDArray[np.uint16]:
        """Numbers of sweeps made, uint16 (ticks,)."""
    @property
    def flags(self) -> _U32:
        """Limits and faults that acted, sums of `Flags`, uint32 (ticks,)."""
    @property
    def state_hash(self) -> str:
        """Hash of the state after the last tick, 16 hexadecimal digits."""

def run(
    model: Model,
    path: npt.ArrayLike,
    engaged: npt.ArrayLike | None = None,
    *,
    opening_rad: npt.ArrayLike | None = None,
    sweeps_made: npt.ArrayLike | None = None,
    **options: Unpack[TissueOptions],
) -> Run:
    """Plays a path through a tissue at rest, without a server, and returns the `Run`. Ctrl-C ends it.

    - `model`: a `Model`.
    - `path`: positions [m], (ticks, 3), or with unit quaternions x, y, z, w, (ticks, 7); of several
      tools (ticks, tools, 3) or (ticks, tools, 7). A row is a millisecond.
    - `engaged`: whether the tool acts on the tissue, (ticks,) or (ticks, tools); True by default.
    - `opening_rad`: opening angle of scissors [rad], (ticks,) or (ticks, tools); closed by default.
    - `sweeps_made`: numbers of sweeps of a session that ended ticks early, (ticks,); they go before `force_error`.
    - `options`: as of `chaincell run`, with their units, see `chaincell.options.TissueOptions`.

    Raises `PoseError` for a path that is none, `ArgumentError` for other wrong values.

    >>> path_m = np.linspace([0, 0, 0.08], [0, 0, 0.05], 100)
    >>> result = chaincell.run(model, path_m, contact="probe:0.012", sweeps=2)
    >>> bool(np.linalg.norm(result.force_n, axis=1).max() > 0.01)
    True"""

@final
class Stress:
    """Strain and stress of tissue at its nodes after a tick, in the order of `Model.node_ids`. Arrays are copies.

    >>> stress = tissue.stress()
    >>> stress.von_mises_pa.shape == model.node_ids.shape
    True"""
    def __len__(self) -> int: ...
    @property
    def tick(self) -> int:
        """Number of the tick."""
    @property
    def stretches(self) -> _F32:
        """Principal stretches, the largest first, float32 (nodes, 3)."""
    @property
    def cauchy_pa(self) -> _F32:
        """Cauchy stress xx, yy, zz, xy, yz, xz [Pa], above 0 where the tissue is pulled, float32 (nodes, 6)."""
    @property
    def von_mises_pa(self) -> _F32:
        """Stress after von Mises [Pa]: that of a bar under tension is its tension, float32 (nodes,)."""
    @property
    def mean_pa(self) -> _F32:
        """Mean stress [Pa], below 0 where the tissue is pressed from all sides, float32 (nodes,)."""

@final
class Surface:
    """The surface of a body as it is cut after a tick, from `Tissue.surface`: the nodes, the copies of those that cuts
    have split, and triangles between them. Arrays are copies.

    >>> options = dict(young_pa=5000, poisson=0.4, cuttable=True, cut_spare=0.3, toughness_j_per_m2=10)
    >>> slab = chaincell.Model.bake_mesh("box:5x5x4x0.01", **options)
    >>> cutter = chaincell.Tissue(slab, tools=["blade:0.032"])
    >>> for z_m in np.linspace(0.0305, 0.0155, 150):
    ...     output = cutter.tick([0.0, 0.0, z_m])
    >>> surface = cutter.surface()
    >>> len(surface.triangles) > len(slab.triangles)
    True
    >>> corners_m = surface.positions_m[surface.triangles]  # to draw
    >>> height_m = slab.rest_m[surface.origins, 2]  # at rest, for colours
    >>> height_m.shape == (slab.nodes + cutter.cuts["copied_cells"],) == surface.positions_m.shape[:1]
    True"""
    @property
    def tick(self) -> int:
        """Number of the tick."""
    @property
    def positions_m(self) -> _F32:
        """Positions of the nodes [m] in the order of `Model.node_ids`, and of the copies after them, float32
        (nodes + copies, 3)."""
    @property
    def origins(self) -> _U32:
        """The node that each node is and each copy was made from: its place in `Model.node_ids`, uint32
        (nodes + copies,)."""
    @property
    def triangles(self) -> _U32:
        """Corners of the triangles, counter-clockwise from outside: rows of `positions_m`, uint32 (triangles, 3). They
        begin with those of `Model.triangles`, in its order. One of a piece that is gone (`loose="drop"`) has three
        times the same corner."""

@final
class SessionStress:
    """Strain and stress of the tissue of a running scene, from `Session.stress`, a row for each node by ascending id: of
    one pass over the body, in `first_tick` to `tick`. A node that a cut has parted has the values of the side with
    the largest stress after von Mises. Arrays are copies.

    >>> stress = session.stress()
    >>> stress.von_mises_pa.shape == stress.node_ids.shape
    True"""
    def __len__(self) -> int: ...
    @property
    def tick(self) -> int:
        """Number of the last answered tick at the end of the pass, 0 before the first."""
    @property
    def first_tick(self) -> int:
        """Number of the last answered tick at its begin."""
    @property
    def node_ids(self) -> _U32:
        """Ids of the nodes, ascending, uint32 (nodes,)."""
    @property
    def stretches(self) -> _F32:
        """Principal stretches, the largest first, float32 (nodes, 3)."""
    @property
    def von_mises_pa(self) -> _F32:
        """Stress after von Mises [Pa]: that of a bar under tension is its tension, float32 (nodes,)."""
    @property
    def mean_pa(self) -> _F32:
        """Mean stress [Pa], below 0 where the tissue is pressed from all sides, float32 (nodes,)."""

@final
class Contacts:
    """What tools touched in a tick, a row for each triangle and part of a tool. Arrays are copies.

    >>> contacts = tissue.contacts()
    >>> contacts.positions_m.shape == (len(contacts), 3)
    True"""
    def __len__(self) -> int: ...
    @property
    def tick(self) -> int:
        """Number of the tick."""
    @property
    def tools(self) -> _U32:
        """Number of the tool, uint32 (contacts,)."""
    @property
    def parts(self) -> _U32:
        """Number of its part, uint32 (contacts,)."""
    @property
    def node_ids(self) -> _U32:
        """Id of the triangle's corner that takes the largest share, uint32 (contacts,)."""
    @property
    def positions_m(self) -> _F32:
        """Position at which the force acts [m], float32 (contacts, 3)."""
    @property
    def normal_n(self) -> _F32:
        """Normal force on the tool [N], float32 (contacts, 3)."""
    @property
    def tangential_n(self) -> _F32:
        """Friction, or the pull of a grip, on the tool [N], float32 (contacts, 3)."""
    @property
    def area_m2(self) -> _F32:
        """Area of the triangle at rest, as far as it is in contact [m2], float32 (contacts,)."""

@final
class State:
    """A state of a running scene, from `Session.state`. Its arrays are views into shared memory that
    cannot be written; the message stays there until the state and its arrays are gone.

    >>> state = session.state()
    >>> state.positions_m.shape == (len(state), 3)
    True"""
    def __len__(self) -> int: ...
    @property
    def tick(self) -> int:
        """Number of the last answered tick, 0 before the first."""
    @property
    def ticks_answered(self) -> int:
        """Number of ticks answered since the server began."""
    @property
    def state_hash(self) -> str:
        """Hash of the state, 16 hexadecimal digits."""
    @property
    def model_checksum(self) -> str:
        """Checksum of the server's model, 8 hexadecimal digits, as `Model.checksum`."""
    @property
    def flags(self) -> Flags:
        """Limits and faults of the last answer, `Flags`."""
    @property
    def node_ids(self) -> _U32:
        """Ids of the nodes, ascending, uint32 (nodes,), a view."""
    @property
    def positions_m(self) -> _F32:
        """Positions of the nodes [m], float32 (nodes, 3), in the order of `node_ids`, a view."""

@final
class Session:
    """A handle on a running scene of `chaincell serve`: its controller, or a viewer. Threads may share it:
    each call waits for its turn. `with` closes it.

    - `scene`: the name after `--scene`; None for the unnamed one.
    - `role`: "controller", which sends poses, or "viewer", which looks and commands.
    - `wait`: how a step waits for its answer, "hybrid", "spin" or "event".
    - `server_wait_s`: longest wait for the server [s].
    - `watchdog_ms`, `ramp_ms`: time without an answer after which the force falls, and that of the
      fall [ms].
    - `lost_s`: time without an answer after which a step raises `NoServer` [s]; None for never.

    Raises `NoServer` without a server in time, `Taken` beside another controller, `Full`,
    `OtherVersion` or `NoPermission`.

    >>> session = chaincell.Session("left")
    >>> force_n = session.step([0.0, 0.0, 0.08], engaged=False)  # first released
    >>> force_n.shape
    (3,)"""
    def __new__(
        cls,
        scene: str | None = None,
        *,
        role: Literal["controller", "viewer"] = "controller",
        wait: Literal["hybrid", "spin", "event"] = "hybrid",
        server_wait_s: float = 10.0,
        watchdog_ms: int = 20,
        ramp_ms: int = 20,
        lost_s: float | None = 1.0,
    ) -> Self: ...
    def __enter__(self) -> Self: ...
    def __exit__(
        self,
        *_why: type[BaseException] | BaseException | TracebackType | None,
    ) -> None: ...
    def step(
        self,
        pose: _Pose,
        engaged: _Engaged = True,
        *,
        opening_rad: npt.ArrayLike | None = None,
        timeout_s: float = 0.02,
    ) -> _F32:
        """Sends the pose of the tool, or of several, and returns the force to show [N], float32 (3,), or
        (tools, 3).

        - `pose`: position [m], (3,), or with a unit quaternion x, y, z, w behind it, (7,); of several
          tools (tools, 3) or (tools, 7).
        - `engaged`: whether the tool acts on the tissue; of several tools (tools,). A tool has no force
          until one of its poses was not engaged.
        - `opening_rad`: opening angle of scissors [rad], 0 to pi; of several tools (tools,). Closed by default.
        - `timeout_s`: longest wait for the answer to this pose [s].

        Raises `PoseError` for a pose that is none, and nothing is sent then; `NoServer` after `lost_s`
        without an answer; `Closed`.

        >>> force_n = session.step([0.0, 0.0, 0.0795])"""
    def state(self, timeout_s: float = 1.0) -> State | None:
        """Returns the newest `State` that was not taken yet; None where none comes within `timeout_s` [s].

        Raises `Full` where two states are still held, `Closed`.

        >>> state = session.state(timeout_s=1.0)"""
    def contacts(self, timeout_s: float = 1.0) -> Contacts | None:
        """Returns the newest `Contacts` that were not taken yet; None where none come within `timeout_s`
        [s]. Raises `Closed`.

        >>> contacts = session.contacts(timeout_s=1.0)"""
    def stress(self, timeout_s: float = 1.0) -> SessionStress | None:
        """Returns the newest `SessionStress` that was not taken yet; None where none comes within `timeout_s` [s]. The
        server computes it only while it is read, and not of a body of links. Raises `Closed`.

        >>> stress = session.stress(timeout_s=1.0)"""
    def pause(self, *, timeout_s: float = 5.0) -> Reply:
        """Pauses: poses are answered with force 0 from here on, and no cell moves.

        Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].

        >>> reply = session.pause()"""
    def resume(self, *, timeout_s: float = 5.0) -> Reply:
        """Goes on after a pause.

        Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].

        >>> reply = session.resume()"""
    def reset(self, *, timeout_s: float = 5.0) -> Reply:
        """Puts the tissue back to rest, its tools released.

        Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].

        >>> reply = session.reset()"""
    def snapshot(self, *, timeout_s: float = 5.0) -> Reply:
        """Saves the session beside its trace, as TRACE.TICK.snapshot; the server needs `--record`.

        Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].

        >>> reply = session.snapshot()"""
    def grip(self, tool: int = 0, *, timeout_s: float = 5.0) -> Reply:
        """Makes a tool, by its number from 0, hold what it touches.

        `tool` is the number. Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s`
        [s].

        >>> try:
        ...     session.grip(tool=0)
        ... except chaincell.Refused:
        ...     print("it touches nothing")
        it touches nothing"""
    def let_go(
        self, tool: int = 0, ticks: int = 20, *, timeout_s: float = 5.0
    ) -> Reply:
        """Makes a tool let go; its pull falls to 0.

        - `tool`: its number from 0.
        - `ticks`: length of the fall in ticks, 1 to 65,535.

        Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].

        >>> try:
        ...     session.let_go(tool=0, ticks=20)
        ... except chaincell.Refused:
        ...     print("it holds nothing")
        it holds nothing"""
    def pin(
        self,
        tool: int = 0,
        stiffness_n_per_m: float | None = None,
        *,
        timeout_s: float = 5.0,
    ) -> Reply:
        """Pins what a tool grips, or what it touches, where it is now: it is held in the world.

        - `tool`: its number from 0.
        - `stiffness_n_per_m`: stiffness of the pin [N/m]; rigid by default.

        The pin takes the lowest free number, from 0, which `pin` of the reply is.
        Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].

        >>> try:
        ...     session.pin(tool=0)
        ... except chaincell.Refused:
        ...     print("it touches nothing")
        it touches nothing"""
    def pin_at(
        self,
        point_m: npt.ArrayLike,
        radius_m: float,
        stiffness_n_per_m: float | None = None,
        *,
        timeout_s: float = 5.0,
    ) -> Reply:
        """Pins the surface around a point where it is now: it is held in the world.

        - `point_m`: the point [m], (3,).
        - `radius_m`: radius around it [m].
        - `stiffness_n_per_m`: stiffness of the pin [N/m]; rigid by default.

        The pin takes the lowest free number, from 0, which `pin` of the reply is.
        Raises `Refused` where no surface is near enough, or the server has no tools, `NoReply` without a reply within
        `timeout_s` [s].

        >>> try:
        ...     session.pin_at([0.0, 0.0, 1.0], 0.005)
        ... except chaincell.Refused:
        ...     print("no surface is near")
        no surface is near"""
    def unpin(self, pin: int, ticks: int = 20, *, timeout_s: float = 5.0) -> Reply:
        """Releases a pin; its force falls to 0, and it is gone.

        - `pin`: its number.
        - `ticks`: length of the fall in ticks, 1 to 65,535.

        Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].

        >>> try:
        ...     session.unpin(0, ticks=20)
        ... except chaincell.Refused:
        ...     print("there is no such pin")
        there is no such pin"""
    def set(
        self,
        *,
        sweeps: int | None = None,
        max_force_n: float | None = None,
        max_tool_step_m: float | None = None,
        unloading: Literal["off", "release", "retreat"] | None = None,
        cut: Literal["on", "off"] | None = None,
        timeout_s: float = 5.0,
    ) -> Reply:
        """Sets one parameter of the tissue.

        - `sweeps`: sweeps of a tick, from 1 on.
        - `max_force_n`: largest force [N], inf for no limit.
        - `max_tool_step_m`: largest motion of held cells in a tick [m].
        - `unloading`: "off", "release" or "retreat".
        - `cut`: "on" or "off", whether blades cut and bodies tear.

        Raises `TypeError` for none or several of them, `ArgumentError` for a value out of range.
        Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].

        >>> reply = session.set(sweeps=6)"""
    def close(self) -> None:
        """Leaves the scene; a second time it does nothing.

        >>> session.close()"""
    @property
    def scene(self) -> str | None:
        """Name of the scene, None for the unnamed one."""
    @property
    def answer(self) -> Answer | None:
        """The whole `Answer` to the last step; None before the first."""
    @property
    def is_served(self) -> bool:
        """Whether a server is registered on the scene; one that was killed may be for a while."""
    @property
    def is_closed(self) -> bool:
        """Whether the session was closed."""
    @property
    def silences(self) -> tuple[int, int]:
        """Number of times that no answer came for the watchdog's time, and of answers to somebody else."""

@final
class Answer:
    """The whole answer to a step of a session, from `Session.answer`; its arrays are copies.

    >>> answer = session.answer
    >>> answer.force_n.shape
    (3,)"""
    @property
    def outcome(self) -> Literal["answered", "no answer", "silent"]:
        """"answered", "no answer" (the last force counts) or "silent" (the force falls to 0, or is 0)."""
    @property
    def force_n(self) -> _F32:
        """Force to show [N], float32 (3,), or of each of several tools, (tools, 3)."""
    @property
    def torque_n_m(self) -> _F32:
        """Torque on the tool about its position [N m], float32 (3,), or on each of several, (tools, 3)."""
    @property
    def force_error_n(self) -> list[float | None]:
        """Estimated error of the force on each tool [N], before its limit; None where it is not known, where an output
        stage answers another force than the tissue's, and while another force than the server's is shown."""
    @property
    def torque_error_n_m(self) -> list[float | None]:
        """Estimated error of the torque on each tool [N m], likewise; None for held cells too."""
    @property
    def contacts(self) -> int:
        """Number of held cells, or of triangles in contact with a tool."""
    @property
    def tool_flags(self) -> list[Flags]:
        """Limits and faults that acted at each tool, a list of `Flags`."""
    @property
    def flags(self) -> Flags:
        """Limits and faults that acted during the tick, `Flags`."""
    @property
    def notes(self) -> Notes:
        """Notes of the client itself, `Notes`."""
    @property
    def tick(self) -> int:
        """Number of the tick answered last, 0 before the first."""
    @property
    def force_tick(self) -> int:
        """Number of the tick whose pose the force is of."""
    @property
    def answers(self) -> int:
        """Number of answers since the session was opened."""
    @property
    def session_id(self) -> int:
        """Number of the server's session, another one for each."""
    @property
    def state_hash(self) -> str | None:
        """Hash of the state after the tick, 16 hexadecimal digits; None where none was taken."""
    @property
    def energy_j(self) -> float:
        """Certified upper bound of the elastic energy [J]."""
    @property
    def sweeps(self) -> int:
        """Number of sweeps made in the tick, 0 in a late one."""
    @property
    def step_ns(self) -> int:
        """Time that the tick took the server [ns]."""
    @property
    def round_trip_ns(self) -> int:
        """Time from sending the pose to its answer [ns]."""
    @property
    def age_ns(self) -> int:
        """Time since the answer came [ns]."""

@final
class Reply:
    """The reply to a command of a session.

    >>> reply = session.reset()
    >>> len(reply.state_hash)
    16"""
    @property
    def tick(self) -> int:
        """Number of the last tick answered before the command, 0 before the first."""
    @property
    def ticks_answered(self) -> int:
        """Number of ticks answered before the command since the server began."""
    @property
    def state_hash(self) -> str:
        """Hash of the state after the command, 16 hexadecimal digits."""
    @property
    def pin(self) -> int | None:
        """Number of the pin that the command set; `None` for other commands."""

@final
class Rate:
    """A loop at a fixed rate: gives 0, 1, 2 and so on, each at its moment, and leaves none out. A turn
    that is more than a period late begins at once and moves the schedule: a server sleeps until a pose
    is due, so poses that caught up would be answered late, and dropped beyond 2,000 a second.

    - `hz`: turns a second, 0.001 to 1,000,000.
    - `ticks` or `seconds`: number of turns, or length [s]; without both it has no end.

    Raises `ArgumentError` for values out of range.

    >>> [turn for turn in chaincell.Rate(1000, ticks=3)]
    [0, 1, 2]"""
    def __new__(
        cls,
        hz: float = 1000.0,
        *,
        ticks: int | None = None,
        seconds: float | None = None,
    ) -> Self: ...
    def __iter__(self) -> Self: ...
    def __next__(self) -> int: ...
    @property
    def late(self) -> int:
        """Number of turns that began more than a period late."""

def bake_options() -> Sequence[str]: ...
def tissue_options() -> Sequence[str]: ...
