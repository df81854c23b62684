"""Every public function refuses what is no beam, no number and no known word by its name; no twists: no points."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import squama
from squama.errors import InputError
from squama.joints import choice

FUNCTIONS: dict[str, Callable[..., Any]] = {
    name: f for name in squama.__all__ if inspect.isfunction(f := getattr(squama, name))
}
BEAM = squama.Beam.from_ratios(mu=0.3)
SHAPE = {"eta": 3.0, "beta": 1.25, "lam": 0.45, "alpha": 0.7, "theta0": 0.2, "mu": 0.3}
REQUIRED: dict[str, dict[str, Any]] = {
    "bend_twist": {"path": [(0.0, 1.0)]},
    "bend_twist_map": {"path": [(0.0, 1.0)]},
    "cell": {"to": "0.1 rad/pitch"},
    "combined": {"psi": 0.1, "phi": 0.1, "toward": (0.0, 1.0)},
    "contact": {"theta": 0.5},
    "cycle": {"twist": 1.0},
    "design": {"target": {}},
    "export": {"folder": "out"},
    "fit": {"data": "a.csv"},
    "fit_decay": {"data": "a.csv"},
    "forces": {"theta": 0.5},
    "free_vibration": {"kappa": 1.0, "amplitude": 0.1},
    "held": {"psi": 0.1, "phi": 0.1},
    "inverse_design": {"target": {}},
    "load": {"load": "0.1 N up at tip"},
    "pareto": {"target": {}},
    "plan": {"noise": "5 N mm"},
    "read_measured": {"path": "a.csv"},
    "response": {"phi": [0.1, 0.2], "zeta": 0.2, "thickness": 0.05, "width": 1.5, "nu": 0.45},
    "shake": {"frequencies": [1.0], "static": "0.05 rad/pitch", "rotor": "1e-4 kg m2"},
    "sweep": {"over": {"mu": (0.0, 1.0, 3)}},
    "uncertainty": {"vary": {"mu": "0.3 +- 0.1"}},
    "verify": {"folder": "out"},
    "vibrate": {"release": "0.1 rad/pitch", "rotor": "1e-4 kg m2"},
}
OF_BEAMS = [name for name, f in FUNCTIONS.items() if "beam" in inspect.signature(f).parameters]
NO_BEAMS = ["beam.toml", Path("beam.toml"), 3.0, {"pitch": 1.0}, BEAM.scale, squama.Beam]
NO_NUMBERS = {
    "truth value": [True, np.True_, [0.3, True], np.array([True])],
    "complex": [0.3 + 0j, np.complex64(0.3), [[0.3, 0.3j]], np.array([0.3j])],
    "text": ["0.3", b"0.3", [0.3, "0.3"], np.array(["0.3"]), np.array(["0.3"], object)],
    "date": [datetime(2020, 1, 1, tzinfo=UTC), np.datetime64("2020-01-01"), np.array(["2020-01-01"], "M8[D]")],
    "span of time": [timedelta(1), np.timedelta64(1, "s"), [np.timedelta64(1, "s")]],
}


def arrays(name: str) -> list[str]:
    """Return the arguments of a function that are arrays of numbers."""
    return [
        p.name
        for p in inspect.signature(FUNCTIONS[name]).parameters.values()
        if str(p.annotation).startswith(("ArrayLike", "Rates"))
    ]


def call(name: str, **given: Any) -> Any:
    """Call a function with what it needs and what is given."""
    known = inspect.signature(FUNCTIONS[name]).parameters
    own = {k: v for k, v in ({"beam": BEAM} | SHAPE | REQUIRED.get(name, {})).items() if k in known}
    if "impulse" in given:
        own.pop("amplitude", None)
    return FUNCTIONS[name](**own | given)


def test_there_are_functions_of_beams_and_of_arrays() -> None:
    assert len(OF_BEAMS) >= 20
    assert len([name for name in FUNCTIONS if len(arrays(name)) > 3]) >= 9


@pytest.mark.parametrize("name", OF_BEAMS)
@pytest.mark.parametrize("value", NO_BEAMS, ids=lambda v: type(v).__name__)
def test_what_is_no_beam_is_refused(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=r"^beam.*, not a beam; .*squama\.Beam") as caught:
        call(name, beam=value)
    assert "\n" not in str(caught.value)
    if isinstance(value, str | Path):
        assert 'squama.Beam.from_toml("beam.toml")' in str(caught.value)


FIGURES = [name for name in squama.plot.__all__ if name not in ("save_figure", "part_animation")]


@pytest.mark.parametrize("name", FIGURES)
@pytest.mark.parametrize("value", ["twist.nc", Path("twist.nc"), BEAM], ids=lambda v: type(v).__name__)
def test_what_is_no_result_is_not_drawn(name: str, value: Any) -> None:
    draw = getattr(squama.plot, name)
    needed = [p.name for p in list(inspect.signature(draw).parameters.values())[1:] if p.default is p.empty]
    with pytest.raises(InputError, match="not a result; give what") as caught:
        draw(value, **dict.fromkeys(needed, "theta"))
    assert "\n" not in str(caught.value)


def test_what_is_no_result_is_not_saved() -> None:
    for value in ("twist.nc", BEAM):
        with pytest.raises(InputError, match="not a result"):
            squama.save(value, "never.nc")


@pytest.mark.parametrize(("name", "argument"), [(name, argument) for name in FUNCTIONS for argument in arrays(name)])
def test_what_is_no_number_is_refused_in_every_array(name: str, argument: str) -> None:
    for kind, values in NO_NUMBERS.items():
        for value in values:
            if argument == "at" and kind == "text":
                # texts with units belong there
                continue
            with pytest.raises(InputError, match=f"{argument}.*is a {kind}.*; give a number") as caught:
                call(name, **{argument: value})
            assert "\n" not in str(caught.value)


@pytest.mark.parametrize("word", ["joint", "law", "load", "sense", "mode", "neutral", "faces"])
def test_words_that_are_not_known_are_refused(word: str) -> None:
    known = [name for name, f in FUNCTIONS.items() if word in inspect.signature(f).parameters]
    assert known
    for name in known:
        if name in ("fit", "fit_decay", "read_measured"):
            # a table comes first
            continue
        with pytest.raises(InputError, match=f"^{word}.*x"):
            call(name, **{word: "x"})


@pytest.mark.parametrize("shape", [(0,), (0, 3)])
def test_no_designs_give_empty_answers(shape: tuple[int, ...]) -> None:
    none = np.empty(shape)
    for name, fields in (("solve", 12), ("ends", 5), ("contact", 3), ("forces", 3), ("combined", 2)):
        found = call(name, eta=none)
        assert {np.shape(v) for v in found[:fields]} == {shape}
    for start in ("amplitude", "impulse"):
        v = call("free_vibration", eta=none, **{start: 0.1}, swings=4)
        assert v.peaks.shape == (*shape, 5)
        assert v.zeta.shape == (*shape, 4)


@pytest.mark.parametrize("how", [{"joint": "hinge", "ideal": True}, {"ideal": True}])
@pytest.mark.parametrize("door", [squama.twist, squama.bend])
def test_no_twists_give_an_empty_curve(door: Callable[..., Any], how: dict[str, Any]) -> None:
    found, whole = door(BEAM, at=[], **how), door(BEAM, at=[1.0], **how)
    assert found.sizes["point"] == 0
    assert set(found.variables) == set(whole.variables)
    e = "phi_e" if door is squama.twist else "psi_e"
    assert float(found[e]) == pytest.approx(float(whole[e]), rel=1e-9)
    assert math.isfinite(float(found[e]))


LENGTH = "3 mm"
UNREADABLE: list[tuple[str, str, Any]] = [
    *((name, "to", LENGTH) for name in ("twist", "bend", "row", "view", "cell", "verify", "fit")),
    *((name, "at", [LENGTH]) for name in ("twist", "bend")),
    *((name, "points", 2) for name in ("twist", "bend", "row", "bend_twist", "cycle")),
    *(("vibrate", name, LENGTH) for name in ("release", "rotor", "density")),
    *(("shake", name, LENGTH) for name in ("static", "rotor", "density")),
    *(("fit", name, LENGTH) for name in ("reversal", "stick", "noise")),
    *((name, "path", f"twist {LENGTH}") for name in ("bend_twist", "bend_twist_map")),
    ("cycle", "twist", [LENGTH]),
    ("view", "bend", LENGTH),
    ("uncertainty", "before", LENGTH),
]


@pytest.mark.parametrize(("name", "argument", "value"), UNREADABLE)
def test_what_cannot_be_read_is_refused_before_the_joint_is_looked_for(
    name: str, argument: str, value: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The joint of a beam beyond its law takes elements, many seconds."""

    def slow(*_: object, **__: object) -> None:
        pytest.fail("elements")

    monkeypatch.setattr(import_module("squama.fe.stiffness"), "joint", slow)
    beam = BEAM.replace(scale={"embedded": 0.07 * BEAM.pitch})
    assert choice.unknown(beam)
    with pytest.raises(InputError, match=f"^{argument}"):
        call(name, beam=beam, **{argument: value})


