"""Every public name says what it takes and gives, alike at runtime and in the stubs, and its example runs.

`CHAINCELL_PAGES=renew python -m pytest tests/test_docstrings.py` in a clone, with the package installed, writes
those of the runtime into the stubs."""

from __future__ import annotations

import ast
import doctest
import inspect
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import chaincell
import chaincell.pictures

from conftest import Server

STUBS = Path(chaincell.__file__).with_name("_native.pyi")
SOURCE = Path(__file__).parents[1] / "python" / "chaincell" / "_native.pyi"
PLAIN = (chaincell.Error, chaincell.Flags, chaincell.Notes)
"""Classes without arguments or an example: their names say all."""


def classes() -> Iterator[tuple[str, type]]:
    for name in chaincell.__all__:
        of = getattr(chaincell, name)
        if isinstance(of, type):
            yield name, of


def members() -> Iterator[tuple[str, object]]:
    """Public classes, functions, methods and properties by their dotted names."""
    yield "run", chaincell.run
    for name, of in classes():
        yield name, of
        if not issubclass(of, PLAIN):
            for member, value in vars(of).items():
                if not member.startswith("_"):
                    yield f"{name}.{member}", value
    for name, of in vars(chaincell.pictures).items():
        if inspect.isfunction(of) and not name.startswith("_"):
            yield f"pictures.{name}", of


def parameters(of: object) -> list[str]:
    """The names that a call may give; none of a property."""
    of = of.__func__ if isinstance(of, staticmethod) else of
    try:
        names = list(inspect.signature(of).parameters)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return []
    return [name for name in names if name != "self"]


def text_of(of: object) -> str:
    return inspect.getdoc(of.__func__ if isinstance(of, staticmethod) else of) or ""


def is_called(of: object) -> bool:
    return isinstance(of, type) or inspect.isroutine(of) or isinstance(of, staticmethod)


def test_everything_public_says_what_it_is() -> None:
    found = dict(members())
    assert len(found) > 110, len(found)
    for name, of in found.items():
        text = text_of(of)
        assert len(text) > 12 and text.rstrip()[-1] not in ",;", f"{name}: {text!r}"
        if not is_called(of) or (isinstance(of, type) and issubclass(of, PLAIN)):
            continue
        assert ">>> " in text, f"{name} has no example"
        missing = [one for one in parameters(of) if f"`{one}`" not in text]
        assert not missing, f"{name} does not say what {missing} are"


@pytest.mark.parametrize("name", ["force_n", "torque_n_m", "positions_m", "path_m", "rest_m", "normal_n", "area_m2"])
def test_arrays_have_shape_and_unit(name: str) -> None:
    of = [(dotted, text_of(value)) for dotted, value in members() if dotted.endswith(f".{name}")]
    assert of
    for dotted, text in of:
        has_shape = "(" in text or "of the shape of" in text
        assert has_shape and "[" in text and "float" in text, f"{dotted}: {text}"


