"""Curves by matplotlib and bodies by PyVista, each loaded where it is used: `Run.plot_force`, `Run.show` and
`Model.show` call these."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import numpy.typing as npt

from chaincell._native import Model, Run

_COLOURS = "cividis"


def _library(name: str, package: str) -> Any:
    """Loads a library of the field; the error names the package that has it."""
    try:
        return importlib.import_module(name)
    except ImportError as why:
        raise ImportError(f"this picture needs {package}: pip install {package}") from why


def depth_m(run: Run) -> npt.NDArray[np.float64]:
    """Returns the distance of each tool from where one first touched [m], (ticks, tools); not a number before.

    `run` is a `chaincell.Run`; held cells touch from its first tick on.

    >>> chaincell.pictures.depth_m(result).shape
    (100, 1)
    """
    path_m = run.path_m.reshape(len(run), -1, 3).astype(np.float64)
    touches = np.flatnonzero(run.contacts)
    if not touches.size:
        return np.full(path_m.shape[:2], np.nan)
    depth: npt.NDArray[np.float64] = np.linalg.norm(path_m - path_m[touches[0]], axis=2)
    depth[: touches[0]] = np.nan
    return depth


def plot_force(run: Run, axes: Any = None, against: str = "time") -> Any:
    """Draws the force of a run; `Run.plot_force` says how.

    Arguments are `run`, `axes` and `against`, in N over ms or mm; the axes are returned.

    >>> chaincell.pictures.plot_force(result)  # doctest: +SKIP
    """
    if axes is None:
        axes = _library("matplotlib.pyplot", "matplotlib").subplots()[1]
    force_n = np.linalg.norm(run.force_n.reshape(len(run), -1, 3), axis=2)
    depths = depth_m(run) if against == "depth" else None
    for tool in range(force_n.shape[1]):
        x = np.arange(len(run)) if depths is None else 1e3 * depths[:, min(tool, depths.shape[1] - 1)]
        axes.plot(x, force_n[:, tool], label=f"tool {tool}")
    axes.set_xlabel("time [ms]" if depths is None else "depth [mm]")
    axes.set_ylabel("force [N]")
    if force_n.shape[1] > 1:
        axes.legend()
    return axes


def body(model: Model, positions_m: npt.ArrayLike) -> Any:
    """Returns the surface of a body as `pyvista.PolyData`, with `displacement_mm` at its points.

    `model` has the triangles; `positions_m` [m], (nodes, 3), are in the order of its `node_ids`. A body
    without triangles is a cloud of points. Raises `ImportError` where PyVista is not installed.

    >>> chaincell.pictures.body(model, model.rest_m)  # doctest: +SKIP
    """
    pyvista = _library("pyvista", "pyvista")
    positions_m = np.asarray(positions_m)
    corners = np.searchsorted(model.node_ids, model.triangles)
    surface = pyvista.PolyData.from_regular_faces(positions_m, corners) if len(corners) else pyvista.PolyData(positions_m)
    surface["displacement_mm"] = 1e3 * np.linalg.norm(positions_m - model.rest_m, axis=1)
    return surface


def show(model: Model, positions_m: npt.ArrayLike, **options: Any) -> Any:
    """Shows a body; `Model.show` and `Run.show` say how.

    `model`, and `positions_m` [m], (nodes, 3); `options` go to `pyvista.Plotter.show`.

    >>> chaincell.pictures.show(model, model.rest_m)  # doctest: +SKIP
    """
    plotter = _library("pyvista", "pyvista").Plotter()
    surface = body(model, positions_m)
    moved = bool(surface["displacement_mm"].max() > 0.0)
    plotter.add_mesh(surface, scalars="displacement_mm" if moved else None, cmap=_COLOURS if moved else None)
    return plotter.show(**options)
