"""Sessions against real servers."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import SHORT_S, Server, press, ran

import chaincell
from chaincell import Flags, Model, Notes, Rate, Session, Tissue

Serve = Callable[..., Server]
WHOLE = ("--budget-us", "off", "--watchdog-ms", "0", "--ramp-ms", "0")
"""All sweeps on every tick, however late, and forces as the tissue has them."""


def play(session: Session, path: np.ndarray) -> np.ndarray:
    """All poses, the first released; each is answered."""
    forces = []
    for tick, pose in enumerate(path):
        forces.append(session.step(pose, engaged=tick > 0, timeout_s=SHORT_S))
        assert session.answer is not None and session.answer.outcome == "answered"
    return np.array(forces)


def test_ten_seconds_at_1_khz_lose_no_tick_and_have_the_hash_of_the_run(
    serve: Serve, plane: Model
) -> None:
    ticks = 10_000
    server = serve("--ticks", str(ticks), *WHOLE)
    turn = np.arange(ticks) * 2e-3
    path = np.stack([0.002 * np.sin(turn), 0.001 * np.cos(turn), -0.006 + 0.004 * np.cos(turn)], axis=1)
    engaged = np.arange(ticks) % 4000 > 0
    with Session(server.scene) as session:
        for tick in Rate(1000, ticks=ticks):
            session.step(path[tick], engaged[tick], timeout_s=SHORT_S)
        answer = session.answer
    assert answer is not None and answer.tick == answer.answers == ticks
    said = server.end()
    assert (said["ticks_executed"], said["poses_missing"]) == (ticks, 0)
    offline = chaincell.run(plane, path, engaged, contact=[40])
    assert answer.state_hash == said["state_hash"] == offline.state_hash
    assert np.abs(offline.force_n).max() > 0


def test_a_controller_that_stood_still_loses_no_tick(serve: Serve) -> None:
    server = serve("--ticks", "4500", *WHOLE)
    with Session(server.scene) as session:
        for tick in Rate(1000, ticks=4500):
            if tick == 500:
                time.sleep(2.5)
            session.step([0, 0, -1e-6 * tick], tick > 0, timeout_s=SHORT_S)
        assert session.answer is not None and session.answer.answers == 4500
    said = server.end()
    assert (said["ticks_executed"], said["poses_missing"], said["poses_throttled"]) == (4500, 0, 0)


def test_the_example_is_short_and_answers_every_pose(serve: Serve) -> None:
    example = Path(__file__).parents[1] / "examples" / "controller.py"
    lines = example.read_text().splitlines()
    assert len(lines) <= 15
    server = serve("--ticks", "10000")
    found = subprocess.run(
        [sys.executable, example, server.scene], capture_output=True, text=True, timeout=2 * SHORT_S
    )
    said = server.end()
    assert (found.returncode, said["poses_missing"]) == (0, 0), found
    assert said["ticks_executed"] == 10_000 and len(found.stdout.splitlines()) == 101


def test_a_step_gives_the_force_of_the_tissue(serve: Serve, plane: Model) -> None:
    server = serve(*WHOLE)
    offline = Tissue(plane, contact=[40])
    path = press(60)
    with Session(server.scene, watchdog_ms=0, ramp_ms=0) as session:
        assert session.answer is None and session.is_served
        forces = play(session, path)
        answer = session.answer
        assert answer is not None and session.silences == (0, 0)
    outputs = [offline.tick(pose, tick > 0) for tick, pose in enumerate(path)]
    assert np.array_equal(forces, [output.force_n for output in outputs])
    assert np.abs(forces[-1]).max() > 0.004
    assert answer.state_hash == offline.state_hash and answer.force_tick == answer.tick == 60
    assert answer.energy_j == outputs[-1].energy_j and answer.sweeps == 4 and answer.contacts == 1
    assert answer.notes == Notes(0) and answer.round_trip_ns > answer.step_ns > 0


def test_a_tool_that_was_never_released_has_no_force(serve: Serve) -> None:
    with Session(serve().scene) as session:
        assert not session.step([0, 0, -0.001], timeout_s=SHORT_S).any()
        assert session.answer is not None and Flags.RELEASE_FIRST in session.answer.flags


def test_several_tools_feel_force_and_torque(serve: Serve, box: Model) -> None:
    tools = ["sphere:0.006", "capsule:0.01,0.004"]
    server = serve(*[f"--tool={tool}" for tool in tools], *WHOLE, model=box)
    offline = Tissue(box, tools=tools)
    with Session(server.scene, watchdog_ms=0, ramp_ms=0) as session:
        for tick in range(60):
            pose = np.zeros((2, 7))
            pose[:, :3] = [[-0.015, 0, 0.05 - 0.0003 * tick], [0.015, 0, 0.05 - 0.0003 * tick]]
            pose[:, 3:] = [0, 0.6, 0, 0.8]
            engaged = [tick > 0, tick > 5]
            force = session.step(pose, engaged, timeout_s=SHORT_S)
            output = offline.tick(pose, engaged)
            assert np.array_equal(force, output.force_n)
        answer = session.answer
        assert answer is not None and answer.state_hash == offline.state_hash
        assert np.array_equal(answer.torque_n_m, output.torque_n_m) and force.shape == (2, 3)
        assert np.abs(answer.torque_n_m[1]).max() > 0
        assert answer.force_error_n == output.force_error_n
        assert answer.torque_error_n_m == output.torque_error_n_m
        with Session(server.scene, role="viewer") as viewer:
            viewer.contacts(0)
            viewer.stress(0)
            session.step(pose, timeout_s=SHORT_S)
            found = viewer.contacts(SHORT_S)
            while found is not None and found.tick < 61:
                found = viewer.contacts(SHORT_S)
            stress = viewer.stress(SHORT_S)
            while stress is not None and stress.first_tick < 61:
                stress = viewer.stress(SHORT_S)
        offline.tick(pose)
        expected = offline.contacts()
        assert found is not None and len(found) == len(expected) > 0
        for column in ("tools", "parts", "node_ids", "positions_m", "normal_n", "tangential_n", "area_m2"):
            assert np.array_equal(getattr(found, column), getattr(expected, column)), column
        computed, order = offline.stress(), np.argsort(box.node_ids)
        assert stress is not None and computed is not None and stress.tick == 61
        assert np.array_equal(stress.node_ids, box.node_ids[order])
        for column in ("stretches", "von_mises_pa", "mean_pa"):
            assert np.array_equal(getattr(stress, column), getattr(computed, column)[order]), column


def test_states_are_views_that_outlive_their_session(serve: Serve, plane: Model) -> None:
    server = serve("--state-hz", "1000", *WHOLE)
    offline = Tissue(plane, contact=[40])
    viewer, session = Session(server.scene, role="viewer"), Session(server.scene)
    viewer.state(0)
    play(session, press(30))
    for tick, pose in enumerate(press(30)):
        offline.tick(pose, tick > 0)
    state = None
    for _ in range(200):
        newer = viewer.state(0.05)
        state = newer or state
        if state is not None and state.tick == 30:
            break
    assert state is not None and state.state_hash == offline.state_hash and len(state) == 81
    assert state.model_checksum == plane.checksum
    positions, ids = state.positions_m, state.node_ids
    for array in (positions, ids):
        assert array.base is state and not array.flags.writeable and not array.flags.owndata
    assert np.array_equal(positions, offline.positions_m) and np.array_equal(ids, plane.node_ids)
    kept = positions.copy()
    del state, newer
    viewer.close()
    play(session, np.zeros((5, 3)))
    session.close()
    server.interrupt()
    assert np.array_equal(positions, kept) and kept[40, 2] < -0.005


def test_a_viewer_of_a_follower_sees_the_same_states(
    serve: Serve, command: Path, tmp_path: Path
) -> None:
    out = tmp_path / "session"
    server = serve("--out", str(out), *WHOLE)
    far = f"{server.scene}-far"
    follow = subprocess.Popen(
        [command, "follow", out, "--scene", far, "--json"], stdout=subprocess.PIPE, text=True
    )
    try:
        assert follow.stdout is not None and follow.stdout.readline() == "ready\n"
        with Session(server.scene) as session, Session(far, role="viewer") as viewer:
            viewer.state(0)
            play(session, press(30))
            assert session.answer is not None
            state = viewer.state(SHORT_S)
            while state is not None and state.tick < 30:
                state = viewer.state(SHORT_S)
            assert state is not None and len(state) == 81
            assert state.state_hash == session.answer.state_hash
            del state
        server.interrupt()
        followed = json.loads(follow.communicate(timeout=SHORT_S)[0])
        assert followed["has_ended"] and followed["hashes_compared"] > 0
    finally:
        follow.kill()
        follow.wait(SHORT_S)


def test_states_that_are_held_are_told_of(serve: Serve) -> None:
    server = serve("--state-hz", "1000")
    with Session(server.scene) as session, Session(server.scene, role="viewer") as viewer:
        held = []
        with pytest.raises(chaincell.SessionError, match="two of them are held: let go of one"):
            for tick in range(1000):
                session.step([0, 0, -1e-5 * tick], tick > 0, timeout_s=SHORT_S)
                held.append(viewer.state(0.1))
        assert len([of for of in held if of is not None]) == 2
        held.clear()
        session.step([0, 0, 0], False, timeout_s=SHORT_S)
        assert viewer.state(SHORT_S) is not None


def test_commands_are_carried_out_or_refused(serve: Serve, tmp_path: Path, plane: Model) -> None:
    trace = tmp_path / "session.trace"
    server = serve("--record", str(trace), "--record-ticks", "1000", *WHOLE)
    with Session(server.scene, watchdog_ms=0, ramp_ms=0) as session:
        play(session, press(50))
        assert session.pause().tick == 50
        assert not session.step([0, 0, -0.01], timeout_s=SHORT_S).any()
        assert session.answer is not None and Flags.SAFE_STATE in session.answer.flags
        session.resume()
        session.set(sweeps=6)
        session.step([0, 0, -0.01], timeout_s=SHORT_S)
        assert session.answer.sweeps == 6
        for change in ({"max_force_n": 0.001}, {"max_force_n": float("inf")}, {"unloading": "off"}, {"cut": "off"}):
            session.set(**change)
        session.set(max_tool_step_m=0.002)
        reply = session.snapshot()
        saved = trace.with_name(f"{trace.name}.{reply.tick}.snapshot")
        for _ in range(1000):
            if saved.exists():
                break
            time.sleep(0.01)
        # What a server has saved a tissue goes on from.
        tissue = Tissue(plane, contact=[40])
        tissue.restore(saved.read_bytes())
        assert tissue.state_hash == reply.state_hash
        assert session.reset().ticks_answered > 0
        with pytest.raises(chaincell.Refused, match="nothing can be gripped here"):
            session.grip()
        with pytest.raises(chaincell.Refused):
            session.let_go(3, 10)
        with pytest.raises(chaincell.Refused, match="nothing can be gripped here, nor pinned"):
            session.pin_at([0, 0, 0], 0.01)
    server.interrupt()


def test_a_place_is_pinned_until_it_is_released(serve: Serve, box: Model) -> None:
    server = serve("--contact", "probe:0.006", *WHOLE, model=box)
    with Session(server.scene, watchdog_ms=0, ramp_ms=0) as session:
        session.step([0, 0, 0.08], False, timeout_s=SHORT_S)
        with pytest.raises(chaincell.Refused, match="move the point, or take a larger radius"):
            session.pin_at([0, 0, 1.0], 0.005)
        rest = session.answer
        reply = session.pin_at(np.array([0.0, 0.0, 0.04]), 0.008, stiffness_n_per_m=50.0)
        assert rest is not None and reply.state_hash != rest.state_hash
        second = session.pin_at([0.0, 0.0, 0.04], 0.008)
        assert (reply.pin, second.pin, session.pause().pin) == (0, 1, None)
        session.resume()
        session.unpin(1, ticks=5)
        session.unpin(0, ticks=5)
        for _ in range(6):
            session.step([0, 0, 0.08], False, timeout_s=SHORT_S)
        with pytest.raises(chaincell.Refused, match="there is no pin of this number"):
            session.unpin(0)
    server.interrupt()


def test_bad_arguments_of_a_session_harm_nobody(serve: Serve, plane: Model) -> None:
    server = serve(*WHOLE)
    path, wrong = press(50), chaincell.ArgumentError
    calls: list[tuple[Callable[[Session], object], type[Exception], str]] = [
        (lambda s: s.step([0, 0, np.nan]), chaincell.PoseError, "is not finite"),
        (lambda s: s.step([0, 0]), wrong, "`pose`: its shape"),
        (lambda s: s.step("abc"), TypeError, "`pose`: give real numbers"),
        (lambda s: s.step([0] * 6 + [2]), chaincell.PoseError, "no unit quaternion"),
        (lambda s: s.step(np.zeros((9, 3))), wrong, r"`pose`: its shape is \(9, 3\)"),
        (lambda s: s.step([0, 0, 0], timeout_s=-1), wrong, "`timeout_s` -1: must be"),
        (lambda s: s.step([0, 0, 0], timeout_s=np.nan), wrong, "`timeout_s` NaN: must be"),
        (lambda s: s.set(), TypeError, "set.. takes one of"),
        (lambda s: s.set(sweeps=2, max_force_n=1), TypeError, "set.. takes one of"),
        (lambda s: s.set(sweeps=0), wrong, "`sweeps` 0: must be from 1 to 1000"),
        (lambda s: s.set(max_force_n=np.nan), wrong, "`max_force_n` NaN: must be above 0"),
        (lambda s: s.set(max_tool_step_m=np.inf), wrong, "`max_tool_step_m` inf"),
        (lambda s: s.set(cut="release"), wrong, '`cut` "release": give on, off'),
        (lambda s: s.pin_at([0, 0], 0.01), wrong, r"`point_m`: its shape is \(2,\), it must be"),
        (lambda s: s.pin_at([0, np.nan, 0], 0.01), chaincell.Refused, "point_m: give the point"),
        (lambda s: s.pin_at([0, 0, 0], -0.01), chaincell.Refused, "radius_m: give the radius"),
        (lambda s: s.set(unloading="on"), wrong, '`unloading` "on": give off, release, retreat'),
        (lambda s: Session(s.scene, server_wait_s=0.1), chaincell.Taken, "close it, or take another scene"),
        (lambda s: s.state(-1), wrong, "`timeout_s` -1"),
    ]
    with Session(server.scene) as session:
        for tick, pose in enumerate(path):
            session.step(pose, tick > 0, timeout_s=SHORT_S)
            call, error, text = calls[tick % len(calls)]
            with pytest.raises(error, match=text) as raised:
                call(session)
            assert type(raised.value) is error and "\n" not in str(raised.value)
        answer = session.answer
    expected = chaincell.run(plane, path, np.arange(50) > 0, contact=[40])
    assert answer is not None and answer.state_hash == expected.state_hash
    assert server.interrupt()["ticks_executed"] == 50


def test_scenes_that_cannot_be_opened() -> None:
    begun = time.monotonic()
    with pytest.raises(chaincell.NoServer, match="no server on scene nobody: start `chaincell serve`"):
        Session("nobody", server_wait_s=0.2)
    assert time.monotonic() - begun >= 0.2
    wrongs: list[tuple[dict[str, object], str]] = [
        ({"scene": "a/b"}, '`scene` "a/b" contains a slash'),
        ({"scene": ""}, "is empty"),
        ({"role": "king"}, '`role` "king": give controller or viewer'),
        ({"wait": "long"}, '`wait` "long": give hybrid, spin, event'),
        ({"server_wait_s": float("nan")}, "`server_wait_s` NaN"),
        ({"lost_s": -1.0}, "`lost_s` -1"),
        ({"watchdog_ms": 60001}, "`watchdog_ms` 60001"),
    ]
    for given, text in wrongs:
        with pytest.raises(chaincell.ArgumentError, match=text):
            Session(**given)


def test_a_scene_of_another_version_is_refused() -> None:
    pytest.importorskip("iceoryx2")
    # A process of its own: two copies of iceoryx2 in one take each other for dead.
    scene = f"python-version-{os.getpid()}"
    program = f"""
