"""Ctrl-C, signal handlers, threads and forks: nothing that the package does holds a program up."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest
from conftest import COUNTS, Server, ran

import chaincell
from chaincell import Rate, Session

Serve = Callable[..., Server]


def stopped(server: Server) -> str:
    """A program's begin: its session's server answers one pose, and then stands still."""
    return f"""
import os, signal, threading, time
import chaincell
session = chaincell.Session({server.scene!r})
session.step([0, 0, 0], False)
os.kill({server.process.pid}, signal.SIGSTOP)
"""


SPHERE = """
def sphere(rings, around):
    turns = np.linspace(0, 2 * np.pi, around, endpoint=False)
    rows = [[0.05 * np.sin(a) * np.cos(t), 0.05 * np.sin(a) * np.sin(t), 0.05 * np.cos(a)]
            for a in np.linspace(0, np.pi, rings)[1:-1] for t in turns]
    points = np.array([[0, 0, 0.05], *rows, [0, 0, -0.05]])
    last = len(points) - 1
    faces = []
    for i in range(around):
        j = (i + 1) % around
        faces += [[0, 1 + i, 1 + j], [last, last - around + j, last - around + i]]
        for ring in range(rings - 3):
            a, b = 1 + ring * around, 1 + (ring + 1) * around
            faces += [[a + i, b + i, b + j], [a + i, b + j, a + j]]
    return points, np.array(faces)
"""


@pytest.mark.parametrize(
    "work",
    [
        "Model.bake_mesh('organ:60000', young_pa=5000, coarse=1.0)",
        "Model.bake(*grid(38), young_pa=5000, coarse=1.0)",
        "Model.bake(points, triangles=faces, fill_m=0.0012, cells=60000)",
    ],
)
def test_ctrl_c_ends_a_bake_and_a_fill(work: str) -> None:
    program = f"""
import signal, threading, time
import numpy as np
from chaincell import Model
{SPHERE}
def grid(n):
    box = Model.bake_mesh(f"box:{{n}}x{{n}}x{{n}}x0.01")
    return box.rest_m, box.tetrahedra
points, faces = sphere(40, 80)
inputs = grid(38) if "grid" in {work!r} else None
grid = lambda n: inputs
def stop():
    global stopped
    stopped = time.monotonic()
    signal.raise_signal(signal.SIGINT)
{COUNTS}
threading.Timer(0.4, stop).start()
try:
    {work}
    print("was done before")
except KeyboardInterrupt:
    print("interrupted", time.monotonic() - stopped < 0.3, turns > 50)
small = Model.bake_mesh("plane:9x9x0.01")
print(small.cells)
"""
    # It ends by itself within a limit of its own.
    found = ran(program)
    assert found.stdout == "interrupted True True\n81\n", found
    assert found.returncode == 0


def test_a_signal_handler_may_not_use_what_waits(serve: Serve) -> None:
    program = f"""
{stopped(serve())}
signal.signal(signal.SIGUSR1, lambda *_: session.close())
threading.Timer(0.3, os.kill, [os.getpid(), signal.SIGUSR1]).start()
try:
    session.step([0, 0, 0], timeout_s=600)
except chaincell.Error as why:
    print(type(why).__name__, why)
session.close()
print(session.is_closed)
"""
    found = ran(program)
    assert found.stdout.startswith("Error a signal handler uses what its own thread is using"), found
    assert found.stdout.endswith("\nTrue\n")


def test_ctrl_c_ends_the_wait_for_a_turn(serve: Serve) -> None:
    program = f"""
{stopped(serve())}
threading.Thread(target=session.step, args=[[0, 0, 0]], kwargs=dict(timeout_s=600), daemon=True).start()
threading.Timer(0.5, signal.raise_signal, [signal.SIGINT]).start()
try:
    session.step([0, 0, 0], False)
except KeyboardInterrupt:
    print("interrupted", flush=True)
    os._exit(0)