class _Stub:
    """The stub file, with the place of each documented name."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.nodes: dict[str, ast.ClassDef | ast.FunctionDef] = {}
        for node in ast.parse(text).body:
            if isinstance(node, ast.ClassDef):
                self.nodes[node.name] = node
                for member in node.body:
                    if isinstance(member, ast.FunctionDef) and not member.name.startswith("_"):
                        self.nodes[f"{node.name}.{member.name}"] = member
            elif isinstance(node, ast.FunctionDef) and node.name == "run":
                self.nodes[node.name] = node

    def texts(self) -> dict[str, str]:
        return {name: ast.get_docstring(node) or "" for name, node in self.nodes.items()}

    def renewed(self, texts: dict[str, str]) -> str:
        """The file with these texts, from the last one up: the lines above stay where they are."""
        lines = self.text.splitlines()
        for name, node in sorted(self.nodes.items(), key=lambda item: -self.first_line(item[1])):
            indent = " " * (4 * name.count(".") + 4)
            quoted = [f"{indent}{line}".rstrip() for line in f'"""{texts[name]}"""'.splitlines()]
            first, at = node.body[0], self.first_line(node) - 1
            if ast.get_docstring(node):
                lines[at : first.end_lineno] = quoted
            elif isinstance(node, ast.ClassDef):
                lines[at:at] = quoted
            else:
                # `...` stands in the line of the signature.
                lines[at : at + 1] = [lines[at][: first.col_offset].rstrip(), *quoted]
        return "\n".join(lines) + "\n"

    @staticmethod
    def first_line(node: ast.ClassDef | ast.FunctionDef) -> int:
        """The first line of what is in it, decorators among it."""
        first = node.body[0]
        decorators = first.decorator_list if isinstance(first, (ast.ClassDef, ast.FunctionDef)) else []
        return min(of.lineno for of in [first, *decorators])


def test_the_stubs_say_the_same() -> None:
    wanted = {name: text_of(of) for name, of in members() if not name.startswith("pictures.")}
    stub = _Stub(STUBS.read_text())
    wanted = {name: wanted[name] for name in stub.nodes}
    if os.environ.get("CHAINCELL_PAGES") == "renew":
        SOURCE.write_text(_Stub(SOURCE.read_text()).renewed(wanted))
        return
    other = [name for name, text in stub.texts().items() if text != wanted[name]]
    assert not other, f"CHAINCELL_PAGES=renew renews the stubs: {other}"
    shown = {name for name, of in members() if not (isinstance(of, type) and issubclass(of, PLAIN))}
    assert {name for name in shown if not name.startswith("pictures.")} == set(stub.nodes)


def touching(model: chaincell.Model) -> chaincell.Tissue:
    tissue = chaincell.Tissue(model, contact="probe:0.012", sweeps=2)
    for position_m in np.linspace([0, 0, 0.08], [0, 0, 0.05], 100):
        tissue.tick(position_m)
    return tissue


@pytest.fixture
def names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What the examples name; the model file lies in the folder where they run."""
    monkeypatch.chdir(tmp_path)
    model = chaincell.Model.bake_mesh("organ:500", young_pa=5000)
    model.save("liver.chaincell")
    path_m = np.linspace([0, 0, 0.08], [0, 0, 0.05], 100)
    result = chaincell.run(model, path_m, contact="probe:0.012", sweeps=2)
    return {"chaincell": chaincell, "np": np, "model": model, "path_m": path_m, "result": result}


def ran(name: str, text: str, names: dict[str, Any]) -> None:
    test = doctest.DocTestParser().get_doctest(text, dict(names), name, None, 0)
    said: list[str] = []
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS)
    assert not runner.run(test, out=said.append).failed, "".join(said)


def is_of_a_session(name: str) -> bool:
    return name.split(".")[0] in ("Session", "SessionStress", "State", "Answer", "Reply")


def test_the_examples_run(names: dict[str, Any]) -> None:
    for name, of in members():
        if not is_of_a_session(name):
            ran(name, text_of(of), {**names, "tissue": touching(names["model"])})


def test_the_examples_of_a_session_run(
    names: dict[str, Any], serve: Callable[..., Server], tmp_path: Path
) -> None:
    server = serve("--contact", "probe:0.012", "--record", str(tmp_path / "left.trace"), model=names["model"])
    # The class opens the scene itself, and a scene has one controller.
    ran("Session", chaincell.Session.__doc__.replace('"left"', repr(server.scene)) + "\n>>> session.close()\n", names)
    session = chaincell.Session(server.scene)
    # From its first look on a reader gets the states that come after it.
    session.state(0.0), session.contacts(0.0)
    for name, of in sorted(members(), key=lambda member: member[0] == "Session.close"):
        if is_of_a_session(name) and name != "Session":
            session.step([0.0, 0.0, 0.08], engaged=False)
            ran(name, text_of(of), {**names, "session": session})
    assert session.is_closed


def test_a_picture_without_its_library_names_the_package(
    names: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(ImportError, match="pip install matplotlib"):
        names["result"].plot_force()
    for body in ("result", "model"):
        with pytest.raises(ImportError, match="pip install pyvista"):
            names[body].show()
    with pytest.raises(chaincell.ArgumentError, match='`against` "speed": give time or depth'):
        names["result"].plot_force(against="speed")


def test_a_run_has_positions(names: dict[str, Any]) -> None:
    result, tissue = names["result"], touching(names["model"])
    assert np.array_equal(result.positions_m, tissue.positions_m)
    assert result.positions_m.dtype == np.float32
    assert np.array_equal(result.path_m, names["path_m"].astype(np.float32))
    assert result.model is names["model"]
    several = chaincell.run(names["model"], np.zeros((3, 2, 3)) + 0.2, tools=["sphere:0.01"] * 2)
    assert several.path_m.shape == several.force_n.shape == (3, 2, 3)
    assert np.isnan(chaincell.pictures.depth_m(several)).all()
    depth_m = chaincell.pictures.depth_m(result)
    touched = result.contacts.nonzero()[0][0]
    assert np.isnan(depth_m[:touched]).all() and depth_m[touched] == 0.0
    assert depth_m[-1, 0] == pytest.approx(np.linalg.norm(result.path_m[-1] - result.path_m[touched]))