import ctypes
import iceoryx2
class Pose(ctypes.Structure):
    _fields_ = [("tick", ctypes.c_uint64)]
    @staticmethod
    def type_name():
        return "chaincell.ToolPoses.v3"
iceoryx2.set_log_level(iceoryx2.LogLevel.Fatal)
node = iceoryx2.NodeBuilder.new().create(iceoryx2.ServiceType.Ipc)
name = iceoryx2.ServiceName.new("chaincell/{scene}/tools")
service = node.service_builder(name).publish_subscribe(Pose).open_or_create()
print("ready", flush=True)
input()
"""
    other = subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert other.stdout is not None and other.stdout.readline() == "ready\n"
        with pytest.raises(chaincell.OtherVersion, match="chaincell.ToolPoses.v2 of 344 bytes"):
            Session(scene, server_wait_s=0.1)
    finally:
        other.communicate("\n", timeout=SHORT_S)


def test_a_closed_session_says_so(serve: Serve) -> None:
    session = Session(serve().scene)
    assert not session.is_closed
    session.close()
    session.close()
    assert session.is_closed and "closed" in repr(session)
    calls: list[Callable[[], object]] = [
        lambda: session.step([0, 0, 0]),
        lambda: session.state(0),
        lambda: session.contacts(0),
        lambda: session.stress(0),
        lambda: session.reset(),
        lambda: session.is_served,
        lambda: session.silences,
        lambda: session.__enter__(),
    ]
    for call in calls:
        with pytest.raises(chaincell.Closed, match="it is closed: open another"):
            call()


def test_a_viewer_has_no_tools(serve: Serve) -> None:
    with Session(serve().scene, role="viewer") as viewer:
        with pytest.raises(chaincell.SessionError, match="a viewer has no tools"):
            viewer.step([0, 0, 0])


def test_a_killed_server_is_told_and_the_next_one_goes_on(
    serve: Serve, command: Path, plane: Model, tmp_path: Path
) -> None:
    trace = tmp_path / "killed.trace"
    server = serve("--record", str(trace), "--record-ticks", "5000")
    with Session(server.scene, lost_s=0.3) as session:
        forces = play(session, press(100))
        assert np.abs(forces[-1]).max() > 0.004
        server.kill()
        seen = []
        with pytest.raises(chaincell.NoServer, match="no answer on scene .* start chaincell serve again"):
            for _ in range(1000):
                seen.append(np.abs(session.step([0, 0, -0.01], timeout_s=0.002)).max())
        assert len(seen) > 20 and seen[-1] == 0 and seen == sorted(seen, reverse=True)
        answer = session.answer
        assert answer is not None and answer.outcome == "silent" and Notes.SILENT in answer.notes
        with pytest.raises(chaincell.NoServer):
            session.step([0, 0, 0])
        with pytest.raises(chaincell.NoReply):
            session.reset(timeout_s=0.1)
        # What it had recorded is whole.
        plane.save(tmp_path / "plane.chaincell")
        replay = [command, "replay", trace, "--model", tmp_path / "plane.chaincell"]
        subprocess.run(replay, check=True, capture_output=True)
        file = tmp_path / f"{plane.checksum}.chaincell"
        again = subprocess.Popen(
            [command, "serve", file, "--scene", server.scene, "--contact", "40", "--late-share", "off"],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert again.stdout is not None and again.stdout.readline() == "ready\n"
        try:
            for _ in range(500):
                try:
                    session.step([0, 0, 0], False, timeout_s=0.1)
                    break
                except chaincell.NoServer:
                    pass
            assert session.answer is not None and session.answer.outcome == "answered"
            assert np.abs(play(session, press(100))[-1]).max() > 0.004
        finally:
            again.kill()
            again.communicate()


def test_a_controller_that_is_killed_leaves_its_place(serve: Serve) -> None:
    server = serve()
    program = f"""
