"""A Gymnasium-style environment: hold a wanted force against soft tissue.

The agent moves a probe up and down; what it observes is the depth, the force and the wanted force. It
needs `pip install gymnasium`. Without a server: the tissue ticks in this process, ten times a step.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

import chaincell

Observation = npt.NDArray[np.float32]
Action = npt.NDArray[np.float32]

TICKS_A_STEP = 10
STEPS = 200
FARTHEST_M = 0.012
"""Largest distance of the probe's centre from where it begins."""
MOVE_M = 0.0005
"""Largest move of a step."""
FORCE_MAX_N = 10.0


class HoldForce(gymnasium.Env[Observation, Action]):
    """Press a box of soft tissue until it pushes back with the wanted force."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self) -> None:
        model = chaincell.Model.bake_mesh("box:7x7x5x0.01", young_pa=5000)
        self.tissue = chaincell.Tissue(model, tools=["sphere:0.008"], max_force_n=FORCE_MAX_N)
        self.start_m = np.array([0.0, 0.0, 0.049])
        self.depth_m = 0.0
        self.wanted_n = 0.0
        self.steps = 0
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)
        low = np.array([0.0, -FORCE_MAX_N, 0.0], np.float32)
        high = np.array([FARTHEST_M, FORCE_MAX_N, FORCE_MAX_N], np.float32)
        self.observation_space = gymnasium.spaces.Box(low, high, dtype=np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self.tissue.reset()
        self.depth_m, self.steps = 0.0, 0
        self.wanted_n = float(self.np_random.uniform(0.05, 0.3))
        return self.observe(0.0), {}

    def step(
        self, action: Action
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        before_m = self.depth_m
        move_m = MOVE_M * float(np.clip(action[0], -1.0, 1.0))
        self.depth_m = float(np.clip(before_m + move_m, 0.0, FARTHEST_M))
        for depth_m in np.linspace(before_m, self.depth_m, TICKS_A_STEP + 1)[1:]:
            output = self.tissue.tick(self.start_m - [0.0, 0.0, depth_m])
        force_n = float(output.force_n[2])
        self.steps += 1
        reward = -abs(force_n - self.wanted_n)
        info = {"energy_j": output.energy_j, "state_hash": self.tissue.state_hash}
        return self.observe(force_n), reward, False, self.steps >= STEPS, info

    def observe(self, force_n: float) -> Observation:
        return np.array([self.depth_m, force_n, self.wanted_n], np.float32)


if __name__ == "__main__":
    env = HoldForce()
    observation, info = env.reset(seed=1)
    truncated, total = False, 0.0
    while not truncated:
        # Deeper where the force is too small.
        wish = np.clip(20.0 * (observation[2:] - observation[1:2]), -1.0, 1.0)
        observation, reward, _, truncated, info = env.step(wish)
        total += reward
    depth_m, force_n, wanted_n = observation
    print(f"wanted {wanted_n:.3f} N, felt {force_n:.3f} N at {1e3 * depth_m:.1f} mm, reward {total:.2f}")
