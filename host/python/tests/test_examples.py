"""The environment is one, by Gymnasium's own checks, and a seed gives the same bits."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest


@pytest.fixture
def example() -> ModuleType:
    pytest.importorskip("gymnasium")
    file = Path(__file__).parents[1] / "examples" / "gym_env.py"
    spec = importlib.util.spec_from_file_location("gym_env", file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.filterwarnings("error")
def test_gymnasium_takes_the_environment(example: ModuleType) -> None:
    from gymnasium.utils.env_checker import check_env

    check_env(example.HoldForce(), skip_render_check=True)


def test_a_seed_gives_the_same_bits(example: ModuleType) -> None:
    def episode() -> list[object]:
        env = example.HoldForce()
        observation, _ = env.reset(seed=7)
        rows: list[object] = [observation.tolist()]
        for _ in range(60):
            observation, reward, _, _, info = env.step(np.array([0.8], np.float32))
            rows.append((observation.tolist(), reward, info["state_hash"]))
        assert observation[1] > 0.01
        return rows

    assert episode() == episode()
