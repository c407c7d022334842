"""Ticks, runs and snapshots without a server."""

from __future__ import annotations

import json
import subprocess
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from conftest import COUNTS, press, ran

import chaincell
from chaincell import Flags, Model, Tissue

PROBE = {"contact": "probe:0.008"}


def write_path(file: Path, path: np.ndarray) -> None:
    """As the command reads one; all engaged."""
    rows = [f"{tick},{x!r},{y!r},{z!r},1" for tick, (x, y, z) in enumerate(path.tolist())]
    file.write_text("\n".join(["tick,x_m,y_m,z_m,engaged", *rows, ""]))


def by_command(command: Path, model: Model, path: np.ndarray, folder: Path, *options: str) -> str:
    """The hash of `chaincell run`."""
    model.save(folder / "model.chaincell")
    write_path(folder / "path.csv", path)
    files = ["--path", str(folder / "path.csv"), "--out", str(folder / "out"), "--json"]
    found = subprocess.run(
        [command, "run", folder / "model.chaincell", *files, *options],
        check=True,
        capture_output=True,
        text=True,
    )
    return json.loads(found.stdout)["state_hash"]


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"contact": [40]}, ["--contact", "40"]),
        ({"contact": "cells:nodes:40,41", "sweeps": 2}, ["--contact", "40,41", "--sweeps", "2"]),
        ({"contact": "40", "scheme": "euler"}, ["--contact", "40", "--scheme", "euler"]),
        ({"contact": "probe:0.01"}, ["--contact", "probe:0.01"]),
        ({"contact": [40], "device": "touch"}, ["--contact", "40", "--device", "touch"]),
    ],
)
def test_ticks_give_the_bits_of_the_command(
    command: Path, plane: Model, tmp_path: Path, options: dict[str, object], line: list[str]
) -> None:
    path = press(300)
    if options["contact"] == "probe:0.01":
        # From above: a probe that begins within the plane waits until it was outside.
        path[:, 2] += 0.012
    expected = by_command(command, plane, path, tmp_path, *line)
    tissue = Tissue(plane, **options)
    outputs = [tissue.tick(pose) for pose in path]
    assert tissue.state_hash == expected and tissue.ticks == 300
    result = chaincell.run(plane, path, **options)
    assert result.state_hash == expected and len(result) == 300
    assert np.array_equal(result.force_n, [of.force_n for of in outputs])
    assert np.abs(result.force_n).max() > 0
    assert result.flags.tolist() == [of.flags for of in outputs]
    assert result.energy_j.tolist() == [of.energy_j for of in outputs]
    written = np.genfromtxt(tmp_path / "out" / "force.csv", delimiter=",", names=True)
    forces = np.stack([written[f"f{axis}_n"] for axis in "xyz"], axis=1).astype(np.float32)
    assert np.array_equal(forces, result.force_n)


def test_a_force_has_an_error_where_it_is_known(box: Model, plane: Model) -> None:
    tissue = Tissue(box, contact="probe:0.012")
    outputs = [tissue.tick([0.0, 0.0, 0.053 - 0.0001 * tick]) for tick in range(60)]
    assert outputs[0].force_error_n == [None]
    (error_n,) = outputs[-1].force_error_n
    assert error_n is not None and 0 < error_n < 0.3 * np.linalg.norm(outputs[-1].force_n)
    # Of a bar on its side, off the middle, the torque has one too; held cells have none.
    bar, lying = Tissue(box, tools=["capsule:0.01,0.012"]), [0.0, 0.7071068, 0.0, 0.7071068]
    outputs = [bar.tick([0.004, 0.0, 0.053 - 0.0001 * tick, *lying]) for tick in range(60)]
    assert outputs[0].torque_error_n_m == [None]
    (error_n_m,) = outputs[-1].torque_error_n_m
    assert error_n_m is not None and 0 < error_n_m < 0.02 * np.linalg.norm(outputs[-1].force_n)
    links = Tissue(plane, contact=[40])
    assert [links.tick([0.0, 0.0, -0.0001 * tick]).force_error_n for tick in range(9)] == [[None]] * 9
    assert links.tick([0.0, 0.0, -0.001]).torque_error_n_m == [None]