import os, signal
from chaincell import Session
session = Session({server.scene!r})
session.step([0, 0, 0], False)
os.kill(os.getpid(), signal.SIGKILL)
"""
    assert ran(program).returncode == -9
    with Session(server.scene) as session:
        play(session, press(20))


def test_a_forked_child_leaves_the_session_alone(serve: Serve, plane: Model) -> None:
    server = serve("--state-hz", "1000", *WHOLE)
    program = f"""
import gc, os, sys, time
import numpy as np
import chaincell
session = chaincell.Session({server.scene!r})
viewer = chaincell.Session({server.scene!r}, role="viewer")
viewer.state(0)
session.step([0, 0, 0], False, timeout_s=60)
state = viewer.state(60)
kept = state.positions_m
child = os.fork()
if child == 0:
    for call in (lambda: session.step([0, 0, 0]), lambda: viewer.state(0), lambda: state.positions_m):
        try:
            call()
            os._exit(3)
        except chaincell.Closed as why:
            assert "forked" in str(why)
    session.close()
    del session, viewer, state, kept
    gc.collect()
    sys.exit(7)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
del kept
for tick in range(1, 300):
    session.step([0, 0, -1e-5 * tick], timeout_s=60)
    state = viewer.state(0.01) or state
print(session.answer.outcome, session.answer.tick, session.answer.state_hash, len(state))
"""
    found = ran(program)
    path = np.zeros((300, 3))
    path[:, 2] = [-1e-5 * tick for tick in range(300)]
    expected = chaincell.run(plane, path, np.arange(300) > 0, contact=[40]).state_hash
    assert found.stdout == f"answered 300 {expected} 81\n", found
    server.interrupt()


@pytest.mark.parametrize(
    "wait",
    [
        'Session("nobody", server_wait_s=600)',
        "session.step([0, 0, 0], timeout_s=600)",
        "session.reset(timeout_s=600)",
        "viewer.state(600)",
        "list(Rate(0.01))",
    ],
)
def test_ctrl_c_ends_every_wait(serve: Serve, wait: str) -> None:
    server = serve()
    program = f"""
