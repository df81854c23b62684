"""Targets for the real beam: figures and derivatives, what is handed out, materials, fronts, mistakes."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.fabrication import refuse
from squama.fabrication.plan import plan
from squama.fabrication.solids import PARTS
from squama.inverse import making, real
from squama.inverse.figures import At, Options, Want, flat
from squama.inverse.limits import known_rooms, printed_rooms
from squama.inverse.space import Grid, Variable, stepped
from squama.inverse.target import read_target
from squama.joints import law
from squama.joints.choice import shape
from squama.study.columns import beam_at, columns, valid

BEAM = squama.Beam.from_toml("examples/stiff_skin.toml")
RANGES = {
    "scale.length": (0.06, 0.08),
    "scale.width": (0.02, 0.026),
    "scale.thickness": (0.0012, 0.0018),
    "alpha": (0.7, 0.9),
    "theta0": (0.3, 0.4),
    "beam.pitch": (0.0195, 0.0205),
    "mu": (0.1, 0.4),
    "scale.youngs_modulus": (1e9, 5e9),
    "substrate.thickness": (0.013, 0.015),
}
AT = At(0.0, 0.09)
WANTS = [*(Want(name, AT) for name in real.AT_TWIST), *(Want(name) for name in ("stiffness", "engagement", "length"))]
OPTIONS = Options(joint="compliant", pitches=25)
POINT = {"twist": "90 deg total", "torque": 0.06}
PIECE = {"twist": "90 deg total", "stiffness_ratio": "at least 5"}
VARY = {
    "scale.length": ("50 mm", "90 mm"),
    "scale.alpha": ("30 deg", "60 deg"),
    "scale.theta0": ("15 deg", "25 deg"),
    "substrate.width": ("16 mm", "30 mm"),
}


def sample(n):
    rng = np.random.default_rng(3)
    return {key: rng.uniform(*span, n) for key, span in RANGES.items()}


def evaluate(values, moved=()):
    c = flat(columns(BEAM, values), len(values["mu"]))
    return real.evaluate(c, moved, WANTS, OPTIONS, plates=True)


def test_figures_are_those_of_each_beams_curve():
    values = sample(20)
    found = evaluate(values)
    beams = [beam_at(BEAM, "twisting", {key: float(v[i]) for key, v in values.items()}) for i in range(20)]
    known = [i for i, beam in enumerate(beams) if not law.outside(shape(beam))]
    assert len(known) > 4
    for i, beam in enumerate(beams):
        if i not in known:
            assert np.isnan(found.values[: len(real.AT_TWIST), i]).all()
            continue
        own, answer = real.followed(beam, WANTS, OPTIONS)
        np.testing.assert_allclose(found.values[:, i], own, rtol=6e-3)
        assert float(answer["T"][0]) == pytest.approx(float(squama.twist(beam, at="0.09 rad/pitch")["T"][0]), rel=1e-12)
        share = own[4] * beam.scale.strength
        assert own[3] == pytest.approx(share)


def differences(values, key, rate, h):
    up, down = (evaluate({**values, key: values[key] + s * h * rate}).values for s in (1, -1))
    return (up - down) / (2 * h)


@pytest.mark.parametrize("friction", [0.0, 1.0])
def test_derivatives_against_differences(friction):
    """Of 200 beams by 9 dimensions.

    Differences see Newton's tolerance where they are small, and where they are large now and then a step more or less
    along the curve: the nearer of two counts.
    """
    values = sample(200)
    values["mu"] *= friction
    rates = {key: np.mean(span) for key, span in RANGES.items() if friction or key != "mu"}
    found = evaluate(values, [stepped(BEAM, "twisting", values, key, rate, 200) for key, rate in rates.items()])
    np.testing.assert_allclose(found.values, evaluate(values).values, rtol=1e-8)
    has = [bool(friction) or want.figure not in ("W_fr", "RED") for want in WANTS]
    whole = np.isfinite(found.values[has]).all(axis=0) & (found.load_e < 0.085)
    assert whole.sum() > 150
    names, smooth = [want.figure for want in WANTS], ["torque", "stress", "engagement", "stiffness"]
    for j, (key, rate) in enumerate(rates.items()):
        slopes = [differences(values, key, rate, h) for h in (3e-4, 3e-5)]
        # over the figure itself, or its steepest slope
        scale = np.maximum(np.abs(found.values), np.abs(found.slopes).max(axis=1))[has][:, whole]
        off = np.min([np.abs(found.slopes[:, j] - slope)[has][:, whole] for slope in slopes], axis=0) / scale
        off = dict(zip(np.array(names)[has], off, strict=True))
        for name in off:
            assert np.median(off[name]) < (1e-6 if name in smooth else 5e-6), (key, name)
        for name in smooth:
            assert (off[name].max() < 2e-6) if not friction else (np.quantile(off[name], 0.9) < 5e-6), (key, name)


def test_derivatives_are_there_at_no_friction_and_where_nothing_touches():
    values = {key: np.full(3, np.mean(span)) for key, span in RANGES.items()}
    # not known to the law; touches; the twist is not enough to touch
    values |= {"mu": np.zeros(3), "scale.thickness": np.array([0.02, 0.0015, 0.0015])}
    values["scale.length"] = np.array([0.07, 0.07, 0.03])
    moved = [stepped(BEAM, "twisting", values, key, 1.0, 3) for key in ("mu", "substrate.youngs_modulus")]
    found = evaluate(values, moved)
    torque = [want.figure for want in WANTS].index("torque")
    assert np.isfinite(found.slopes).all()
    more = evaluate({**values, "mu": np.full(3, 1e-4)}).values
    assert found.slopes[torque, 0, 1] == pytest.approx((more - found.values)[torque, 1] / 1e-4, rel=1e-3)
    assert found.load_e[2] > 0.09
    assert found.slopes[torque, 0, 2] == 0.0
    # a bar alone is as stiff as its modulus
    E = BEAM.substrate.youngs_modulus
    assert found.slopes[torque, 1, 2] * E == pytest.approx(found.values[torque, 2], rel=1e-12)


def test_a_limb_that_stiffens():
    """The example: every design is made of whole steps, can be printed, and does it as its file is followed again."""
    found = squama.inverse_design("examples/limb.toml")
    assert found.met
    assert len(found) == 3
    for d in found.designs:
        assert d.met
        assert not d.refused
        beam = squama.Beam.from_toml_text(d.to_toml())
        assert beam.scales * beam.pitch == pytest.approx(0.3)
        r = squama.twist(beam, at="90 deg total")
        assert float(r.stiffness_ratio[0]) >= 5
        assert float(r["T"][0]) <= 2
        assert float(r.stress[0]) <= 0.5 * beam.scale.strength
        assert math.degrees(float(r.phi_e)) * 15 >= 60
        engagement, torque, ratio, share = d.goals
        assert engagement.reached == pytest.approx(math.degrees(float(r.phi_e)) * 15)
        assert torque.reached == pytest.approx(float(r["T"][0]), rel=1e-9)
        assert ratio.reached == pytest.approx(float(r.stiffness_ratio[0]), rel=1e-9)
        assert share.reached == pytest.approx(100 * float(r.stress[0]) / beam.scale.strength, rel=1e-9)
        refuse.check(plan(beam, None, {}), PARTS)
        assert not law.outside(shape(beam))
        for name, value in d.values.items():
            low, high = found.bounds[name]
            assert low <= value <= high
            steps = math.degrees(value) / 0.5 if name in ("scale.alpha", "scale.theta0") else value / 5e-4
            assert steps == pytest.approx(round(steps), abs=1e-9), name
        assert d.chosen["scale.thickness"] == f"{beam.scale.thickness * 1e3:g} mm"


def test_an_exact_target_is_met_on_the_grid():
    data = {
        "target": {
            "points": [{"twist": "90 deg total", "torque": 0.06}],
            "engagement": "50 deg total",
            "accept": 0.006,
        },
        "vary": VARY,
        "rounding": {"scale.length": 1e-3, "angle": "1 deg"},
    }
    found = squama.inverse_design(data, beam=BEAM, starts=512, designs=3)
    assert found.met
    for d in found.designs:
        assert d.values["scale.length"] * 1e3 == pytest.approx(round(d.values["scale.length"] * 1e3), abs=1e-9)
        assert math.degrees(d.beam.scale.alpha) == pytest.approx(round(math.degrees(d.beam.scale.alpha)), abs=1e-9)
        r = squama.twist(d.beam, at="90 deg total")
        assert float(r["T"][0]) == pytest.approx(0.06, rel=6e-3)
        assert math.degrees(float(r.phi_e)) * 25 == pytest.approx(50, rel=6e-3)


def test_neighbours_on_the_grid_are_no_worse_than_the_nearest():
    data = {
        "target": {"points": [{"twist": "90 deg total", "torque": 0.06}]},
        "vary": VARY,
        "rounding": {"length": 4e-3},
    }
    target = read_target(data, beam=BEAM)
    from squama.inverse.residuals import Residuals

    residuals = Residuals(target)
    y = np.random.default_rng(0).uniform(0.3, 0.7, (6, 4))
    found, near = (residuals.look(z, slopes=False, plates=True).merit for z in (
        making.rounded(residuals, y), making.nearest(target.space, y)
    ))  # fmt: skip
    assert (found <= near * (1 + 1e-9)).all()
    assert (found < 0.5 * near).sum() >= 3


@pytest.mark.parametrize(
    ("v", "value", "expected"),
    [
        (Variable("scale.length", 0.0301, 0.0449, Grid(1, "mm")), 0.03012, 0.031),
        (Variable("scale.length", 0.0301, 0.0449, Grid(1, "mm")), 0.0448, 0.044),
        (Variable("scale.length", 0.0301, 0.0304, Grid(1, "mm")), 0.03022, 0.03022),
        (Variable("scale.alpha", 0.1, 1.0, Grid(0.5, "deg")), 0.7859, math.pi / 4),
        (Variable("scale.alpha", 0.1, 1.0), 0.7859, 0.7859),
    ],
)
def test_rounding_stays_within_the_bounds(v, value, expected):
    assert v.rounded(value) == expected


def test_materials_and_sheets_are_chosen():
    materials = [
        {"name": "soft", "youngs_modulus": "0.2 GPa", "poisson_ratio": 0.4, "strength": "8 MPa"},
        {"name": "PLA", "youngs_modulus": "3 GPa", "poisson_ratio": 0.35, "strength": "50 MPa"},
    ]
    choose = {"scale.material": materials, "scale.thickness": ["0.8 mm", "1.6 mm"]}
    asked = {"points": [{"twist": "90 deg total", "stiffness_ratio": "at least 7", "stress": "at most 90 %"}]}
    found = squama.inverse_design({"target": asked, "vary": VARY, "choose": choose}, beam=BEAM, starts=512)
    assert found.met
    sets = {(d.chosen["scale.material"], d.chosen["scale.thickness"]) for d in found.designs if d.met}
    # both soft plates bend away
    assert sets == {("PLA", "1.6 mm")}
    one = found[0].beam.scale
    assert (one.youngs_modulus, one.poisson_ratio, one.strength, one.thickness) == (3e9, 0.35, 5e7, 1.6e-3)
    wide = BEAM.replace(substrate={"width": "28 mm"})
    sheets = {"0.8 mm": 8e-4, "1.6 mm": 1.6e-3, "2 mm": 2e-3}
    made = {word: wide.replace(scale={"thickness": t}) for word, t in sheets.items()}
    ratios = {
        word: float(squama.twist(beam, at="90 deg total").stiffness_ratio[0])
        for word, beam in made.items()
        if not making.refused(beam, {})
    }
    assert len(ratios) > 1
    asked = {"points": [PIECE | {"stiffness_ratio": "at least 100"}]}
    choose = {"scale.thickness": list(sheets.values())}
    alone = squama.inverse_design({"target": asked, "choose": choose}, beam=wide, starts=16)
    assert alone[0].chosen == {"scale.thickness": max(ratios, key=ratios.get)}


def test_what_is_in_the_way_is_named():
    asked = {"points": [PIECE | {"stiffness_ratio": "at least 60"}]}
    found = squama.inverse_design({"target": asked, "vary": VARY}, beam=BEAM, starts=512)
    best = found[0]
    assert not found.met
    (goal,) = best.goals
    assert 5 < goal.reached < 60
    assert best.active
    assert any("bound" in line or "printable" in line or "the law's" in line for line in best.active)
    r = squama.twist(best.beam, at="90 deg total")
    assert goal.reached == pytest.approx(float(r.stiffness_ratio[0]), rel=1e-9)


def test_rooms_agree_with_what_the_printer_files_and_the_law_refuse():
    rng = np.random.default_rng(5)
    n = 150
    spans = {
        "scale.length": (0.03, 0.09), "scale.width": (0.012, 0.03), "scale.thickness": (3e-4, 3e-3),
        "alpha": (0.3, 1.2),
        "scale.embedded": (2e-3, 0.012), "theta0": (0.1, 0.5), "substrate.thickness": (6e-3, 0.02),
        "substrate.width": (0.012, 0.03),
    }  # fmt: skip
    values = {key: rng.uniform(*span, n) for key, span in spans.items()}
    c = flat(columns(BEAM, values), n)
    printed, known = printed_rooms(c, plan(BEAM, None, {})), known_rooms(c)
    slits = printed.pop("printable: the slits of the mould stay apart")
    fits, takes = np.min([*printed.values()], axis=0) >= 0, np.min([*known.values()], axis=0) >= 0
    seen = {"fits": 0, "no": 0, "takes": 0}
    for i in np.flatnonzero(valid(c)):
        beam = beam_at(BEAM, "twisting", {key: float(v[i]) for key, v in values.items()})
        lines = making.refused(beam, {}, sided=False)
        if not fits[i]:
            assert lines
            seen["no"] += 1
        elif slits[i] >= 0:
            assert not lines
            seen["fits"] += 1
        assert takes[i] == (not law.outside(shape(beam)))
        seen["takes"] += bool(takes[i])
    assert min(seen.values()) > 5


def test_what_a_lock_is_of_is_told():
    """Thin, rigid scales on hinges lock where no real beam does, and this one could not even be made."""
    vary = {"scale.length": ("30 mm", "80 mm"), "scale.alpha": ("30 deg", "70 deg"), "beam.pitch": ("12 mm", "30 mm")}
    start = squama.Beam.from_toml("examples/pla_on_vps.toml")
    found = squama.inverse_design({"target": {"lock": "90 deg total"}, "vary": vary}, beam=start, starts=256)
    assert found.settings["joint"] == "hinge"
    assert found.met
    assert any("real scales bend" in note for note in found.notes)
    assert any(line.startswith("printer files:") for line in found[0].refused)
    assert any(line.startswith("joint:") for line in found[0].refused)


def test_what_answers_follows_from_what_is_asked():
    def joint(**data):
        return read_target({"vary": VARY, **data}, beam=BEAM).options.joint

    point = {"points": [{"twist": 1.0, "torque": 0.1}]}
    assert joint(target=point) == "compliant"
    assert joint(target=point, joint="hinge") == "hinge"
    assert joint(target=point, law="plate") == "hinge"
    assert joint(target={"RED": 0.3}) == "hinge"
    assert joint(target={"engagement": 1.0}) == "compliant"
    assert joint(target={"engagement": 1.0, "lock": 2.0}) == "hinge"

    def front(**table):
        return read_target({"vary": VARY, "front": table}, beam=BEAM, need="front").options.joint

    assert front(maximise=["torque", "RED"], at=1.0) == "compliant"
    assert front(maximise=["stiffness", "RED"]) == "hinge"
    assert front(maximise=["torque", "range"], at=1.0) == "hinge"


GOOD = {"target": {"points": [PIECE]}, "vary": VARY}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"joint": "glue"}, 'joint = "glue": must be "compliant" or "hinge"'),
        ({"joint": "hinge"}, r"target.points\[0\].stiffness_ratio: is not a figure of hinges; leave out joint"),
        ({"joint": "compliant", "target": {"lock": 1.0}}, "target.lock: is of a lock, which only thin, rigid scales"),
        ({"joint": "compliant", "law": "plate"}, "joint = .*: is for twisting with the edge law"),
        ({"target": {"points": [PIECE | {"stress": "5 mm"}]}}, r"points\[0\].stress = .*: is a length"),
        ({"target": {"points": [PIECE | {"RED": 2}]}}, r"points\[0\].RED = 2: a part of the work cannot be"),
        ({"target": {"points": [PIECE | {"W_fr": "5 mm"}]}}, "W_fr = .*: is not a work per length"),
        ({"target": {"points": [PIECE | {"W_fr": "-1 J/m"}]}}, "W_fr = .*: must be more than 0"),
        ({"choose": {"scale.thickness": "1 mm"}}, "choose.scale.thickness = .*: is no list"),
        ({"choose": {"scale.thickness": ["1 deg"]}}, "choose.scale.thickness = .*: is an angle"),
        ({"choose": {"scale.length": [0.05, 0.06]}}, r"\[choose\]: sets what is varied or chosen elsewhere"),
        ({"choose": {"scale.material": ["PLA"]}}, r"choose.scale.material\[0\] = .*: is no material"),
        (
            {"choose": {"scale.material": [{"name": "a", "youngs_modulus": 1e9, "density": 1}]}},
            r"choose.scale.material\[0\].density: unknown key",
        ),
        (
            {"choose": {"scale.material": [{"name": "a", "youngs_modulus": 1e9}, {
                "name": "b", "youngs_modulus": 1e9, "strength": 1e6}]}},
            "choose.scale.material: does not say the same of every material",
        ),
        ({"rounding": {"length": "1 deg"}}, "rounding.length = .*: is an angle"),
        ({"rounding": {"length": 0}}, "rounding.length = 0: must be more than 0"),
        ({"rounding": {"scale.lenght": 1e-3}}, "rounding.scale.lenght: is no dimension of a beam"),
        ({"printer": {"nozzle": 1e-3}}, "printer.nozzle: unknown key; .*allowed: clearance"),
        ({"limits": {"joint_law": True}}, "limits.joint_law: is a limit of hinges"),
        ({"limits": {"printable": 2}}, "limits.printable = 2: must be true or false"),
        ({"tolerance": {"joint.stiffness": "5 %"}}, "tolerance.joint.stiffness: is of what the beam does not give"),
    ],
)  # fmt: skip
def test_mistakes_are_one_line_each(changes, words):
    with pytest.raises(squama.InputError, match=words) as error:
        squama.inverse_design({**GOOD, **changes}, beam=BEAM)
    assert len(error.value.problems) == 1


def test_a_stress_needs_a_modulus_and_a_share_a_strength():
    rigid = BEAM.replace(scale={"youngs_modulus": None, "poisson_ratio": None, "strength": None})
    for stress, missing in (("at most 1 MPa", {"youngs_modulus"}), ("at most 50 %", {"youngs_modulus", "strength"})):
        with pytest.raises(squama.InputError) as error:
            squama.inverse_design({**GOOD, "target": {"points": [PIECE | {"stress": stress}]}}, beam=rigid)
        assert {p.where.rpartition(".")[2] for p in error.value.problems} == missing


def test_the_command_writes_millimetres_and_degrees(tmp_path, capsys):
    text = Path("examples/limb.toml").read_text(encoding="utf-8")
    own = tmp_path / "t.toml"
    own.write_text(text.replace('"pla_on_vps.toml"', f'"{Path("examples/pla_on_vps.toml").resolve()}"'))
    flags = ["--starts", "1024", "--designs", "1"]
    assert main(["design", str(own), "-o", str(tmp_path / "out"), "--plot", str(tmp_path / "d.png"), *flags]) == 0
    said = capsys.readouterr().out
    assert "target reached, 1 design; thick, elastic scales on compliant joints" in said
    assert "stiffness ratio at 90 deg total" in said
    lines = (tmp_path / "out" / "design_1.toml").read_text().splitlines()
    for key, unit in (("length", "mm"), ("alpha", "deg"), ("theta0", "deg"), ("thickness", "mm")):
        (line, *_) = (line for line in lines if line.startswith(f"{key} ="))
        value = line.split('"')[1]
        assert value.endswith(f" {unit}")
        assert len(value) < 10
    assert main(["design", str(own), "--json", *flags]) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["joint"], record["scales"]) == ("compliant", "thick, elastic scales")
    assert record["designs"][0]["refused"] == []


def test_another_contact_before_the_twist_is_told_with_what_to_change(monkeypatch):
    monkeypatch.setattr("squama.curves.real.general", lambda: False)
    wide = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(substrate={"width": 0.035}, pitch=0.0177)
    asked = {
        "vary": {"scale.length": ("83 mm", "85 mm")},
        "limits": {"printable": False, "edge": False},
        "target": {"points": [{"twist": "0.2 rad/pitch", "stiffness_ratio": "at least 3"}]},
    }
    best = squama.inverse_design(asked, beam=wide.replace(scale={"length": 0.084, "width": 0.031}), starts=16)[0]
    assert np.isnan(best.goals[0].reached)
    (line,) = (line for line in best.warnings if line.startswith("another contact comes in at "))
    far = float(line.split(" at ")[1].split(" deg total")[0])
    assert np.radians(far) == pytest.approx(best.rate_end * best.beam.length, rel=1e-3)
    assert "a larger beam.pitch or scale.theta0" in line
    # what the line names does put it off
    for change in ({"pitch": 0.0185}, {"scale": {"theta0": 1.1 * best.beam.scale.theta0}}, {"scale": {"width": 0.028}}):
        other = best.beam.replace(**change)
        assert float(squama.twist(other, to="0.2 rad/pitch").phi_end) > np.radians(far) / best.beam.scales


def test_fronts_of_real_beams():
    pytest.importorskip("pymoo")
    data = {
        "vary": VARY,
        "choose": {"scale.thickness": ["1.2 mm", "1.6 mm", "2 mm"]},
        "front": {"maximise": ["stiffness_ratio"], "minimise": ["stress"], "at": "90 deg total", "population": 24,
                  "generations": 12},
    }  # fmt: skip
    front = squama.pareto(data, beam=BEAM)
    assert front.attrs["joint"] == "compliant"
    n = front.sizes["design"]
    assert n > 5
    costs = np.stack([-front["stiffness_ratio"].values, front["stress"].values], axis=1)
    for row in costs:
        assert not ((costs <= row).all(axis=1) & (costs < row).any(axis=1)).any()
    from squama.inverse.front import beams

    for i, beam in list(enumerate(beams(front)))[:: max(1, n // 4)]:
        r = squama.twist(beam, at="90 deg total")
        assert float(front["stiffness_ratio"][i]) == pytest.approx(float(r.stiffness_ratio[0]), rel=0.02)
        assert float(front["stress"][i]) == pytest.approx(float(r.stress[0]), rel=0.02)
        assert f'length = "{beam.scale.length * 1e3:.1f}'.removesuffix(".0") + " mm" in beam.to_toml()
        assert str(front["chosen.scale.thickness"][i].values) == f"{beam.scale.thickness * 1e3:g} mm"
        assert not making.refused(beam, {})
    again = squama.pareto(data, beam=BEAM)
    assert again.identical(front)
