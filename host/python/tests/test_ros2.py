"""The ROS 2 node against a stub of rclpy, whose clock is simulated, and a tissue that is a spring; and on a served
scene with ROS itself, where that is installed."""

from __future__ import annotations

import importlib.util
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from conftest import SHORT_S, Server

import chaincell

FILE = Path(__file__).parents[1] / "examples" / "field" / "ros2_node.py"


class Message:
    """Any message: its fields are there once they are named."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        value = Message()
        setattr(self, name, value)
        return value


class StubNode:
    """What of rclpy.node.Node the example uses."""

    def __init__(self, name: str) -> None:
        self.ns = 0
        self.published: list[Message] = []
        self.topics: list[str] = []
        self.warnings: list[str] = []

    def get_clock(self) -> Any:
        moment = SimpleNamespace(nanoseconds=self.ns, to_msg=lambda: self.ns)
        return SimpleNamespace(now=lambda: moment)

    def create_publisher(self, kind: type, topic: str, depth: int) -> Any:
        self.topics.append(topic)
        return SimpleNamespace(publish=self.published.append)

    def create_subscription(self, kind: type, topic: str, callback: Callable[..., None], depth: int) -> None:
        self.topics.append(topic)

    def create_timer(self, seconds: float, callback: Callable[[], None]) -> None:
        assert seconds <= 0.001

    def get_logger(self) -> Any:
        return SimpleNamespace(warning=lambda text, **_: self.warnings.append(text))


class Spring:
    """A session whose tissue pushes up with 100 N/m below z = 0."""

    def __init__(self) -> None:
        self.notes = chaincell.Notes(0)
        self.answer: Any = None

    def step(self, pose: list[float], engaged: bool, timeout_s: float) -> None:
        import numpy as np

        force_n = np.array([0, 0, 100 * max(0.0, -pose[2]) if engaged else 0.0], np.float32)
        self.answer = SimpleNamespace(force_n=force_n, torque_n_m=np.zeros(3, np.float32), notes=self.notes)


@pytest.fixture
def node(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The node, after 200 poses 10 mm deep."""
    stubs = {"rclpy": {}, "rclpy.node": {"Node": StubNode}, "geometry_msgs": {}}
    stubs["geometry_msgs.msg"] = {"PoseStamped": Message, "WrenchStamped": Message}
    for name, content in stubs.items():
        module = ModuleType(name)
        module.__dict__.update(content)
        monkeypatch.setitem(sys.modules, name, module)
    spec = importlib.util.spec_from_file_location("ros2_node", FILE)
    assert spec is not None and spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    node = example.Tissue(Spring())
    for _ in range(200):
        pose(node)
    assert node.topics == ["measured_cf", "servo_cp"]
    assert all(force(message) == 0 for message in node.published[:100])
    assert force(node.published[-1]) == pytest.approx(1.0)
    return node


def pose(node: Any, z_m: float = -0.01) -> None:
    """A millisecond later."""
    node.ns += 1_000_000
    message = Message()
    values = {"position.x": 0.0, "position.y": 0.0, "position.z": z_m}
    values |= {"orientation.x": 0.0, "orientation.y": 0.0, "orientation.z": 0.0, "orientation.w": 1.0}
    for name, value in values.items():
        part, axis = name.split(".")
        setattr(getattr(message.pose, part), axis, value)
    message.header.frame_id = "tool"
    node.servo_cp(message)


def force(message: Any) -> float:
    vector = message.wrench.force
    return math.hypot(vector.x, vector.y, vector.z)


def falls(node: Any, since: int) -> None:
    """The force has gone to 0 along the ramp, and stays there."""
    forces = [force(message) for message in node.published[since:]]
    assert forces[:10] == pytest.approx([0.9 - 0.1 * step for step in range(10)], abs=1e-6)
    assert not any(forces[10:])


@pytest.mark.parametrize("bad", [math.nan, math.inf, 0.05])
def test_a_bad_pose_lets_the_force_fall_for_a_hundred_poses(node: Any, bad: float) -> None:
    since = len(node.published)
    pose(node, bad)
    for _ in range(98):
        pose(node)
    falls(node, since)
    for _ in range(60):
        pose(node)
    assert force(node.published[-1]) == pytest.approx(1.0)