import os, signal, threading
from chaincell import Rate, Session
session = Session({server.scene!r})
viewer = Session({server.scene!r}, role="viewer")
session.step([0, 0, 0], False)
viewer.state(0)
while viewer.state(0.2):
    pass
os.kill({server.process.pid}, signal.SIGSTOP)
threading.Timer(0.3, os.kill, [os.getpid(), signal.SIGINT]).start()
try:
    {wait}
except KeyboardInterrupt:
    print("interrupted")
"""
    try:
        found = ran(program)
    finally:
        os.kill(server.process.pid, 18)
    assert found.stdout == "interrupted\n", found


def test_threads_share_a_session(serve: Serve) -> None:
    server = serve("--state-hz", "200")
    with Session(server.scene) as session:
        play(session, press(2))
        steps, states, errors = [0, 0], [0], []

        def press_on(at: int) -> None:
            try:
                for _ in range(300):
                    session.step([0, 0, -0.001], timeout_s=SHORT_S)
                    steps[at] += 1
            except Exception as why:
                errors.append(why)

        def look() -> None:
            try:
                while sum(steps) < 600 and not errors:
                    states[0] += session.state(0.05) is not None
            except Exception as why:
                errors.append(why)

        threads = [threading.Thread(target=press_on, args=[at]) for at in (0, 1)]
        threads.append(threading.Thread(target=look))
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert (errors, steps) == ([], [300, 300]) and states[0] > 0
        assert session.answer is not None and session.answer.tick == 602


def test_a_rate_leaves_no_turn_out() -> None:
    rate = Rate(1000, ticks=50)
    assert list(rate) == list(range(50)) and list(rate) == []
    assert list(Rate(2000, seconds=0.01)) == list(range(20))
    slow = Rate(200, ticks=4)
    begun = time.monotonic()
    for turn in slow:
        if turn == 1:
            time.sleep(0.02)
    assert slow.late >= 1 and time.monotonic() - begun >= 0.015
    for given in ({"hz": 0.0}, {"hz": float("nan")}, {"seconds": -1.0}, {"ticks": 1, "seconds": 1.0}):
        with pytest.raises(chaincell.ArgumentError):
            Rate(**given)