def test_ticks_end_by_the_error_of_their_forces(command: Path, box: Model, tmp_path: Path) -> None:
    # A press that stays: few sweeps are enough then.
    path = np.array([[0.0, 0.0, 0.053 - 0.0001 * min(tick, 60)] for tick in range(180)])
    line = ["--contact", "probe:0.012", "--sweeps", "8", "--force-error", "0.05"]
    expected = by_command(command, box, path, tmp_path, *line)
    tissue = Tissue(box, contact="probe:0.012", sweeps=8, force_error=0.05)
    outputs = [tissue.tick(pose) for pose in path]
    result = chaincell.run(box, path, contact="probe:0.012", sweeps=8, force_error=0.05)
    assert tissue.state_hash == result.state_hash == expected
    assert [of.sweeps for of in outputs] == result.sweeps.tolist()
    assert result.sweeps.max() == 8 and result.sweeps[100:].mean() < 6
    # In a press that stays the last force is that of the tick.
    known = [of for of in outputs[100:] if of.force_error_n != [None] and of.sweeps < 8]
    assert len(known) > 40
    assert all(of.force_error_n[0] < 0.06 * np.linalg.norm(of.force_n) for of in known)
    # A number of sweeps goes before the error.
    again = chaincell.run(
        box, path, contact="probe:0.012", sweeps=8, sweeps_made=result.sweeps, force_error=0.001
    )
    assert again.state_hash == expected


def test_several_tools_give_the_bits_of_the_command(
    command: Path, box: Model, tmp_path: Path
) -> None:
    box.save(tmp_path / "box.chaincell")
    rows, path = [], np.zeros((60, 2, 7))
    for tick in range(60):
        for tool, x in enumerate((-0.015, 0.015)):
            pose = [x, 0.0, 0.05 - 0.0003 * tick, 0.0, 0.6, 0.0, 0.8]
            path[tick, tool] = pose
            rows.append(",".join([str(tick), str(tool), *map(repr, pose), "1"]))
    header = "tick,tool,x_m,y_m,z_m,qx,qy,qz,qw,engaged"
    (tmp_path / "path.csv").write_text("\n".join([header, *rows, ""]))
    tools = ["sphere:0.006", "capsule:0.01,0.004"]
    line = [f"--tool={tool}" for tool in tools]
    files = ["--path", str(tmp_path / "path.csv"), "--out", str(tmp_path / "out"), "--json"]
    found = subprocess.run(
        [command, "run", tmp_path / "box.chaincell", *files, *line],
        check=True,
        capture_output=True,
        text=True,
    )
    offline = chaincell.run(box, path, tools=tools)
    assert offline.state_hash == json.loads(found.stdout)["state_hash"]
    assert offline.force_n.shape == offline.torque_n_m.shape == (60, 2, 3)
    assert np.abs(offline.force_n[-1]).max(axis=1).min() > 0
    assert np.abs(offline.torque_n_m[-1, 1]).max() > 0
    tissue = Tissue(box, tools=tools)
    for poses in path:
        output = tissue.tick(poses, [True, True])
    assert tissue.state_hash == offline.state_hash
    contacts = tissue.contacts()
    assert len(contacts) == output.contacts > 0
    assert set(contacts.tools.tolist()) == {0, 1} and contacts.area_m2.min() > 0
    normal = np.array([contacts.normal_n[contacts.tools == tool].sum(axis=0) for tool in (0, 1)])
    assert np.allclose(normal, output.force_n, atol=1e-5)


def test_a_blade_cuts_a_body_that_is_baked_for_it(tmp_path: Path, command: Path) -> None:
    options = {"young_pa": 5000, "poisson": 0.4, "cuttable": True, "toughness_j_per_m2": 10}
    model = Model.bake_mesh("box:5x5x4x0.01", cut_spare=0.3, **options)
    model.save(tmp_path / "box.chaincell")
    path = np.zeros((150, 3), np.float32)
    path[:, 2] = 0.0305 - 0.0001 * np.arange(150)
    lines = [f"{tick},{x},{y},{z},1" for tick, (x, y, z) in enumerate(path)]
    (tmp_path / "path.csv").write_text("\n".join(["tick,x_m,y_m,z_m,engaged", *lines]))
    files = ["--path", str(tmp_path / "path.csv"), "--out", str(tmp_path / "out"), "--json"]
    found = subprocess.run(
        [command, "run", tmp_path / "box.chaincell", "--tool=blade:0.032", *files],
        check=True,
        capture_output=True,
        text=True,
    )
    said = json.loads(found.stdout)
    tissue = Tissue(model, tools=["blade:0.032"])
    for pose in path:
        tissue.tick(pose)
    cuts = tissue.cuts
    assert cuts is not None and cuts["opened_faces"] > 4 and cuts["copied_cells"] > 1
    assert tissue.state_hash == said["state_hash"]
    assert cuts["opened_faces"] == said["opened_faces"]
    assert cuts["copied_cells"] == said["copied_cells"] and cuts["refused_splits"] == 0
    assert np.float32(cuts["cut_area_m2"]) == np.float32(said["cut_area_m2"]) > 0
    check_surface(tissue, int(cuts["copied_cells"]))
    tissue.reset()
    assert tissue.cuts is not None and tissue.cuts["opened_faces"] == 0
    check_surface(tissue, 0)
    with pytest.raises(chaincell.ModelError, match="cut_spare.*cuttable"):
        Model.bake_mesh("box:5x5x4x0.01", young_pa=5000, cut_spare=0.3)
    assert "torn_cells" not in tissue.cuts
    off = Tissue(model, tools=["blade:0.032"], cut="off")
    assert all(off.tick(pose).force_n[2] == 0 for pose in path)
    assert off.cuts is not None and off.cuts["opened_faces"] == 0


