"""The examples with libraries of the field, each as a program without a screen."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import chaincell

from conftest import SHORT_S, Server

FIELD = Path(__file__).parents[1] / "examples" / "field"
LONG_S = 8 * SHORT_S
"""Longest time of a program that loads hundreds of megabytes."""


def start(name: str, *arguments: object) -> subprocess.Popen[str]:
    command = [sys.executable, FIELD / name, *map(str, arguments)]
    environment = {**os.environ, "RERUN_ANALYTICS": "0"}
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)


def end(program: subprocess.Popen[str]) -> str:
    out, _ = program.communicate(timeout=LONG_S)
    assert program.returncode == 0, out
    return out


@pytest.fixture
def box_file(box: chaincell.Model, tmp_path: Path) -> Path:
    file = tmp_path / "box.chaincell"
    box.save(file)
    return file


def press(scene: str, until: Callable[[], bool]) -> None:
    """Presses the box 9 mm deep by the example's tool, and goes on until told; a server may stand still meanwhile."""
    with chaincell.Session(scene) as session:
        for tick in chaincell.Rate(500):
            depth_m = min(3e-5 * tick, 0.012)
            with contextlib.suppress(chaincell.NoServer):
                session.step([0, 0, 0.051 - depth_m], engaged=tick > 0)
            if until():
                return


NOTEBOOK = """
import sys
import matplotlib, pyvista
matplotlib.use("Agg")
pyvista.OFF_SCREEN = True
pictures = iter(["rest.png", "pressed.png"])
show = pyvista.Plotter.show
pyvista.Plotter.show = lambda self, **options: show(self, **{"screenshot": next(pictures), **options})
names = {}
exec(compile(open(sys.argv[1]).read(), sys.argv[1], "exec"), names)
axes = matplotlib.pyplot.gca()
axes.figure.savefig("force.png")
(line,) = axes.lines
print(axes.get_xlabel(), axes.get_ylabel(), line.get_xdata()[-1], line.get_ydata()[-1])
print(names["result"].force_n[-1][2])
"""
"""Runs a notebook without a screen, and keeps its pictures."""


def test_a_notebook_shows_a_force_curve_and_a_body(tmp_path: Path) -> None:
    pytest.importorskip("pyvista")
    pytest.importorskip("matplotlib")
    image = pytest.importorskip("PIL.Image")
    program = [sys.executable, "-c", NOTEBOOK, FIELD / "notebook.py"]
    ended = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True, timeout=LONG_S)
    assert ended.returncode == 0, ended.stderr
    curve, force = ended.stdout.splitlines()[-2:]
    x, unit, y, force_unit, depth_mm, largest_n = curve.split()
    assert (x, unit, y, force_unit) == ("depth", "[mm]", "force", "[N]")
    assert 5 < float(depth_mm) < 45 and float(largest_n) >= abs(float(force)) > 0.05

    def colours(name: str) -> int:
        return len(np.unique(np.asarray(image.open(tmp_path / name).convert("RGB")).reshape(-1, 3), axis=0))

    assert colours("rest.png") > 20 and colours("pressed.png") > 200 and colours("force.png") > 5


def test_rerun_records_a_scene(serve: Callable[..., Server], box: chaincell.Model, box_file: Path) -> None:
    pytest.importorskip("rerun")
    server = serve("--tool", "sphere:0.01", model=box)
    file = box_file.with_name("press.rrd")
    program = start("rerun_scene.py", server.scene, box_file, file)
    over = threading.Event()
    hand = threading.Thread(target=press, args=(server.scene, over.is_set))
    hand.start()
    try:
        # Some states are in the file; how many a second is the machine's matter.
        while program.poll() is None and hand.is_alive() and (not file.exists() or file.stat().st_size < 100_000):
            over.wait(0.1)
    finally:
        over.set()
        hand.join()
    server.interrupt()
    end(program)
    content = file.read_bytes()
    assert content.startswith(b"RRF2")
    for part in [b"/body", b"/contacts", b"/force_n"]:
        assert part in content, part


def test_viser_plays_the_hand(serve: Callable[..., Server], box: chaincell.Model, box_file: Path) -> None:
    pytest.importorskip("viser")
    server = serve("--tool", "sphere:0.01", model=box)
    out = end(start("viser_hand.py", server.scene, box_file, 1))
    assert "127.0.0.1" in out and "0.0.0.0" not in out, out
    assert server.interrupt()["ticks_executed"] == 1000


def test_mcap_holds_every_tick(command: Path, box_file: Path) -> None:
    reader = pytest.importorskip("mcap.reader")
    folder, file = box_file.with_name("press"), box_file.with_name("press.mcap")
    run = [command, "run", box_file, "--tool", "sphere:0.01", "--motion", "press", "--seconds", "0.5", "--out", folder]
    subprocess.run(run, check=True, stdout=subprocess.DEVNULL, timeout=LONG_S)
    end(start("mcap_export.py", folder, file))
    with file.open("rb") as stream:
        messages = list(reader.make_reader(stream).iter_messages())
    rows = np.genfromtxt(folder / "force.csv", delimiter=",", names=True)
    assert len(messages) == len(rows) >= 500
    for (schema, channel, message), row in zip(messages, rows):
        tick = json.loads(message.data)
        assert message.log_time == 1_000_000 * int(row["tick"])
        assert (schema.name, channel.topic, tick["fz_n"]) == ("chaincell.Tick", "/tool", row["fz_n"])
        assert {"x_m", "energy_j", "contacts"} <= set(tick)
    assert max(json.loads(message.data)["fz_n"] for _, _, message in messages) > 0
