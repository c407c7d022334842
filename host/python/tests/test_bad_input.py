"""What is wrong is told in one sentence with the place and the remedy, and changes nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
from conftest import press

import chaincell
from chaincell import ArgumentError, Model, ModelError, PoseError, SnapshotError, Tissue
from chaincell._native import bake_options, tissue_options
from chaincell.options import BakeOptions, TissueOptions

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 0.01
TETS = np.array([[0, 1, 2, 3]])


def bake(points: object = POINTS, tets: object = TETS, **options: object) -> Callable[[], object]:
    return lambda: Model.bake(points, tets, **options)


def changed(values: np.ndarray, at: object, value: object) -> np.ndarray:
    values = values.copy()
    values[at] = value
    return values


def mesh(points: object = POINTS, **rest: object) -> Callable[[], object]:
    return lambda: Model.bake_mesh(SimpleNamespace(points=points, **rest))


BAKES: list[tuple[Callable[[], object], type[Exception], str]] = [
    (bake(POINTS[:, :2]), ArgumentError, r"`points`: its shape is \(4, 2\), it must be \(n, 3\)"),
    (bake(POINTS.ravel()), ArgumentError, r"`points`: its shape is \(12,\)"),
    (bake(POINTS.astype(complex)), TypeError, "`points`: give real numbers.*complex128"),
    (bake("points"), TypeError, "`points`: give real numbers"),
    (bake(None), TypeError, "`points`: give real numbers"),
    (bake([[0, 0, 0], [1]]), ArgumentError, "`points`: it is no array"),
    (bake(changed(POINTS, (2, 1), np.nan)), ModelError, "node 2 is at .*NaN"),
    (bake(changed(POINTS, (1, 0), np.inf)), ModelError, "node 1 is at"),
    (bake(changed(POINTS, (1, 0), 1e300)), ModelError, "node 1 is at"),
    (bake(POINTS * 0), ModelError, "all 4 cells are at"),
    (bake(tets=TETS.astype(float)), TypeError, "`tets`: give whole numbers.*float64"),
    (bake(tets=TETS[:, :3]), ArgumentError, r"`tets`: its shape is \(1, 3\)"),
    (bake(tets=[]), ArgumentError, r"`tets`: its shape is \(0,\)"),
    (bake(tets=np.zeros((0, 4), int)), ModelError, "no links"),
    (bake(tets=changed(TETS, (0, 2), 4)), ModelError, "tetrahedron 0 has node 4.*4 nodes"),
    (bake(tets=changed(TETS, (0, 2), -1)), ArgumentError, "`tets`: -1 is no id"),
    (bake(tets=changed(TETS, (0, 2), 2**40)), ArgumentError, "`tets`: 1099511627776 is no id"),
    (bake(tets=changed(TETS, (0, 2), 1)), ModelError, "tetrahedron 0 has a node twice"),
    (bake(fixed=[9]), ModelError, "`fixed`: node 9, and there are 4 nodes"),
    (bake(fixed=[-1]), ArgumentError, "`fixed`: -1 is no id"),
    (bake(fixed=[0.5]), TypeError, "`fixed`: give whole numbers"),
    (bake(fixed=[[0]]), ArgumentError, r"`fixed`: its shape is \(1, 1\)"),
    (bake(fixed=[True, False]), ArgumentError, r"`fixed`: its shape is \(2,\), it must be \(4,\)"),
    (bake(fixed="group:top"), ModelError, "`fixed` group:top: the mesh has no group 'top'"),
    (bake(young_pa=np.nan), ModelError, "`young_pa` NaN"),
    (bake(young_pa=[1, 2]), ArgumentError, r"`young_pa`: its shape is \(2,\), it must be \(4,\)"),
    (bake(young_pa=[1, 2, np.nan, 4]), ModelError, "`young_pa`: value NaN of node 2"),
    (bake(young_pa="soft"), ModelError, "`young_pa`: `soft` is no number"),
    (bake(young_pa=5000, poisson=0.5), ModelError, "`poisson` 0.5: must be from 0 to 0.495"),
    (bake(young_pa=5000, alpha=0.1), ModelError, "`alpha` is for links"),
    (bake(young_pa=5000, stretch_min=2.0), ModelError, "`stretch_min` 2: must be"),
    (bake(young_pa=5000, stiffening=[1]), TypeError, "`stiffening`: give a dict"),
    (bake(young_pa=5000, stiffening={(1,): 1}), TypeError, "`stiffening`: give numbers"),
    (bake(young_pa=5000, stiffening={"a": 1}), ModelError, "`stiffening` a: give a half-width"),
    (bake(poisson=0.4), ModelError, "`poisson` goes with `young_pa`"),
    (bake(unit_m=0), ModelError, "`unit_m` 0: must be above 0"),
    (bake(k_m=1e-9), ModelError, "`k_m`"),
    (bake(r_x=-1), ModelError, "`r_x` -1"),
    (bake(coarse=0.1), ModelError, "`coarse` 0.1"),
    (bake(cells=5), ModelError, "`cells` 5: must be from 2 to 4, the nodes of the mesh"),
    (bake(lean=1), TypeError, "`lean`: give True or False, not int"),
    (bake(contact_surface="edges"), ModelError, '`contact_surface` "edges": give auto or yes or no'),
    (bake(diagonals=True), ModelError, "`diagonals` is for a plane"),
    (bake(young=1), TypeError, "unexpected keyword argument 'young'; there are .*young_pa"),
    (lambda: Model.bake_mesh(7), TypeError, "`mesh`: give a path, a generator .*not int"),
    (lambda: Model.bake_mesh("nowhere.msh"), ModelError, "cannot open mesh nowhere.msh"),
    (lambda: Model.bake_mesh("nowhere.stl", fill_m=0.01), ModelError, "nowhere.stl"),
    (lambda: Model.bake_mesh("organ:500", fill_m=0.01), ModelError, "`fill_m` fills the closed surface"),
    (lambda: Model.bake_mesh("organ:3"), ModelError, "organ"),
    (mesh(), TypeError, "`mesh`: give a path"),
    (mesh(cells=7), TypeError, "`mesh.cells`: give a list as meshio"),
    (mesh(cells=np.arange(5)), TypeError, "`mesh.cells`: give pairs as meshio"),
    (mesh(cells={10: TETS}), TypeError, "`mesh.cells`: give types by their names"),
    (mesh(cells=[("tetra", TETS)], cell_sets={"a": 7}), TypeError, "`mesh.cell_sets`: give a list"),
    (mesh(cells=[("tetra", TETS)], point_sets={1: [0]}), TypeError, "`mesh.point_sets`: give names, not int"),
    (mesh(cells=[]), ModelError, "no links"),
    (mesh(cells=[("hexahedron", [[0] * 8])]), ModelError, "type hexahedron: only first-order"),
    (mesh(cells=[("tetra10", [[0] * 10])]), ModelError, "type tetra10: only first-order"),
    (mesh(cells=[("tetra", TETS)], point_sets={"a": [9]}), ModelError, "group a has node 9"),
    (mesh(cells=[("tetra", TETS)], cell_sets={"a": [[3]]}), ModelError, "cell 3 of type tetra"),
]


@pytest.mark.parametrize(("act", "error", "text"), BAKES, ids=[text for _, _, text in BAKES])
def test_bad_meshes(act: Callable[[], object], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text) as raised:
        act()
    assert type(raised.value) is error and "\n" not in str(raised.value)


def test_bad_model_files(plane: Model, tmp_path: Path) -> None:
    image, file = bytes(plane), tmp_path / "bad.chaincell"
    newer = bytearray(image)
    newer[8] ^= 0x40
    wrongs = [(b"", "."), (image[: len(image) // 2], "truncated"), (image[:-1], "."), (bytes(newer), "version")]
    for wrong, text in wrongs:
        file.write_bytes(wrong)
        with pytest.raises(ModelError, match=f"bad.chaincell.*{text}"):
            Model.load(file)
        with pytest.raises(ModelError, match=text):
            Model.from_bytes(wrong)
    for at in range(0, len(image), 97):
        flipped = bytearray(image)
        flipped[at] ^= 1
        with pytest.raises(ModelError):
            Model.from_bytes(flipped)
    with pytest.raises(ModelError, match="nowhere"):
        Model.load(tmp_path / "nowhere")
    with pytest.raises(ModelError):
        plane.save(tmp_path)
    with pytest.raises(TypeError):
        Model.from_bytes("text")


def test_half_a_mesh_file(tmp_path: Path) -> None:
    whole, half = tmp_path / "whole.msh", tmp_path / "half.msh"
    box = Model.bake_mesh("box:3x3x3x0.01")
    meshio.Mesh(box.rest_m, [("tetra", box.tetrahedra.astype(int))]).write(whole, file_format="gmsh")
    Model.bake_mesh(whole)
    half.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    with pytest.raises(ModelError, match="half.msh"):
        Model.bake_mesh(half)


TISSUES: list[tuple[dict[str, object], type[Exception], str]] = [
    ({"contact": "probe"}, ArgumentError, "`contact` probe: give its radius"),
    ({"contact": "probe:-1"}, ArgumentError, "must be above 0"),
    ({"contact": "probe:nan"}, ArgumentError, "must be above 0"),
    ({"contact": [0]}, ArgumentError, "`contact`: node 0 is fixed"),
    ({"contact": [999]}, ArgumentError, "`contact` .*999"),
    ({"contact": []}, ArgumentError, r"`contact`: its shape is \(0,\)"),
    ({"contact": [40.5]}, TypeError, "`contact`: give whole numbers"),
    ({"sweeps": 0}, ArgumentError, "`sweeps` 0: must be from 1 to 65535"),
    ({"sweeps": "many"}, ArgumentError, "'many' for `sweeps`"),
    ({"sweeps": True}, TypeError, "`sweeps`: give a whole number, not bool"),
    ({"sweeps": [1]}, TypeError, "`sweeps`: give a whole number, not list"),
    ({"scheme": "newton"}, ArgumentError, "'newton' for `scheme`.*track"),
    ({"max_force_n": np.nan}, ArgumentError, "`max_force_n`"),
    ({"tools": "sphere:0.01"}, TypeError, "`tools`: give a list of texts"),
    ({"tools": []}, ArgumentError, "`tools` is empty: give at least one tool, or None"),
    ({"step": True}, TypeError, "`step`: give a number or a word, not bool"),
    ({"tools": ["ball:1"]}, ArgumentError, "`tools`: part 1 `ball:1`: unknown kind"),
    ({"friction": 0.3}, ArgumentError, "`friction` 0.3: cells that are held do not slide"),
    ({"device": "hammer"}, ArgumentError, "'hammer' for `device`"),
    ({"delay_ticks": "auto", "device": "touch"}, ArgumentError, "`delay_ticks` auto"),
    ({"threads": 2}, ArgumentError, "`threads` 2"),
    ({"force_error": 0.01}, ArgumentError, "`force_error`: an error of the force is known under `scheme` predict"),
    ({"force_error": 2}, ArgumentError, "'2.0' for `force_error`.*0.001"),
    ({"force_error": True}, TypeError, "`force_error`: give a number or a word, not bool"),
    ({"young_pa": 1}, TypeError, "unexpected keyword argument 'young_pa'; there are contact"),
]


@pytest.mark.parametrize(("options", "error", "text"), TISSUES, ids=[text for _, _, text in TISSUES])
def test_bad_options(
    plane: Model, options: dict[str, object], error: type[Exception], text: str
) -> None:
    for act in (lambda: Tissue(plane, **options), lambda: chaincell.run(plane, press(3), **options)):
        with pytest.raises(error, match=text) as raised:
            act()
        assert type(raised.value) is error and "\n" not in str(raised.value)


def test_a_tool_needs_a_contact_surface() -> None:
    bare = Model.bake_mesh("plane:9x9x0.01", contact_surface="no")
    for options in ({"tools": ["sphere:0.01"]}, {"contact": "probe:0.01"}):
        with pytest.raises(ArgumentError, match="a tool touches.*`contact_surface` yes"):
            Tissue(bare, **options)


POSES: list[tuple[object, object, type[Exception], str]] = [
    ([0, 0, np.nan], True, PoseError, "the pose: its position .*NaN.* is not finite"),
    ([0, np.inf, 0], True, PoseError, "is not finite"),
    ([0, 0, 1e39], True, PoseError, "is not finite"),
    ([0, 0], True, ArgumentError, r"`pose`: its shape is \(2,\)"),
    (np.zeros((2, 2, 3)), True, ArgumentError, r"`pose`: its shape is \(2, 2, 3\)"),
    (np.zeros((9, 3)), True, ArgumentError, r"`pose`: its shape is \(9, 3\)"),
    (np.zeros((2, 3)), True, PoseError, "poses of 2 tools"),
    ([0, 0, 0, 0, 0, 0, 2], True, PoseError, "no unit quaternion"),
    (([0, 0, 0], [0, 0, 1, 1, 0]), True, ArgumentError, "`pose`: it is no array"),
    ("abc", True, TypeError, "`pose`: give real numbers"),
    (None, True, TypeError, "`pose`: give real numbers"),
    ([0j, 0, 0], True, TypeError, "`pose`: give real numbers"),
    ([[0, 0, 0]], 1, TypeError, "`engaged`: give True and False"),
    ([0, 0, 0], "yes", TypeError, "`engaged`: give True and False"),
    ([[0, 0, 0]], [True, True], ArgumentError, r"`engaged`: its shape is \(2,\), it must be \(1,\)"),
]


@pytest.mark.parametrize(("pose", "engaged", "error", "text"), POSES, ids=[of[3] for of in POSES])
def test_bad_poses_make_no_tick(
    plane: Model, pose: object, engaged: object, error: type[Exception], text: str
) -> None:
    tissue = Tissue(plane, contact=[40])
    tissue.tick([0, 0, -0.001])
    before = tissue.state_hash
    with pytest.raises(error, match=text) as raised:
        tissue.tick(pose, engaged)
    assert type(raised.value) is error
    assert (tissue.ticks, tissue.state_hash) == (1, before)


def test_bad_paths(plane: Model) -> None:
    bad = press(5)
    bad[3, 2] = np.nan
    wrongs: list[tuple[dict[str, object], type[Exception], str]] = [
        ({"path": bad}, PoseError, "`path`, tick 3: its position"),
        ({"path": [0, 0, 0]}, ArgumentError, r"`path`: its shape is \(3,\)"),
        ({"path": np.zeros((2, 4))}, ArgumentError, r"`path`: its shape is \(2, 4\)"),
        ({"path": [["a"] * 3]}, TypeError, "`path`: give real numbers"),
        ({"path": press(5), "engaged": [True]}, ArgumentError, r"`engaged`: its shape is \(1,\)"),
        ({"path": press(5), "engaged": [1.0] * 5}, TypeError, "`engaged`: give True and False"),
        ({"path": press(5), "sweeps_made": [9] * 5}, ArgumentError, "`sweeps` 9 of a tick"),
        ({"path": press(5), "sweeps_made": [1]}, ArgumentError, "`sweeps_made`: its shape"),
        ({"path": press(5), "sweeps_made": [70000] * 5}, ArgumentError, "`sweeps_made` 70000"),
        ({"path": press(1), "sweeps_made": [1], "scheme": "euler"}, ArgumentError, "`scheme`"),
    ]
    for given, error, text in wrongs:
        with pytest.raises(error, match=text):
            chaincell.run(plane, **given)
    assert len(chaincell.run(plane, np.zeros((0, 3)))) == 0


def test_bad_snapshots_leave_the_tissue_as_it_is(plane: Model, box: Model) -> None:
    tissue = Tissue(plane, contact=[40])
    for pose in press(20):
        tissue.tick(pose)
    snapshot, before = tissue.snapshot(), tissue.state_hash
    for at in range(0, len(snapshot), 53):
        flipped = bytearray(snapshot)
        flipped[at] ^= 4
        for wrong in (bytes(flipped), snapshot[:at]):
            with pytest.raises(SnapshotError):
                tissue.restore(wrong)
    newer = bytearray(snapshot)
    newer[8] += 1
    with pytest.raises(SnapshotError, match="another version"):
        tissue.restore(newer)
    with pytest.raises(TypeError):
        tissue.restore("text")
    others = [Tissue(box), Tissue(plane, contact=[41]), Tissue(plane, contact=[40], sweeps=5)]
    for other in [*others, Tissue(plane, contact=[40], device="touch")]:
        with pytest.raises(SnapshotError, match="another model, with other options"):
            tissue.restore(other.snapshot())
    assert (tissue.ticks, tissue.state_hash) == (20, before)


def test_type_checkers_know_every_argument() -> None:
    assert sorted(BakeOptions.__annotations__) == sorted(bake_options())
    assert sorted(TissueOptions.__annotations__) == sorted(tissue_options())


def test_every_error_is_one_of_the_package() -> None:
    for name in ("ArgumentError", "ModelError", "SnapshotError", "PoseError", "SessionError"):
        assert issubclass(getattr(chaincell, name), chaincell.Error)
    for name in ("ArgumentError", "ModelError", "SnapshotError", "PoseError"):
        assert issubclass(getattr(chaincell, name), ValueError)
    for name in ("NoServer", "OtherVersion", "Taken", "Full", "NoPermission", "NoReply", "Closed"):
        assert issubclass(getattr(chaincell, name), chaincell.SessionError)