def check_surface(tissue: Tissue, copies: int) -> None:
    """The surface is closed, and begins with the nodes and triangles of the model; copies lie beside their nodes."""
    surface, model = tissue.surface(), tissue.model
    assert surface is not None and surface.tick == tissue.ticks
    assert surface.positions_m.shape == (model.nodes + copies, 3) and surface.origins.shape == (model.nodes + copies,)
    assert np.array_equal(surface.positions_m[: model.nodes], tissue.positions_m)
    assert np.array_equal(surface.origins[: model.nodes], np.arange(model.nodes))
    apart_m = np.linalg.norm(surface.positions_m - surface.positions_m[surface.origins], axis=1)
    assert apart_m.max() < 0.01 and (apart_m[model.nodes :] > 0).all()
    begin = model.node_ids[surface.origins[surface.triangles]][: len(model.triangles)]
    assert np.array_equal(begin, model.triangles)
    assert (len(surface.triangles) > len(model.triangles)) == (copies > 0)
    edges = [tuple(edge) for row in surface.triangles.tolist() for edge in zip(row, row[1:] + row[:1], strict=True)]
    assert len(set(edges)) == len(edges) and {(end, start) for start, end in edges} == set(edges)


def test_a_body_tears_that_is_baked_for_it() -> None:
    spec, ends = "box:9x3x5x0.005", ("box:-1,-0.0199,-1,1,-1,1", "cells:box:0.0199,1,-1,1,-1,1")
    options = {"young_pa": 5000, "poisson": 0.3, "fixed": ends[0], "cuttable": True, "cut_spare": 1}
    model = Model.bake_mesh(spec, tear_stretch=1.3, **options)
    tissue = Tissue(model, contact=ends[1])
    for tick in range(200):
        tissue.tick([0.0001 * tick, 0, 0])
    cuts = tissue.cuts
    assert cuts is not None and cuts["torn_cells"] > 0 and cuts["cut_area_m2"] == 0
    assert Model.bake_mesh(spec, loose="drop", **options).checksum != model.checksum
    assert "torn_cells" in (Tissue(Model.bake_mesh(spec, tears=True, **options)).cuts or {})
    for wrong, match in [
        ({"tears": True}, "tears.*cuttable"),
        ({"tear_stretch": 2}, "tear_stretch.*cuttable"),
        ({"cuttable": True, "tears": True, "tear_stretch": 2}, "leave the other out"),
        ({"cuttable": True, "tear_stretch": 1}, "from 1.01 to 10"),
        ({"loose": "drop"}, "loose.*cuttable"),
        ({"cuttable": True, "loose": "gone"}, "loose.*leave or freeze or drop"),
    ]:
        with pytest.raises(chaincell.ModelError, match=match):
            Model.bake_mesh(spec, young_pa=5000, **wrong)


def test_a_pose_may_be_written_in_many_ways(box: Model) -> None:
    place, turn = [0.0, 0.0, 0.044], [0.0, 0.0, 0.0, 1.0]
    ways = [
        place,
        tuple(place),
        np.array(place),
        np.array(place, np.float32),
        [*place, *turn],
        (place, turn),
        (np.array(place), np.array(turn)),
        [place],
    ]
    hashes = set()
    for pose in ways:
        tissue = Tissue(box, tools=["sphere:0.006"])
        output = tissue.tick(pose)
        assert output.force_n.shape == ((1, 3) if pose is ways[-1] else (3,)), pose
        hashes.add(tissue.state_hash)
    assert len(hashes) == 1
    away = Tissue(box, tools=["sphere:0.006"])
    away.tick(place, False)
    away.tick(place, engaged=np.False_)
    assert away.state_hash == Tissue(box, tools=["sphere:0.006"]).state_hash