"""
    found = ran(program)
    assert found.stdout == "interrupted\n", found


def test_a_child_of_a_fork_does_not_wait_for_threads_it_has_not(serve: Serve) -> None:
    program = f"""
{stopped(serve())}
threading.Thread(target=session.step, args=[[0, 0, 0]], kwargs=dict(timeout_s=3)).start()
time.sleep(0.3)
child = os.fork()
if child == 0:
    signal.alarm(20)
    try:
        session.step([0, 0, 0])
    except chaincell.Closed as why:
        assert session.is_closed and "closed" in repr(session)
        session.close()
        os._exit(7 if "forked" in str(why) else 3)
    os._exit(4)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
    found = ran(program)
    assert found.stdout == "7\n", found


def test_a_tissue_goes_on_in_a_child() -> None:
    program = """
import os
import chaincell
tissue = chaincell.Tissue(chaincell.Model.bake_mesh("plane:9x9x0.01"), contact=[40])
tissue.tick([0, 0, -0.001])
child = os.fork()
tissue.tick([0, 0, -0.002])
os.write(1, f"{tissue.state_hash}\\n".encode())
if child == 0:
    os._exit(0)
os.waitpid(child, 0)
"""
    first, second = ran(program).stdout.split()
    assert first == second


@pytest.mark.parametrize(
    "left_open",
    [
        "",
        "threading.Thread(target=spin, daemon=True).start(); time.sleep(0.3)",
        "[threading.Thread(target=spin, daemon=True).start() for _ in range(4)]; time.sleep(0.1)",
        "state = next(of for of in iter(lambda: session.state(1), 0) if of); kept = state.positions_m",
        "sys.modules['kept'] = session",
    ],
)
def test_a_program_may_end_with_a_session_open(serve: Serve, left_open: str) -> None:
    server = serve("--state-hz", "200")
    program = f"""
import sys, threading, time
import chaincell
session = chaincell.Session({server.scene!r})
session.state(0)
def spin():
    while True:
        session.step([0, 0, 0], timeout_s=0.5)
session.step([0, 0, 0], False)
{left_open}
print("ends")
"""
    found = ran(program)
    assert (found.returncode, found.stdout, found.stderr) == (0, "ends\n", ""), found
    with Session(server.scene) as session:
        assert session.is_served


def test_threads_share_a_rate() -> None:
    rate, turns, errors = Rate(2000, ticks=400), [], []

    def take() -> None:
        try:
            for turn in rate:
                turns.append(turn)
                assert rate.late >= 0
        except Exception as why:
            errors.append(why)

    threads = [threading.Thread(target=take) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert (sorted(turns), errors) == (list(range(400)), [])
    assert repr(rate) == f"<chaincell.Rate: 2000 Hz, turn 400 is next, {rate.late} late>"


def test_turns_that_are_late_at_once_move_the_schedule_once() -> None:
    program = """
import os, signal, threading, time
from chaincell import Rate
rate = Rate(5)
next(rate)
threads = [threading.Thread(target=next, args=[rate]) for _ in range(2)]
for thread in threads:
    thread.start()
parent = os.getpid()
if os.fork() == 0:
    os.kill(parent, signal.SIGSTOP)
    time.sleep(1.5)
    os.kill(parent, signal.SIGCONT)
    os._exit(0)
for thread in threads:
    thread.join()
begun = time.monotonic()
print(next(rate), time.monotonic() - begun < 0.8, rate.late > 0)
"""
    found = ran(program)
    assert found.stdout == "3 True True\n", found


def test_an_interrupted_turn_is_still_to_come() -> None:
    program = """
import signal, threading
from chaincell import Rate
rate = Rate(2)
print(next(rate), next(rate))
threading.Timer(0.1, signal.raise_signal, [signal.SIGINT]).start()
try:
    next(rate)
except KeyboardInterrupt:
    print(next(rate), next(rate), rate.late)
"""
    assert ran(program).stdout == "0 1\n2 3 0\n"
