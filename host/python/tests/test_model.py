"""Models: from arrays, files and meshio, and back."""

from __future__ import annotations

import pickle
import subprocess
from pathlib import Path
from types import SimpleNamespace

import meshio
import numpy as np
import pytest

import chaincell
from chaincell import Model


def cube() -> tuple[np.ndarray, np.ndarray]:
    """The nodes and tetrahedra of a box."""
    model = Model.bake_mesh("box:4x4x3x0.01")
    return np.asarray(model.rest_m), np.asarray(model.tetrahedra)


def test_arrays_and_the_command_bake_the_same_bytes(command: Path, tmp_path: Path) -> None:
    points, tets = cube()
    fixed = np.flatnonzero(points[:, 2] == points[:, 2].min())
    mesh = tmp_path / "box.msh"
    meshio.Mesh(points, [("tetra", tets.astype(int))]).write(mesh, file_format="gmsh")
    ids = ",".join(str(id) for id in fixed)
    out = tmp_path / "box.chaincell"
    options = ["--young-pa", "5000", "--poisson", "0.4", "--fix", ids, "-o", str(out)]
    subprocess.run([command, "bake", mesh, *options], check=True, capture_output=True)
    model = Model.bake(points, tets, young_pa=5000, poisson=0.4, fixed=fixed)
    assert bytes(model) == out.read_bytes() == bytes(Model.load(out))
    assert np.array_equal(model.fixed, fixed)
    mask = np.zeros(len(points), bool)
    mask[fixed] = True
    assert bytes(Model.bake(points, tets, young_pa=5000, poisson=0.4, fixed=mask)) == bytes(model)
    text = "nodes:" + ids
    assert bytes(Model.bake(points, tets, young_pa=5000, poisson=0.4, fixed=text)) == bytes(model)


def test_every_argument_reaches_the_bake() -> None:
    points, tets = cube()
    plain = Model.bake(points, tets)
    soft = Model.bake(points, tets, young_pa=5000)
    assert plain.has_contact_surface and soft.has_contact_surface
    changes: list[tuple[Model, dict[str, object]]] = [
        (plain, of)
        for of in (
            {"alpha": 0.02},
            {"alpha": np.linspace(0, 0.1, len(points))},
            {"stiffness_n_per_m": 7.0},
            {"fixed": [0, 1, 2]},
            {"k_m": 1.0},
            {"r_x": 2.0},
            {"capacitance": 2.0},
            {"energy_max_j": 0.5},
            {"coarse": "none"},
            {"coarse": 1.0},
            {"lean": True},
            {"cells": 20},
            {"rings": 2},
            {"unit_m": 0.001},
            {"contact_surface": "no"},
        )
    ] + [
        (soft, of)
        for of in (
            {"poisson": 0.3},
            {"poisson": np.linspace(0.3, 0.4, len(points))},
            {"stretch_min": 0.5},
            {"stretch_min": "none"},
            {"stiffening": {0.15: 1700.0, 0.3: 5000.0}},
            {"contact_surface": "no"},
        )
    ]
    seen = {plain.checksum, soft.checksum}
    for base, change in changes:
        more = {"young_pa": 5000} if base is soft else {}
        found = Model.bake(points, tets, **more, **change).checksum
        if not (base is plain and change == {"coarse": "none"}):
            assert found not in seen, change
        seen.add(found)
    default = Model.bake(points, tets, poisson=None, young_pa=None, coarse="auto")
    assert default.checksum == plain.checksum


