"""The Python of the pages runs, and the package's own text names what there is."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import chaincell

from conftest import Server

HERE = Path(__file__).parents[1]


def blocks(page: Path) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```$", page.read_text(), re.DOTALL | re.MULTILINE)


def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (block,) = blocks(HERE / "README.md")
    monkeypatch.chdir(tmp_path)
    exec(block, {})
    assert (tmp_path / "corner.chaincell").exists()


def host_page(name: str) -> Path:
    """A page of the host: copied next to the tests, or in the tree."""
    return next(page for page in (HERE / name, HERE.parent / name) if page.exists())


def test_the_batch_of_the_guide_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (block,) = blocks(host_page("GUIDE.md"))
    monkeypatch.chdir(tmp_path)
    chaincell.Model.bake_mesh("organ:500", young_pa=5000).save("liver.chaincell")
    exec(block, {})
    forces_n = [float(line.split()[0]) for line in capsys.readouterr().out.splitlines()]
    assert len(forces_n) == 3
    assert 0 < forces_n[0] < forces_n[1] < forces_n[2]


def test_the_page_of_simulators_runs(serve: Callable[..., Server]) -> None:
    (block,) = blocks(host_page("SIMULATOR.md"))
    model = chaincell.Model.bake_mesh("organ:500", young_pa=5000)
    server = serve("--tool", "sphere:0.012", model=model)
    names: dict[str, Any] = {}
    exec(block.replace('"left"', repr(server.scene)), names)
    assert names["force_n"][2] > 0.01
    assert server.interrupt()["ticks_executed"] == 1000


def test_the_text_names_every_error_and_class() -> None:
    text = chaincell.__doc__ or ""
    errors = [name for name, of in vars(chaincell).items() if isinstance(of, type) and issubclass(of, chaincell.Error)]
    assert len(errors) == 14
    assert "OverflowError" not in text
    for name in [*errors, "Model", "Tissue", "Session", "Rate", "Flags", "Notes"]:
        assert re.search(rf"`(chaincell\.)?{name}\b", text), name