def test_scissors_cut_by_the_opening_of_their_poses() -> None:
    options = {"young_pa": 5000, "poisson": 0.4, "cuttable": True, "toughness_j_per_m2": 10}
    model = Model.bake_mesh("box:5x5x4x0.01", cut_spare=0.3, **options)
    pivot, offset_m, tools = [0.001, -0.001, 0.0455], 0.004, ["scissors:0.04,0.004,0.05"]
    crossings_m = np.linspace(0.015, 0.027, 120)
    openings = 2 * np.arcsin(offset_m / crossings_m)
    tissue, torque_n_m = Tissue(model, tools=tools), None
    for crossing_m, opening in zip(crossings_m, openings):
        output = tissue.tick(pivot, opening_rad=opening)
        slope = crossing_m * np.sqrt(crossing_m**2 - offset_m**2) / (2 * offset_m)
        torque_n_m = tissue.opening_torque_n_m()
        assert torque_n_m == pytest.approx(output.force_n[2] * slope, rel=5e-3)
    assert torque_n_m is not None and torque_n_m > 1e-3
    assert tissue.cuts is not None and tissue.cuts["opened_faces"] > 4
    whole = chaincell.run(model, [pivot] * 120, opening_rad=openings, tools=tools)
    assert whole.state_hash == tissue.state_hash
    closed = Tissue(model, tools=tools)
    for _ in range(5):
        closed.tick(pivot)
    assert closed.cuts is not None and closed.cuts["opened_faces"] == 0
    assert Tissue(model, tools=["blade:0.032"]).opening_torque_n_m() is None
    for opening, error, words in (
        (3.2, chaincell.PoseError, "0 to pi"),
        (-0.1, chaincell.PoseError, "0 to pi"),
        (np.nan, chaincell.PoseError, "0 to pi"),
        ([0.1, 0.2], chaincell.ArgumentError, "its shape is"),
        ("wide", TypeError, "real numbers"),
    ):
        with pytest.raises(error, match=f"`opening_rad`.*{words}"):
            tissue.tick(pivot, opening_rad=opening)
    with pytest.raises(chaincell.ArgumentError, match=r"`opening_rad`: its shape is \(3,\)"):
        chaincell.run(model, [pivot] * 120, opening_rad=[0.1] * 3, tools=tools)


@pytest.mark.parametrize("options", [{"contact": [40]}, {"contact": [40], "device": "omega"}])
def test_a_snapshot_goes_on_to_the_same_bits(plane: Model, options: dict[str, object]) -> None:
    path = np.concatenate([press(500), press(500)[::-1], press(200)])
    tissue = Tissue(plane, **options)
    for pose in path[:200]:
        tissue.tick(pose)
    snapshot, at = tissue.snapshot(), tissue.state_hash
    expected = []
    for pose in path[200:]:
        tissue.tick(pose)
        expected.append(tissue.state_hash)
    assert len(expected) == 1000 and len(set(expected)) > 100
    other = Tissue(plane, **options)
    for again in (other, tissue):
        again.restore(snapshot)
        assert (again.state_hash, again.ticks) == (at, 200)
        found = []
        for pose in path[200:]:
            again.tick(pose)
            found.append(again.state_hash)
        assert found == expected


def test_a_reset_is_rest(plane: Model) -> None:
    tissue = Tissue(plane, contact=[40])
    rest, hash_at_rest = tissue.positions_m, tissue.state_hash
    assert np.allclose(rest, plane.rest_m, atol=1e-6)
    for pose in press(40):
        tissue.tick(pose)
    moved = tissue.positions_m
    assert moved[40, 2] < -0.005 and np.array_equal(rest, Tissue(plane).positions_m), "a copy"
    assert repr(tissue) == f"<chaincell.Tissue: of model {plane.checksum}, tick 40>"
    tissue.reset()
    assert (tissue.state_hash, tissue.ticks) == (hash_at_rest, 0)