def test_a_mesh_of_meshio_has_its_groups(tmp_path: Path) -> None:
    points, tets = cube()
    bottom = np.flatnonzero(points[:, 2] == points[:, 2].min())
    half = len(tets) // 2
    blocks = [("tetra", tets[:half]), ("tetra", tets[half:]), ("triangle", tets[:1, :3])]
    mesh = meshio.Mesh(
        points,
        blocks,
        point_sets={"bottom": bottom},
        cell_sets={"first": [np.array([0]), np.array([], int), np.array([], int)]},
    )
    model = Model.bake_mesh(mesh, fixed="group:bottom")
    assert np.array_equal(model.fixed, bottom)
    assert np.array_equal(model.groups["first"], np.unique(tets[0]))
    by_group = Model.bake_mesh(mesh, young_pa="5000,group:first=20000", fixed="group:bottom")
    values = np.full(len(points), 5000.0)
    values[tets[0]] = 20000
    assert Model.bake_mesh(mesh, young_pa=values, fixed=bottom).checksum == by_group.checksum
    # Through a file, and objects that only look alike.
    file = tmp_path / "box.vtk"
    meshio.Mesh(points, [("tetra", tets)]).write(file, file_format="vtk42", binary=True)
    from_path = Model.bake_mesh(file)
    assert from_path.checksum == Model.bake_mesh(str(file)).checksum
    assert from_path.checksum == Model.bake_mesh(meshio.read(file)).checksum
    for cells in ({"cells": [("tetra", tets)]}, {"cells_dict": {"tetra": tets}}):
        assert Model.bake_mesh(SimpleNamespace(points=points, **cells)).checksum == from_path.checksum


def test_groups_of_gmsh_are_those_of_the_reader(tmp_path: Path) -> None:
    points, tets = cube()
    tags = np.where(np.arange(len(tets)) < 5, 7, 8)
    mesh = meshio.Mesh(
        points,
        [("tetra", tets.astype(int))],
        cell_data={"gmsh:physical": [tags], "gmsh:geometrical": [tags]},
        field_data={"hard": np.array([7, 3])},
    )
    file = tmp_path / "box.msh"
    mesh.write(file, file_format="gmsh22", binary=False)
    expected = Model.bake_mesh(file).groups
    found = Model.bake_mesh(mesh).groups
    assert sorted(found) == sorted(expected) == ["8", "hard"]
    for name, ids in expected.items():
        assert np.array_equal(found[name], ids)


def test_a_model_is_saved_read_and_sent(plane: Model, tmp_path: Path) -> None:
    file = tmp_path / "plane.chaincell"
    plane.save(file)
    assert bytes(Model.load(file)) == bytes(plane) == bytes(Model.from_bytes(bytes(plane)))
    assert bytes(pickle.loads(pickle.dumps(plane))) == bytes(plane)
    assert (plane.cells, plane.nodes, len(plane.node_ids)) == (81, 81, 81)
    assert plane.unit_m == pytest.approx(0.01) and plane.links == 144
    assert plane.rest_m.shape == (81, 3) and plane.triangles.shape == (128, 3)


def test_the_image_is_a_view_that_outlives_its_model() -> None:
    model = Model.bake_mesh("plane:9x9x0.01")
    image, content = model.image, bytes(model)
    assert image.base is model and not image.flags.writeable and not image.flags.owndata
    with pytest.raises(ValueError):
        image.flags.writeable = True
    del model
    assert image.tobytes() == content


def test_groups_of_nodes_become_cells() -> None:
    model = Model.bake_mesh("box:9x9x7x0.01", cells=60)
    assert model.cells < 80 and model.nodes == 9 * 9 * 7
    assert chaincell.Tissue(model).positions_m.shape == (model.nodes, 3)


def test_a_closed_surface_is_filled_as_by_the_command(command: Path, tmp_path: Path) -> None:
    points, tets = cube()
    model = Model.bake(points, tets)
    stl, out = tmp_path / "cube.stl", tmp_path / "cube.chaincell"
    meshio.Mesh(points, [("triangle", np.asarray(model.triangles).astype(int))]).write(stl)
    options = ["--fill", "0.008", "--young-pa", "5000", "--fix", "none", "-o", str(out)]
    subprocess.run([command, "bake", stl, *options], check=True, capture_output=True)
    filled = Model.bake_mesh(str(stl), fill_m=0.008, young_pa=5000, fixed="none")
    assert bytes(filled) == out.read_bytes()


