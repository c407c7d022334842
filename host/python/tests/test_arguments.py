"""Numbers and arrays: each door takes what is meant, and refuses by name what only looks like it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import chaincell
from chaincell import ArgumentError, Model, Rate, Session, Tissue

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 0.01
TETS = np.array([[0, 1, 2, 3]])
HUGE = 10**5000


def bake(**options: object) -> Callable[[], object]:
    return lambda: Model.bake(POINTS, TETS, **options)


@pytest.fixture(scope="module")
def tissue(plane: Model) -> Tissue:
    return Tissue(plane, contact=[40])


WHOLE: list[tuple[str, int, int, Callable[[Tissue, object], object]]] = [
    ("cells", 2, 65535, lambda _, n: Model.bake(POINTS, TETS, cells=n)),
    ("rings", 1, 2**32 - 1, lambda _, n: Model.bake(POINTS, TETS, rings=n)),
    ("sweeps", 0, 65535, lambda of, n: of.tick([0, 0, 0], sweeps=n)),
    ("sweeps", 1, 65535, lambda of, n: Tissue(of.model, sweeps=n)),
    ("threads", 1, 8, lambda of, n: Tissue(of.model, threads=n)),
    ("delay_ticks", 0, 16, lambda of, n: Tissue(of.model, device="touch", delay_ticks=n)),
    ("device_hz", 10, 100_000, lambda of, n: Tissue(of.model, device="touch", device_hz=n)),
    ("engage_ramp_ms", 0, 60_000, lambda of, n: Tissue(of.model, engage_ramp_ms=n)),
    ("tool", 0, 7, lambda of, n: of.grip(n)),
    ("tool", 0, 7, lambda of, n: of.let_go(n)),
    ("ticks", 1, 65535, lambda of, n: of.let_go(0, n)),
    ("ticks", 0, 2**63 - 1, lambda _, n: Rate(ticks=n)),
    ("watchdog_ms", 0, 60_000, lambda _, n: Session("nobody", server_wait_s=0, watchdog_ms=n)),
    ("ramp_ms", 0, 60_000, lambda _, n: Session("nobody", server_wait_s=0, ramp_ms=n)),
]


@pytest.mark.parametrize(("name", "least", "most", "act"), WHOLE)
def test_whole_numbers_have_a_range(
    tissue: Tissue, name: str, least: int, most: int, act: Callable[[Tissue, object], object]
) -> None:
    for number in (least - 1, most + 1, -1, 2**70, -(2**70), np.int64(most + 1 if most < 2**62 else -1)):
        with pytest.raises(ArgumentError, match=f"`{name}` {number}: must be from {least} to {most}"):
            act(tissue, number)
    with pytest.raises(ArgumentError, match=f"`{name}` .*: must be from {least} to {most}"):
        act(tissue, HUGE)
    for wrong in (True, np.True_, 1.0, np.float64(1), 1j, [1], np.array([1, 2])):
        with pytest.raises(TypeError, match=f"`{name}`: give a whole number, not {type(wrong).__name__}"):
            act(tissue, wrong)


@pytest.mark.parametrize(("name", "least", "most", "act"), WHOLE[3:8])
def test_the_ranges_are_those_of_the_command(
    tissue: Tissue, name: str, least: int, most: int, act: Callable[[Tissue, object], object]
) -> None:
    # A text goes to the command's own check.
    for text in (str(least), str(most)):
        try:
            act(tissue, text)
        except ArgumentError as why:
            assert "invalid value" not in str(why)
    for text in (str(least - 1), str(most + 1)):
        with pytest.raises(ArgumentError, match=f"`{name}`"):
            act(tissue, text)


REAL: list[tuple[str, Callable[[object], object]]] = [
    ("alpha", lambda x: Model.bake(POINTS, TETS, alpha=x)),
    ("young_pa", lambda x: Model.bake(POINTS, TETS, young_pa=x)),
    ("poisson", lambda x: Model.bake(POINTS, TETS, young_pa=5000, poisson=x)),
    ("k_m", lambda x: Model.bake(POINTS, TETS, k_m=x)),
    ("coarse", lambda x: Model.bake(POINTS, TETS, coarse=x)),
    ("unit_m", lambda x: Model.bake(POINTS, TETS, unit_m=x)),
    ("stiffening", lambda x: Model.bake(POINTS, TETS, young_pa=5000, stiffening={0.15: x})),
    ("hz", Rate),
    ("seconds", lambda x: Rate(seconds=x)),
    ("server_wait_s", lambda x: Session("nobody", server_wait_s=x)),
    ("lost_s", lambda x: Session("nobody", server_wait_s=0.0, lost_s=x)),
]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("name", "act"), REAL, ids=[name for name, _ in REAL])
def test_numbers_are_real(name: str, act: Callable[[object], object]) -> None:
    for wrong in (True, np.True_, 1j, np.complex128(1), np.array(True)):
        with pytest.raises(TypeError, match=f"`{name}`: give .*number.*, not {type(wrong).__name__}"):
            act(wrong)
    with pytest.raises(ArgumentError, match=f"`{name}` 1000.*: must be below"):
        act(10**400)


@pytest.mark.parametrize("number", [5000, np.float32(5000), np.int16(5000), np.array(5000.0), np.float16(5000)])
def test_numbers_of_numpy_are_numbers(number: object) -> None:
    assert Model.bake(POINTS, TETS, young_pa=number).checksum == Model.bake(POINTS, TETS, young_pa=5000.0).checksum


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "wrong",
    [
        np.zeros(3, complex),
        [np.complex128(0)] * 3,
        [0j, 0, 0],
        np.zeros(3, bool),
        [True, False, False],
        [True, 0.0, 0.0],
        (0.0, np.True_, 0.0),
        np.zeros(3, object),
        np.array(["0", "0", "0"]),
        np.zeros(3, "datetime64[s]"),
    ],
    ids=repr,
)
def test_places_are_real_numbers(plane: Model, wrong: object) -> None:
    tissue = Tissue(plane, contact=[40])
    before = tissue.state_hash
    calls: list[tuple[str, Callable[[], object]]] = [
        ("pose", lambda: tissue.tick(wrong)),
        ("pose", lambda: tissue.tick([wrong])),
        ("pose", lambda: tissue.tick((wrong, [0, 0, 0, 1]))),
        ("path", lambda: chaincell.run(plane, [wrong], contact=[40])),
        ("points", lambda: Model.bake([wrong] * 4, TETS)),
    ]
    for name, call in calls:
        with pytest.raises(TypeError, match=f"`{name}`: give real numbers, not "):
            call()
    assert (tissue.ticks, tissue.state_hash) == (0, before)


@pytest.mark.parametrize(
    ("name", "act"),
    [
        ("tets", lambda ids: Model.bake(POINTS, [ids])),
        ("fixed", lambda ids: Model.bake(POINTS, TETS, fixed=ids)),
        ("contact", lambda ids: Tissue(Model.bake_mesh("plane:9x9x0.01"), contact=ids)),
        ("sweeps_made", lambda ids: chaincell.run(Model.bake_mesh("plane:9x9x0.01"), np.zeros((4, 3)), sweeps_made=ids)),
    ],
)
def test_ids_are_whole_numbers(name: str, act: Callable[[object], object]) -> None:
    mixed = [0, 1, True, 3]
    for wrong in (np.arange(4.0), np.arange(4) + 0j, mixed, list("0123"), np.array([0, 1, 2, 2.0], object)):
        with pytest.raises(TypeError, match=f"`{name}`: give whole numbers, not"):
            act(wrong)
    for big in (2**70, 2**63, -1, -(2**70)):
        with pytest.raises(ArgumentError, match=f"`{name}`:? {big}"):
            act([0, 1, 2, big])
    with pytest.raises(ArgumentError, match=f"`{name}`:? {2**64 - 1}"):
        act(np.array([0, 1, 2, 2**64 - 1], np.uint64))


def test_masks_and_values_of_nodes_are_what_they_say() -> None:
    for values in (np.ones(4, bool), [True, 1, 1, 1], np.ones(4) + 0j):
        with pytest.raises(TypeError, match="`young_pa`: give real numbers"):
            Model.bake(POINTS, TETS, young_pa=values)
    with pytest.raises(TypeError, match="`fixed`: give whole numbers, not an array of float32"):
        Model.bake(POINTS, TETS, fixed=np.array([1, 0, 0, 0], np.float32))
    tissue = Tissue(Model.bake_mesh("plane:9x9x0.01"), contact=[40])
    for engaged in (1, 1.0, None, "yes", [1], np.array([1])):
        with pytest.raises(TypeError, match="`engaged`: give True and False"):
            tissue.tick([[0, 0, 0]], engaged)


def test_arrays_may_lie_in_memory_as_they_like(plane: Model) -> None:
    path = np.zeros((60, 3))
    path[:, 2] = -0.0001 * np.arange(60)
    path = path.astype(np.float32)
    expected = chaincell.run(plane, path, contact=[40]).state_hash
    wide = np.zeros((60, 6))
    wide[:, ::2] = path
    backwards = path[::-1].copy()[::-1]
    locked = path.copy()
    locked.flags.writeable = False
    forms = [
        wide[:, ::2],
        backwards,
        locked,
        np.asfortranarray(path),
        path.astype(">f8"),
        path.astype(">f4"),
        path.astype(np.longdouble),
        path.view(type("Named", (np.ndarray,), {})),
        np.ma.array(path),
        path.tolist(),
    ]
    for form in forms:
        assert chaincell.run(plane, form, contact=[40]).state_hash == expected
        tissue = Tissue(plane, contact=[40])
        for pose in form:
            tissue.tick(pose)
        assert tissue.state_hash == expected


def test_masked_and_huge_arrays_are_refused(plane: Model) -> None:
    masked = np.ma.array(POINTS, mask=POINTS > 0)
    with pytest.raises(ArgumentError, match="`points`: it has masked values"):
        Model.bake(masked, TETS)
    with pytest.raises(ArgumentError, match="`pose`: it has masked values"):
        Tissue(plane, contact=[40]).tick(masked[1])
    huge = np.broadcast_to(0.0, (10**12, 3))
    for call in (lambda: Model.bake(huge, TETS), lambda: chaincell.run(plane, huge)):
        with pytest.raises(ArgumentError, match="3000000000000 values, the limit is 300000000"):
            call()


def test_arguments_of_a_wrong_type_are_named(plane: Model, tissue: Tissue) -> None:
    calls: list[tuple[Callable[[], object], str]] = [
        (lambda: Tissue(7), "`model`: give a chaincell.Model, not int"),
        (lambda: chaincell.run("liver", np.zeros((1, 3))), "`model`: give a chaincell.Model, not str"),
        (lambda: tissue.restore("text"), "`snapshot`: give bytes or a bytearray, not str"),
        (lambda: Model.from_bytes(np.zeros(4, np.uint8)), "`image`: give bytes or a bytearray, not ndarray"),
        (lambda: Model.load(7), "`path`: give a path.*, not int"),
        (lambda: plane.save(None), "`path`: give a path.*, not NoneType"),
        (lambda: Session(7), "`scene`: give a text, not int"),
        (lambda: Session("nobody", role=7), "`role`: give a text, not int"),
        (lambda: Session("nobody", wait=None), "`wait`: give a text, not NoneType"),
    ]
    for call, text in calls:
        with pytest.raises(TypeError, match=text):
            call()