def test_a_grip_holds_until_it_is_let_go(box: Model) -> None:
    tissue = Tissue(box, tools=["sphere:0.006"])
    with pytest.raises(chaincell.Refused, match="nothing to grip"):
        tissue.grip()
    for depth in np.arange(0.050, 0.040, -0.0002):
        tissue.tick([0, 0, depth])
    tissue.grip()
    for height in np.arange(0.040, 0.052, 0.0002):
        output = tissue.tick([0, 0, height])
    assert output.force_n[2] < 0, "it pulls back"
    tissue.let_go(ticks=5)
    for _ in range(10):
        output = tissue.tick([0, 0, 0.052])
    assert output.force_n[2] == 0
    with pytest.raises(chaincell.Refused, match="no tool of this number"):
        tissue.grip(7)


def test_a_pin_holds_the_surface_until_it_is_released(box: Model) -> None:
    tissue = Tissue(box, tools=["sphere:0.006"])
    with pytest.raises(chaincell.Refused, match="neither grips nor touches"):
        tissue.pin()
    with pytest.raises(chaincell.Refused, match="no sample of the surface lies within the radius"):
        tissue.pin_at([0, 0, 1.0], 0.005)
    for depth in np.arange(0.050, 0.040, -0.0002):
        tissue.tick([0, 0, depth])
    pin = tissue.pin()
    assert tissue.pins == [pin] and np.array_equal(tissue.pin_force_n(pin), [0, 0, 0])
    other = tissue.pin_at(np.array([0.01, 0.0, 0.04]), 0.004, stiffness_n_per_m=20.0)
    assert (pin, other) == (0, 1)
    for _ in range(100):
        tissue.tick([0, 0, 0.08], False)
    force_n = tissue.pin_force_n(pin)
    assert force_n is not None and force_n[2] > 0.001, "it holds the tissue down"
    saved = tissue.snapshot()
    tissue.unpin(pin, ticks=5)
    for _ in range(6):
        tissue.tick([0, 0, 0.08], False)
    assert tissue.pins == [other] and tissue.pin_force_n(pin) is None
    tissue.restore(saved)
    assert tissue.pins == [pin, other] and np.array_equal(tissue.pin_force_n(pin), force_n)
    tissue.reset()
    assert tissue.pins == []
    with pytest.raises(chaincell.Refused, match="there is no pin 0"):
        tissue.unpin(0)
    with pytest.raises(chaincell.Refused, match="choose tools first"):
        Tissue(box, contact=[12]).pin_at([0, 0, 0.04], 0.01)


def test_sweeps_of_a_tick_can_be_told(plane: Model) -> None:
    made = np.arange(100) % 4
    whole = chaincell.run(plane, press(100), contact=[40], sweeps=4, sweeps_made=made)
    assert np.array_equal(whole.sweeps, made)
    assert (whole.flags[made == 0] & Flags.LATE).all()
    tissue = Tissue(plane, contact=[40], sweeps=4)
    for pose, sweeps in zip(press(100), made):
        tissue.tick(pose, sweeps=int(sweeps))
    assert tissue.state_hash == whole.state_hash


def test_threads_take_turns(plane: Model) -> None:
    path = press(400)
    expected = chaincell.run(plane, path, contact=[40]).state_hash
    found: list[str] = []

    def alone() -> None:
        tissue = Tissue(plane, contact=[40])
        for pose in path:
            tissue.tick(pose)
        found.append(tissue.state_hash)

    shared = Tissue(plane, contact=[40])

    def together() -> None:
        for _ in range(200):
            shared.tick(path[-1])
            shared.state_hash

    threads = [threading.Thread(target=of) for of in (alone, alone, together, together)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected, expected] and shared.ticks == 400


def test_runs_side_by_side_have_the_bits_of_one_alone(plane: Model, box: Model) -> None:
    path = press(300)
    jobs = [(plane, {"contact": [40], "sweeps": of}) for of in (1, 2, 3)]
    jobs += [(box, {"contact": "probe:0.01", "sweeps": of}) for of in (1, 2, 3)]

    def hash_of(job: tuple[Model, dict[str, object]]) -> str:
        return chaincell.run(job[0], path, **job[1]).state_hash

    alone = [hash_of(job) for job in jobs]
    with ThreadPoolExecutor(2) as threads:
        assert list(threads.map(hash_of, jobs[::-1])) == alone[::-1]