def test_a_surface_of_arrays_or_an_object_is_filled_as_a_file(tmp_path: Path) -> None:
    points, tets = cube()
    # Numbers that a file of single precision keeps as they are.
    points = points.astype(np.float32).astype(float)
    box = Model.bake(points, tets)
    ids, faces = np.unique(box.triangles, return_inverse=True)
    skin, faces = points[ids], faces.reshape(-1, 3)
    options = {"fill_m": 0.008, "young_pa": 5000, "fixed": "none"}
    stl, ply = tmp_path / "cube.stl", tmp_path / "cube.ply"
    surface = meshio.Mesh(skin, [("triangle", faces)])
    surface.write(stl, binary=True)
    surface.write(ply)
    filled = Model.bake(skin, triangles=faces, **options)
    assert filled.cells > 100 and len(filled.tetrahedra) > 300
    for other in (stl, ply, surface, meshio.read(ply)):
        assert bytes(Model.bake_mesh(other, **options)) == bytes(filled)
    mixed = SimpleNamespace(points=skin, cells=[("line", faces[:, :2]), ("triangle", faces)])
    assert Model.bake_mesh(mixed, **options).checksum == filled.checksum
    # Points that no triangle has are left out.
    assert Model.bake(points, triangles=box.triangles, **options).checksum == filled.checksum
    in_mm = Model.bake(skin * 1000, triangles=faces, unit_m=0.001, **options)
    assert np.allclose(in_mm.rest_m, filled.rest_m, atol=1e-6)
    on_top = np.flatnonzero(filled.rest_m[:, 2] > 0.019)
    assert Model.bake(skin, triangles=faces, **{**options, "fixed": on_top}).fixed.tolist() == on_top.tolist()


def test_bad_surfaces_are_told() -> None:
    points, tets = cube()
    faces = np.asarray(Model.bake(points, tets).triangles)
    fill = {"fill_m": 0.008}
    wrong, refused = chaincell.ArgumentError, chaincell.ModelError
    calls: list[tuple[dict[str, object], type[Exception], str]] = [
        ({"triangles": faces}, refused, "arrays: a surface; `fill_m` SIZE fills it"),
        ({"triangles": faces[1:], **fill}, refused, "arrays: 3 edges with a triangle on one side"),
        ({"triangles": faces, "fill_m": 0}, refused, "arrays: `fill_m` 0.0: give the edge"),
        ({"triangles": faces, "fill_m": 1e-6}, refused, "`fill_m`.*limit"),
        ({"triangles": faces, "fill_m": 1}, refused, "no tetrahedron of `fill_m` 1.0 fits"),
        ({"triangles": faces + 1000, **fill}, refused, "triangle 0 has point .*, and there are 48 points"),
        ({"triangles": np.zeros((0, 3), int), **fill}, refused, "it has no triangles"),
        ({"triangles": faces.astype(float), **fill}, TypeError, "`triangles`: give whole numbers"),
        ({"triangles": tets, **fill}, wrong, r"`triangles`: its shape is \(.*, 4\), it must be \(n, 3\)"),
        ({"triangles": faces, "diagonals": True, **fill}, refused, "`diagonals` is for a plane"),
        ({"triangles": faces, "unit_m": -1, **fill}, refused, "`unit_m` -1"),
        ({"tets": faces, **fill}, wrong, r"`tets`: its shape is .*, 3\), it must be \(n, 4\); give a closed surface as `triangles`"),
        ({"tets": tets, "triangles": faces}, wrong, "`tets` and `triangles`: give one of both"),
        ({}, wrong, "`tets` and `triangles`: give one of both"),
        ({"tets": tets, **fill}, refused, "arrays has tetrahedra of its own"),
    ]
    for given, error, text in calls:
        with pytest.raises(error, match=text) as raised:
            Model.bake(points, **given)
        assert type(raised.value) is error, raised.value
    hole = points.copy()
    hole[5, 1] = np.nan
    with pytest.raises(refused, match="point 5 is at .*NaN"):
        Model.bake(hole, triangles=faces, **fill)
    order = "a surface to fill is of first-order triangles"
    kinds = [("quad", 4, f"type quad: {order}"), ("triangle6", 6, f"type triangle6: {order}"), ("triangle", 3, "`fill_m` SIZE")]
    for kind, corners, text in kinds:
        cells = [(kind, np.zeros((1, corners), int))]
        with pytest.raises(refused, match=text):
            Model.bake_mesh(SimpleNamespace(points=points, cells=cells))


