"""Keyword arguments of `Model.bake` and `Tissue`, for type checkers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, TypedDict, Union

import numpy.typing as npt

PerNode = Union[float, str, npt.ArrayLike]
"""A number for all nodes, an array with one for each, or a text as the command line has it."""


class BakeOptions(TypedDict, total=False):
    """Those of `Model.bake` and `Model.bake_mesh`: the options of `chaincell bake`."""

    tissue: str | None
    """Tissue by name, of those that `chaincell tissues` lists, or "FILE.csv:NAME" of a table as `chaincell
    relaxation` writes it; what is given beside it goes before."""
    young_pa: PerNode | None
    """Young's modulus [Pa]; without it, `materials` and `tissue` the body is made of links."""
    poisson: PerNode | None
    """Poisson's ratio, 0 to 0.495; 0.45 by default."""
    materials: Mapping[str, Mapping[str, float]] | None
    """What groups of the mesh are made of, {"hard": {"young_pa": 20000, "poisson": 0.4}}: one of both at
    least, the rest from `young_pa` and `poisson`; a later group counts where groups share nodes."""
    fixed: npt.ArrayLike | str | None
    """Nodes held for ever: ids, a mask of all nodes, a selector, or "none"."""
    alpha: PerNode | None
    """Half-width of a link's band in rest lengths, in [0, 1)."""
    stiffness_n_per_m: PerNode | None
    """Stiffness of a link [N/m]; with `branches` the long-term one, unless `instant` says otherwise."""
    stretch_min: float | Literal["none"] | None
    stiffening: Mapping[float | str, float] | None
    """Half-widths of bands with the moduli [Pa] that they add; they do not relax. "short:0.035" resists what is
    shortened alone, "long:0.1" what is lengthened alone."""
    branches: Sequence[tuple[float, float]] | None
    """Branches of stress that relaxes, up to four: the shear modulus, or the stiffness of links, over the
    long-term one, and the time [s] in which the stress falls to 1 / e, one tick to 1,600,000. `poisson` is the
    instantaneous ratio then, since only shear relaxes. An empty list leaves out those of `tissue`."""
    instant: bool | None
    """`young_pa`, or `stiffness_n_per_m`, is the value before anything has relaxed, not the long-term one."""
    device_hz: int | None
    """Ticks in a second for which branches are baked, from 10 to 100000; 1000 by default. `Tissue` and
    `run` refuse another `device_hz`."""
    contact_surface: Literal["auto", "yes", "no"] | None
    cuttable: bool | None
    """Prepares a body of tetrahedra for the cuts of tools with a blade, "blade:LENGTH" or "scissors:LENGTH"."""
    cut_spare: float | None
    """Number of spare cells for each cell, from 0 to 4."""
    toughness_j_per_m2: PerNode | None
    """Energy that a cut takes for each area [J/m^2]."""
    tears: bool | None
    """The body tears by itself where its energy reaches a fifth of the toughness for each mean edge."""
    tear_stretch: float | None
    """The body tears by itself where it is stretched so far, 1.01 to 10 at a mean edge of 5 mm."""
    loose: Literal["leave", "freeze", "drop"] | None
    """What becomes of pieces that a cut takes off: they move, they stay where they are, or they are gone."""
    cells: int | None
    """Groups of nodes, each of them a cell, from 2 to 65535."""
    coarse: float | Literal["auto", "none"] | None
    unit_m: float | None
    """Metres in one unit of the coordinates; of a generator it is 1."""
    fill_m: float | str | None
    """Size of the tetrahedra that fill a closed surface [m]: `triangles`, triangles of an object, or a
    file of STL, OBJ or PLY. A text as `--fill` takes it makes them finer at a place: "0.008,0.002@X,Y,Z,R"."""
    allow_parts: bool | None
    drop_unused: bool | None
    diagonals: bool | None
    rings: int | None
    """Nodes at most so many edges apart are linked, from 1 on."""
    lean: bool | None
    k_m: float | None
    r_x: float | None
    capacitance: float | None
    energy_max_j: float | None


class TissueOptions(TypedDict, total=False):
    """Those of `Tissue` and `run`: the options of `chaincell run`."""

    contact: str | npt.ArrayLike | None
    """"probe:RADIUS", "cells:SELECTOR", "auto", or ids of the nodes that the tool holds."""
    tools: Sequence[str] | None
    """Tools by their parts, as "sphere:0.01+capsule:0.02,0.004", one at least; instead of a contact."""
    friction: float | None
    scheme: Literal["track", "predict", "euler", "rkl2"] | None
    precision: Literal["f32", "fixed"] | None
    force_error: float | None
    """Sweep until the estimated error of each force is this share of it, 0.001 to 1, at most `sweeps` times a tick.
    `Output.sweeps` and `Run.sweeps` are those that were made. By default a tick makes all sweeps."""
    sweeps: int | None
    """Sweeps per tick, 1 to 65,535. Default: 4."""
    step: float | None
    """Time that `euler` advances per sweep, at most the model's bound `step_max`; on the command
    line and in Python also the time that `rkl2` advances per tick [dimensionless]. Default: 0.9
    of the bound; for rkl2 what the sweeps cover."""
    max_tool_step_m: float | None
    """Largest motion of the contact cells per tick, or largest change of the current per tick
    [m]. Default: one mean link length."""
    max_force_n: float | None
    """Largest magnitude of the force; a larger one is shortened and flagged. A limit below 1e-15
    N admits no force, an infinite one is none [N]. Default: no limit."""
    unloading: Literal["off", "release", "retreat"] | None
    """When the links' bands close to their rest lengths. Those of links that relax stay open:
    unloading lies below loading by itself. Default: release, of links that relax off."""
    drive: Literal["position", "current"] | None
    """How the tool's displacement acts on chosen cells, from the next time that the tool
    engages. Default: position."""
    cut: Literal["on", "off"] | None
    """Cutting by blades and tearing; off, a blade feels nothing and no body tears. Default: on."""
    time_constant_s: float | None
    threads: int | Literal["auto"] | None
    """From 1 to 8."""
    max_torque_n_m: float | None
    device: Literal["touch", "premium", "falcon", "omega", "sigma"] | None
    coupling: float | str | None
    passivity: float | str | None
    delay_ticks: int | None
    """From 0 to 16."""
    device_hz: int | None
    """From 10 to 100000."""
    max_slew_n_per_s: float | None
    max_device_force_n: float | None
    max_speed_m_per_s: float | Literal["off"] | None
    engage_ramp_ms: int | None
    """From 0 to 60000."""
