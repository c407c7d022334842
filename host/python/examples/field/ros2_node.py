"""A ROS 2 node on a served scene, by the names of CRTK: a pose in (`servo_cp`), the force of the tissue out (`measured_cf`).

`chaincell serve liver.chaincell --tool sphere:0.012 --scene left` runs meanwhile; then, where ROS 2 is set up,
`python ros2_node.py left`. Poses are in the frame of the mesh [m], at some 1,000 a second. The force is off until
a hundred poses in a row were good; it goes off along a ramp where a pose is no number, jumps or stays out, and where
the tissue's answers do. The driver of the device has the last word: it has to watch `measured_cf` too.
"""

from __future__ import annotations

import math
import sys
import time

import rclpy
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.node import Node

import chaincell

JUMP_M = 0.008
CALM = 200
"""Good poses and fresh answers in a row before the tool engages."""
RAMP_POSES = 10
SILENT_NS = 10_000_000
DEPTH = 1
"""Messages that wait: an old pose is of no use."""


class Tissue(Node):
    """Steps the session with each pose, and publishes the force to show."""

    def __init__(self, session: chaincell.Session) -> None:
        super().__init__("chaincell")
        self.session = session
        self.calm = self.share = 0
        self.engaged = False
        self.last_m: list[float] | None = None
        self.last_ns = self.get_clock().now().nanoseconds
        self.wrench = [0.0] * 6
        self.publisher = self.create_publisher(WrenchStamped, "measured_cf", DEPTH)
        self.create_subscription(PoseStamped, "servo_cp", self.servo_cp, DEPTH)
        self.create_timer(0.001, self.watch)

    def servo_cp(self, message: PoseStamped) -> None:
        """Takes a pose."""
        place, turn = message.pose.position, message.pose.orientation
        pose = [place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w]
        self.last_ns = self.get_clock().now().nanoseconds
        is_good = all(map(math.isfinite, pose))
        if is_good:
            is_good = self.last_m is None or math.dist(pose[:3], self.last_m) <= JUMP_M
            self.last_m = pose[:3]
        self.judge(is_good)
        if self.calm >= CALM and self.share == 0:
            self.engaged = True
        if is_good:
            self.judge(self.step(pose))
        self.publish(message.header.frame_id)

    def step(self, pose: list[float]) -> bool:
        """Asks the tissue; false without a fresh answer."""
        try:
            self.session.step(pose, engaged=self.engaged, timeout_s=0.002)
        except chaincell.PoseError as why:
            self.get_logger().warning(f"{why}; force off", throttle_duration_sec=1.0)
            return False
        answer = self.session.answer
        old = chaincell.Notes.NOTHING_YET | chaincell.Notes.SILENT | chaincell.Notes.NEW_SESSION
        if answer is None or answer.notes & old:
            return False
        if self.engaged:
            self.wrench = [*answer.force_n.tolist(), *answer.torque_n_m.tolist()]
        return True

    def judge(self, is_good: bool) -> None:
        """Lets the tool go on a doubt."""
        self.calm = self.calm + 1 if is_good else 0
        self.engaged = self.engaged and is_good

    def watch(self) -> None:
        """Lowers the force once the poses stay out."""
        silent_ns = self.get_clock().now().nanoseconds - self.last_ns
        if silent_ns >= SILENT_NS and (self.engaged or self.share > 0):
            self.judge(False)
            self.publish("")

    def publish(self, frame_id: str) -> None:
        """Publishes the force, a step of its ramp on."""
        self.share = max(0, min(RAMP_POSES, self.share + (1 if self.engaged else -1)))
        message = WrenchStamped()
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = frame_id
        values = [value * self.share / RAMP_POSES for value in self.wrench]
        force, torque = message.wrench.force, message.wrench.torque
        force.x, force.y, force.z, torque.x, torque.y, torque.z = values
        self.publisher.publish(message)

    def let_go(self) -> None:
        """Lets the force fall; the last one is 0."""
        self.engaged, self.calm = False, 0
        while self.share > 0:
            self.publish("")
            time.sleep(0.001)


def main() -> None:
    rclpy.init()
    with chaincell.Session(sys.argv[1], watchdog_ms=10, ramp_ms=10) as session:
        node = Tissue(session)
        try:
            rclpy.spin(node)
        except (KeyboardInterrupt, chaincell.NoServer) as why:
            node.get_logger().info(f"end: {why!r}")
        finally:
            node.let_go()
            node.destroy_node()


if __name__ == "__main__":
    main()