@pytest.mark.parametrize("note", [chaincell.Notes.SILENT, chaincell.Notes.NEW_SESSION])
def test_an_old_answer_lets_it_fall(node: Any, note: chaincell.Notes) -> None:
    since = len(node.published)
    node.session.notes = note
    for _ in range(150):
        pose(node)
    falls(node, since)


def test_poses_that_stay_out_and_the_end_let_it_fall(node: Any) -> None:
    since = len(node.published)
    for _ in range(40):
        node.ns += 1_000_000
        node.watch()
    falls(node, since)
    for _ in range(200):
        pose(node)
    since = len(node.published)
    node.let_go()
    falls(node, since)
    assert force(node.published[-1]) == 0


def to_and_fro_m(time_s: float) -> float:
    """Height of the ball's middle in a press every two seconds: from 4 mm above the box to 4 mm in it [m]."""
    return 0.052 + 0.004 * math.cos(math.pi * time_s)


def travels(rclpy: Any, messages: Any) -> bool:
    """True if a message of one participant of ROS reaches another one on this machine."""
    near, far = rclpy.Context(), rclpy.Context()
    rclpy.init(context=near)
    rclpy.init(context=far)
    node, other = (rclpy.create_node("probe", context=context) for context in (near, far))
    found: list[Any] = []
    other.create_subscription(messages.PoseStamped, "probe", found.append, 1)
    sent = node.create_publisher(messages.PoseStamped, "probe", 1)
    executor = rclpy.executors.SingleThreadedExecutor(context=far)
    executor.add_node(other)
    start = time.monotonic()
    while not found and time.monotonic() - start < SHORT_S / 2:
        sent.publish(messages.PoseStamped())
        executor.spin_once(timeout_sec=0.01)
    for each, context in ((node, near), (other, far)):
        each.destroy_node()
        rclpy.shutdown(context=context)
    return bool(found)


def test_a_node_of_ros_itself_has_the_force_of_a_served_scene(
    serve: Callable[..., Server], box: chaincell.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    rclpy = pytest.importorskip("rclpy")
    messages = pytest.importorskip("geometry_msgs.msg")
    # Nobody else is in this domain.
    monkeypatch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    monkeypatch.setenv("ROS_LOCALHOST_ONLY", "1")
    if not travels(rclpy, messages):
        pytest.skip("messages of ROS do not travel on this machine")
    server = serve("--tool=sphere:0.012", model=box)
    program = subprocess.Popen([sys.executable, FILE, server.scene])
    rclpy.init()
    hand = rclpy.create_node("hand")
    try:
        wrenches: list[Any] = []
        hand.create_subscription(messages.WrenchStamped, "measured_cf", wrenches.append, 1)
        poses = hand.create_publisher(messages.PoseStamped, "servo_cp", 1)
        message = messages.PoseStamped()
        message.header.frame_id, message.pose.orientation.w = "tool", 1.0

        def until(is_there: Callable[[], bool], sends: bool) -> None:
            start = time.monotonic()
            while not is_there():
                assert program.poll() is None and time.monotonic() - start < SHORT_S, wrenches[-1:]
                if sends:
                    message.pose.position.z = to_and_fro_m(time.monotonic() - start)
                    poses.publish(message)
                rclpy.spin_once(hand, timeout_sec=0.001)

        # The box pushes up, and along its axis.
        until(lambda: bool(wrenches) and wrenches[-1].wrench.force.z > 0.05, sends=True)
        found = wrenches[-1]
        assert math.hypot(found.wrench.force.x, found.wrench.force.y) < 0.2 * found.wrench.force.z
        # Without poses it falls to 0.
        until(lambda: force(wrenches[-1]) == 0, sends=False)
    finally:
        hand.destroy_node()
        rclpy.shutdown()
        program.send_signal(signal.SIGINT)
        program.wait(SHORT_S)