def test_a_run_ends_while_another_one_goes_on() -> None:
    program = """
import os, threading
import numpy as np
import chaincell
model = chaincell.Model.bake_mesh("plane:9x9x0.01")
path = np.zeros((2_000_000, 3))
long = threading.Thread(target=chaincell.run, args=[model, path], kwargs=dict(sweeps=64), daemon=True)
long.start()
for _ in range(20):
    chaincell.run(model, path[:100], sweeps=64)
print("both run", long.is_alive(), flush=True)
os._exit(0)
"""
    found = ran(program)
    assert found.stdout == "both run True\n", found


def test_a_long_run_lets_other_threads_and_ctrl_c_through(plane: Model) -> None:
    program = f"""
import signal, threading, time
import numpy as np
import chaincell
model = chaincell.Model.bake_mesh("organ:1000")
{COUNTS}
threading.Timer(0.5, signal.raise_signal, [signal.SIGINT]).start()
begun = time.monotonic()
try:
    chaincell.run(model, np.zeros((2_000_000, 3)) + [0, 0, 0.001], sweeps=64)
except KeyboardInterrupt:
    print("interrupted", turns > 50)
"""
    found = ran(program)
    assert found.stdout == "interrupted True\n", found


def test_a_body_that_relaxes_is_for_one_rate_of_ticks() -> None:
    spec, branches = "box:5x5x4x0.01", [(2.0, 0.1), (1.0, 4)]
    bake = Model.bake_mesh
    model = bake(spec, young_pa=1000, branches=branches)
    assert bake(spec, young_pa=1000, branches=branches[::-1]).checksum == model.checksum
    assert bake(spec, young_pa=1000, branches=branches, instant=True).checksum != model.checksum
    tissue = Tissue(model, tools=["sphere:0.01"])
    for tick in range(200):
        tissue.tick([0, 0, 0.041 - min(tick, 50) * 2e-4])
    assert tissue.relaxed_j is not None and tissue.relaxed_j > 0
    slow = bake(spec, young_pa=1000, branches=branches, device_hz=500)
    Tissue(slow, device_hz=500)
    with pytest.raises(chaincell.ArgumentError, match="device_hz.*1000 ticks.*baked for 500"):
        Tissue(slow)
    cervix = bake(spec, tissue="cervix")
    by_hand = [(2.725, 0.0026), (0.940, 0.159)]
    assert bake(spec, young_pa=3197, branches=by_hand).checksum == cervix.checksum
    elastic = bake(spec, tissue="cervix", branches=[])
    assert elastic.checksum == bake(spec, young_pa=3197).checksum
    for wrong, match in [
        ({"branches": branches, "lean": True}, "lean.*branches"),
        ({"young_pa": 1000, "instant": True}, "instant.*no branches"),
        ({"young_pa": 1000, "branches": [(-1, 2)]}, "branches.*above 0"),
        ({"young_pa": 1000, "branches": branches, "cuttable": True}, "branches.*cuttable"),
        ({"tissue": "stone"}, "tissue.*known are muscle"),
    ]:
        with pytest.raises(chaincell.ModelError, match=match):
            bake(spec, **wrong)
    with pytest.raises(TypeError, match="branches.*pairs"):
        bake(spec, young_pa=1000, branches=[(1, 2, 3)])


def test_pressed_tissue_has_its_stress_at_every_node(box: Model, plane: Model) -> None:
    tissue = Tissue(box, tools=["sphere:0.01"], sweeps=2)
    at_rest = tissue.stress()
    assert at_rest is not None and len(at_rest) == len(box.node_ids)
    assert np.abs(at_rest.cauchy_pa).max() < 1e-3 and np.allclose(at_rest.stretches, 1)
    for tick in range(200):
        tissue.tick([0, 0, 0.051 - 4e-5 * tick])
    stress = tissue.stress()
    assert stress is not None and stress.tick == 200
    xx, yy, zz, xy, yz, xz = stress.cauchy_pa.T
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    von_mises = np.sqrt(normal / 2 + 3 * (xy**2 + yz**2 + xz**2))
    assert np.allclose(stress.von_mises_pa, von_mises, rtol=1e-3, atol=1e-2)
    assert np.allclose(stress.mean_pa, (xx + yy + zz) / 3, rtol=1e-3, atol=1e-2)
    assert (np.diff(stress.stretches) <= 0).all()
    # It is where the node is: below the ball the tissue is shortest, and pressed.
    lowest = np.argmin(tissue.positions_m[:, 2] - box.rest_m[:, 2])
    assert stress.mean_pa[lowest] < 0 and stress.stretches[lowest, 2] < 0.95
    links = Tissue(plane, contact=[40])
    assert links.stress() is None