@pytest.mark.parametrize("points", [3, 4, 5])
@pytest.mark.parametrize(("door", "angle"), [(squama.twist, "phi"), (squama.bend, "psi")])
def test_a_curve_of_three_points_has_the_state_without_load_engagement_and_the_end(
    door: Callable[..., Any], angle: str, points: int
) -> None:
    """Wherever engagement is: nearest to the first point, between two, nearest to the last one."""
    engaged = float(door(BEAM, points=9)[f"{angle}_e"])
    for stop in (1.01 * engaged, 2.0 * engaged, 0.3):
        found = door(BEAM, points=points, to=stop / BEAM.pitch)[angle].values
        assert found.size == points
        assert found[[0, -1]] == pytest.approx([0.0, stop], rel=1e-9, abs=1e-15)
        assert np.abs(found - engaged).min() < 1e-9
        assert (np.diff(found) > 0).all()


@pytest.mark.parametrize("name", ["solve", "ends", "free_vibration"])
def test_scales_that_would_reach_neighbours_without_end_are_refused(name: str) -> None:
    for argument in ("eta", "beta", "thickness"):
        with pytest.raises(InputError, match=f"^{argument} = 1e\\+172: must be .* to 100"):
            call(name, **{argument: 1e172})


def test_what_vanishes_beside_another_number_is_no_error() -> None:
    """Python's floats do not divide by zero; compiled code, and arrays, do."""
    found = squama.ends(**SHAPE | {"theta0": 1e-20}, sense="-")
    assert str(found.end) == str(squama.ends(**SHAPE | {"theta0": 1e-10}, sense="-").end) == "no engagement"
