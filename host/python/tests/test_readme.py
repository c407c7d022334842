"""The page's Python runs, one block after the other."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import chaincell


def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (Path(__file__).parents[1] / "README.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    assert len(blocks) == 3
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks:
        exec(block, names)
    assert (tmp_path / "corner.chaincell").exists()


def test_the_page_names_every_error_and_class() -> None:
    page = (Path(__file__).parents[1] / "README.md").read_text()
    errors = [name for name, of in vars(chaincell).items() if isinstance(of, type) and issubclass(of, chaincell.Error)]
    assert len(errors) == 14
    assert "OverflowError" not in page
    for name in [*errors, "Model", "Tissue", "Session", "Rate", "Flags", "Notes"]:
        assert re.search(rf"`(chaincell\.)?{name}\b", page), name