def test_materials_are_those_of_the_command(command: Path, tmp_path: Path) -> None:
    points, tets = cube()
    mesh = meshio.Mesh(
        points,
        [("tetra", tets.astype(int))],
        cell_data={"gmsh:physical": [np.where(np.arange(len(tets)) < 9, 7, 8)]},
        field_data={"hard": np.array([7, 3]), "soft": np.array([8, 3])},
    )
    file, out = tmp_path / "box.msh", tmp_path / "box.chaincell"
    mesh.write(file, file_format="gmsh22", binary=False)
    hard = {"young_pa": 20000, "poisson": 0.4}
    cases: list[tuple[list[str], dict[str, object]]] = [
        (["--material", "group:soft,young-pa=3000", "--material", "group:hard,young-pa=20000,poisson=0.4"],
         {"materials": {"soft": {"young_pa": 3000}, "hard": hard}}),
        (["--material", "group:hard,young-pa=20000,poisson=0.4", "--material", "group:soft,young-pa=3000"],
         {"materials": {"hard": hard, "soft": {"young_pa": np.float32(3000)}}}),
        (["--young-pa", "5000", "--poisson", "0.3", "--material", "group:hard,poisson=0.45"],
         {"young_pa": 5000, "poisson": 0.3, "materials": {"hard": {"poisson": 0.45}}}),
        (["--young-pa", "5000", "--cuttable", "--material", "group:hard,toughness-j-per-m2=300"],
         {"young_pa": 5000, "cuttable": True, "materials": {"hard": {"toughness_j_per_m2": 300}}}),
    ]
    seen = set()
    for line, given in cases:
        subprocess.run([command, "bake", file, *line, "-o", str(out)], check=True, capture_output=True)
        assert bytes(Model.bake_mesh(file, **given)) == bytes(Model.bake_mesh(mesh, **given)) == out.read_bytes()
        seen.add(out.read_bytes())
    assert len(seen) == 4
    wrongs: list[tuple[object, type[Exception], str]] = [
        ({"hard": hard}, chaincell.ModelError, "`materials`: node .* is in no group of a material; give `young_pa`"),
        ({"bone": hard}, chaincell.ModelError, "`materials`: the mesh has no group 'bone'; its groups: hard, soft"),
        ({"hard": {}}, chaincell.ModelError, "`materials: hard` is empty: give"),
        ({"hard": {"young": 1}}, chaincell.ModelError, "`materials: hard: young`: there are young_pa, poisson"),
        ({"hard": {"young_pa": "soft"}}, TypeError, "`materials: hard: young_pa`: give a number, not str"),
        ({"hard": {"young_pa": True}}, TypeError, "`materials: hard: young_pa`: give a number, not bool"),
        ({"hard": {"young_pa": np.nan}}, chaincell.ModelError, "`materials: hard: young_pa` NaN: must be finite"),
        ({"hard": {"poisson": 0.5}, "soft": {}}, chaincell.ModelError, "`materials: soft` is empty"),
        ({"hard": 5}, TypeError, "`materials`: give .*GROUP.*, not int"),
        (["group:hard"], TypeError, "`materials`: give .*GROUP.*, not list"),
        ({7: hard}, TypeError, "`materials`: give .*GROUP.*, not int"),
        ({}, chaincell.ModelError, "`materials` is empty"),
    ]
    for materials, error, text in wrongs:
        with pytest.raises(error, match=text):
            Model.bake_mesh(mesh, materials=materials)
    with pytest.raises(chaincell.ModelError, match="`young_pa`: value -1 of node"):
        Model.bake_mesh(mesh, young_pa=5000, materials={"hard": {"young_pa": -1}})
    with pytest.raises(chaincell.ModelError, match="`materials: hard: toughness_j_per_m2` goes with `cuttable=True`"):
        Model.bake_mesh(mesh, young_pa=5000, materials={"hard": {"toughness_j_per_m2": 9}})
    tough = np.where(mesh.points[:, 0] > 0, 8.0, 2.0)
    several = bytes(Model.bake_mesh(mesh, young_pa=5000, cuttable=True, toughness_j_per_m2=tough))
    one = bytes(Model.bake_mesh(mesh, young_pa=5000, cuttable=True, toughness_j_per_m2=8))
    assert len(several) > len(one) == len(bytes(Model.bake_mesh(mesh, young_pa=5000, cuttable=True)))
    with pytest.raises(chaincell.ModelError, match="`alpha` is for links: .*`materials`"):
        Model.bake_mesh(mesh, alpha=0.1, materials={"hard": hard, "soft": hard})
