"""A small model, the command, and servers on scenes of their own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import chaincell

TOP = Path(__file__).resolve().parents[3]
SHORT_S = 60
"""Longest time for what ends by itself."""

# A shell starts what it runs in its background with SIGINT ignored, and programs inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)

COUNTS = """
import threading, time
turns = 0
def count():
    global turns
    while True:
        turns += 1
        time.sleep(0.001)
threading.Thread(target=count, daemon=True).start()
"""
"""Part of a program: its `turns` tell whether other threads have their turn."""


def ran(program: str) -> subprocess.CompletedProcess[str]:
    """A program that ends by itself."""
    return subprocess.run(
        [sys.executable, "-W", "ignore", "-c", program], capture_output=True, text=True, timeout=SHORT_S
    )


@pytest.fixture(scope="session")
def command() -> Path:
    """The built `chaincell`."""
    named = os.environ.get("CHAINCELL")
    places = [Path(named)] if named else [TOP / "target" / of / "chaincell" for of in ("release", "debug")]
    found = next((place for place in places if place.exists()), None)
    assert found is not None, f"no chaincell in {places}: cargo build --release --bin chaincell"
    return found


@pytest.fixture(scope="session")
def plane() -> chaincell.Model:
    """81 cells; node 40 is the middle."""
    return chaincell.Model.bake_mesh("plane:9x9x0.01", alpha=0.02)


@pytest.fixture(scope="session")
def box() -> chaincell.Model:
    """Soft tissue with a contact surface; its top is at 40 mm."""
    return chaincell.Model.bake_mesh("box:7x7x5x0.01", young_pa=5000)


def press(ticks: int) -> np.ndarray:
    """Into the plane's middle, and 0.3 mm deeper every tick, at most 12 mm."""
    path = np.zeros((ticks, 3))
    path[:, 1] = 0.001
    path[:, 2] = -0.0003 * np.minimum(np.arange(ticks), 40)
    return path


class Server:
    """A running `chaincell serve`."""

    def __init__(self, command: Path, model: Path, options: list[str]) -> None:
        self.scene = f"python-{os.getpid()}-{uuid.uuid4().hex[:8]}"
        self.log = model.with_name(f"{self.scene}.log")
        self.process = subprocess.Popen(
            [command, "serve", model, "--scene", self.scene, "--late-share", "off", "--json", *options],
            stdout=subprocess.PIPE,
            stderr=self.log.open("w"),
            text=True,
        )
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line == "ready\n", f"{line!r}: {self.log.read_text()}"

    def end(self) -> dict[str, object]:
        """What it says at its end."""
        out, _ = self.process.communicate(timeout=SHORT_S)
        return json.loads(out)

    def interrupt(self) -> dict[str, object]:
        """The same after Ctrl-C."""
        self.process.send_signal(signal.SIGINT)
        return self.end()

    def kill(self) -> None:
        """As a crash would."""
        self.process.kill()
        self.process.wait(SHORT_S)


@pytest.fixture
def serve(
    command: Path, plane: chaincell.Model, tmp_path: Path
) -> Iterator[Callable[..., Server]]:
    """Starts servers, of the plane unless told otherwise, and kills those that are left."""
    servers: list[Server] = []

    def start(*options: str, model: chaincell.Model = plane) -> Server:
        file = tmp_path / f"{model.checksum}.chaincell"
        model.save(file)
        held = () if any(of.startswith(("--contact", "--tool")) for of in options) else ("--contact", "40")
        servers.append(Server(command, file, [*held, *options]))
        return servers[-1]

    yield start
    for server in servers:
        server.process.kill()
        server.process.wait(SHORT_S)
