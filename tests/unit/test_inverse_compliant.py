"""Targets on compliant joints: figures and derivatives, what is handed out, materials, fronts, mistakes."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.fabrication import refuse
from squama.fabrication.kinds import PARTS
from squama.fabrication.plan import plan
from squama.inverse.limits import WITHIN, known_rooms, printed_rooms, refused
from squama.inverse.named_figures import flat
from squama.inverse.residuals import Residuals
from squama.inverse.search import rounded
from squama.inverse.space import Grid, Variable
from squama.inverse.target import read_target
from squama.joints import law
from squama.joints.choice import shape
from squama.study.columns import beam_at, columns, valid

BEAM = squama.Beam.from_toml("examples/stiff_skin.toml").replace(hold="bend, lateral bend", scales=None)
POINT = {"twist": "90 deg total", "torque": 0.06}
PIECE = {"twist": "90 deg total", "stiffness_ratio": "at least 5"}
VARY = {
    "scale.length": ("50 mm", "90 mm"),
    "scale.alpha": ("30 deg", "60 deg"),
    "scale.theta0": ("15 deg", "25 deg"),
    "substrate.width": ("16 mm", "30 mm"),
}


@pytest.mark.slow
@pytest.mark.usefixtures("unasked")
def test_the_number_of_scales_comes_out_whole_and_on_target():
    data = {
        "target": {
            "length": "0.5 m",
            "engagement": "45 deg total",
            "points": [{"twist": "90 deg total", "torque": 0.02}],
        },
        "vary": VARY | {"beam.scales": (15, 40), "beam.pitch": ("15 mm", "25 mm")},
    }
    found = squama.inverse_design(data, beam=BEAM, starts=64)
    assert found.met
    for d in found.designs:
        assert isinstance(d.beam.scales, int)
        assert d.values["beam.scales"] == d.beam.scales
        # tolerance: the beam is met to the target's "accept", 0.01 where it names none
        assert d.beam.length == pytest.approx(0.5, rel=0.01) or not d.met
        r = squama.twist(d.beam, at="90 deg total")
        torque = next(goal for goal in d.goals if "torque" in goal.name)
        assert float(r["T"][0]) == pytest.approx(torque.reached, rel=1e-9)
        engaged = next(goal for goal in d.goals if goal.name == "engagement")
        assert math.degrees(float(r.phi_e)) * d.beam.scales == pytest.approx(engaged.reached)
    assert "beam.scales" not in found.tolerance


@pytest.mark.slow
@pytest.mark.usefixtures("unasked")
def test_the_number_of_scales_is_one_of_a_list():
    listed = {
        "target": {"points": [{"twist": "90 deg total", "torque": 0.02}]},
        "vary": VARY,
        "choose": {"beam.scales": [24, 25, 26]},
    }
    best = squama.inverse_design(listed, beam=BEAM, starts=16, designs=1)[0]
    assert best.met
    assert best.chosen["beam.scales"] == str(best.beam.scales)


@pytest.mark.slow
@pytest.mark.usefixtures("unasked")
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
        # with its own 15 scales
        assert float(r.stiffness_ratio[0]) >= 5 * 0.99
        assert float(r["T"][0]) <= 2
        assert float(r.stress.max()) <= 0.5 * beam.scale.strength
        assert math.degrees(float(r.phi_e)) * 15 >= 60
        engagement, torque, ratio, share = d.goals
        assert engagement.reached == pytest.approx(math.degrees(float(r.phi_e)) * 15)
        assert torque.reached == pytest.approx(float(r["T"][0]), rel=1e-9)
        assert ratio.reached == pytest.approx(float(r.stiffness_ratio[0]), rel=5e-8)
        assert share.reached == pytest.approx(100 * float(r.stress.max()) / beam.scale.strength, rel=1e-8)
        refuse.check(plan(beam, None, {}), PARTS)
        assert not law.outside(shape(beam))
        for name, value in d.values.items():
            low, high = found.bounds[name]
            assert low <= value <= high
            steps = math.degrees(value) / 0.5 if name in ("scale.alpha", "scale.theta0") else value / 5e-4
            assert steps == pytest.approx(round(steps), abs=1e-9), name
        assert d.chosen["scale.thickness"] == f"{beam.scale.thickness * 1e3:g} mm"


@pytest.mark.slow
@pytest.mark.usefixtures("unasked")
def test_an_exact_target_is_met_on_the_grid():
    data = {
        "target": {
            "points": [{"twist": "90 deg total", "torque": 0.06}],
            "engagement": "50 deg total",
            # a step of the grid changes the torque by up to 1.4 %
            "accept": 0.02,
        },
        "vary": VARY,
        "rounding": {"scale.length": 1e-3, "angle": "1 deg"},
    }
    found = squama.inverse_design(data, beam=BEAM, starts=128, designs=3)
    assert found.met
    for d in found.designs:
        assert d.values["scale.length"] * 1e3 == pytest.approx(round(d.values["scale.length"] * 1e3), abs=1e-9)
        assert math.degrees(d.beam.scale.alpha) == pytest.approx(round(math.degrees(d.beam.scale.alpha)), abs=1e-9)
        r = squama.twist(d.beam, at="90 deg total")
        # tolerance: the target's "accept"
        assert float(r["T"][0]) == pytest.approx(0.06, rel=0.02)
        assert math.degrees(float(r.phi_e)) * 25 == pytest.approx(50, rel=0.02)


def test_neighbours_on_the_grid_are_no_worse_than_the_nearest():
    data = {
        "target": {"points": [{"twist": "90 deg total", "torque": 0.06}]},
        "vary": VARY,
        "rounding": {"length": 4e-3},
    }
    target = read_target(data, beam=BEAM)
    residuals = Residuals(target)
    y = np.random.default_rng(0).uniform(0.3, 0.7, (6, 4))
    ways = rounded(residuals, y), target.space.nearest(y)
    found, near = (residuals.look(z, slopes=False, plates=True).merit for z in ways)
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


@pytest.mark.usefixtures("unasked")
def test_materials_and_sheets_are_chosen():
    materials = [
        {"name": "soft", "youngs_modulus": "0.2 GPa", "poisson_ratio": 0.4, "strength": "8 MPa"},
        {"name": "PLA", "youngs_modulus": "3 GPa", "poisson_ratio": 0.35, "strength": "50 MPa"},
    ]
    choose = {"scale.material": materials, "scale.thickness": ["0.8 mm", "1.6 mm"]}
    asked = {"points": [{"twist": "90 deg total", "stiffness_ratio": "at least 7", "stress": "at most 90 %"}]}
    found = squama.inverse_design({"target": asked, "vary": VARY, "choose": choose}, beam=BEAM, starts=64)
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
        if not refused(beam, {})
    }
    assert len(ratios) > 1
    asked = {"points": [PIECE | {"stiffness_ratio": "at least 100"}]}
    choose = {"scale.thickness": list(sheets.values())}
    alone = squama.inverse_design({"target": asked, "choose": choose}, beam=wide, starts=16)
    assert alone[0].chosen == {"scale.thickness": max(ratios, key=ratios.get)}


@pytest.mark.slow
@pytest.mark.usefixtures("unasked")
def test_what_is_in_the_way_is_named():
    asked = {"points": [PIECE | {"stiffness_ratio": "at least 60"}]}
    found = squama.inverse_design({"target": asked, "vary": VARY}, beam=BEAM, starts=128)
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
        lines = refused(beam, {}, sided=False)
        if not fits[i]:
            assert lines
            seen["no"] += 1
        elif slits[i] >= 0:
            assert not lines
            seen["fits"] += 1
        assert takes[i] == (not law.outside(shape(beam)))
        seen["takes"] += bool(takes[i])
    assert min(seen.values()) > 5


def test_searches_stay_within_the_law_but_never_leave_their_start():
    values = {"alpha": np.radians([40.0, 73.5, 74.9])}
    c = flat(columns(BEAM, values), 3)
    rooms = known_rooms(c)
    (name,) = (name for name in rooms if name.startswith("the law's scale.alpha <="))
    assert (rooms[name] > 0).all()
    inner, edge = (flat(columns(BEAM, {"alpha": np.radians([a])}), 1) for a in (40.0, 74.9))
    # of 75 deg two are kept for tolerances of making
    np.testing.assert_allclose(rooms[name] - known_rooms(c, inner)[name], WITHIN)
    assert list(known_rooms(c, inner)[name] > 0) == [True, False, False]
    # a start that is nearer stays inside
    assert (known_rooms(edge, edge)[name] > 0).all()


@pytest.mark.slow
@pytest.mark.usefixtures("unasked")
def test_what_a_lock_is_of_is_told():
    """Thin, rigid scales on hinges lock where no beam on compliant joints does, and this one could not even be made."""
    vary = {"scale.length": ("30 mm", "80 mm"), "scale.alpha": ("30 deg", "70 deg"), "beam.pitch": ("12 mm", "30 mm")}
    start = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None)
    found = squama.inverse_design({"target": {"lock": "90 deg total"}, "vary": vary}, beam=start, starts=256)
    assert found.settings["joint"] == "hinge"
    assert found.met
    assert any("thick scales bend" in note for note in found.notes)
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
        ({"joint": "compliant", "law": "plate"}, "joint = .*: is for the edge law"),
        ({"target": {"points": [PIECE | {"stress": "5 mm"}]}}, r"points\[0\].stress = .*: is a length"),
        ({"target": {"points": [PIECE | {"RED": 2}]}}, r"points\[0\].RED = 2: a part of the work cannot be"),
        ({"target": {"points": [PIECE | {"W_fr": "5 mm"}]}}, "W_fr = .*: is a length, but a work per length"),
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
            "choose.scale.material: gives different keys for different materials",
        ),
        ({"rounding": {"length": "1 deg"}}, "rounding.length = .*: is an angle"),
        ({"rounding": {"length": 0}}, "rounding.length = 0: must be more than 0"),
        ({"rounding": {"scale.lenght": 1e-3}}, "rounding.scale.lenght: is no dimension of a beam"),
        ({"vary": {"beam.scales": (10, 20.5)}}, "vary.beam.scales = 20.5: is not a whole number"),
        ({"choose": {"beam.scales": [10, 11.5]}}, "choose.beam.scales = 11.5: is not a whole number"),
        ({"vary": {"beam.scales": (1, 20)}}, "vary.beam.scales = 1: .*2 or more"),
        ({"tolerance": {"beam.scales": 1}}, "tolerance.beam.scales: is for a value that the beam does not give"),
        ({"printer": {"nozzle": 1e-3}}, "printer.nozzle: unknown key; .*allowed: clearance"),
        ({"limits": {"joint_law": True}}, "limits.joint_law: is a limit of hinges"),
        ({"limits": {"printable": 2}}, "limits.printable = 2: must be true or false"),
        ({"tolerance": {"joint.stiffness": "5 %"}}, "tolerance.joint.stiffness: is for a value that the beam does not"),
    ],
)  # fmt: skip
def test_mistakes_are_one_line_each(changes, words):
    with pytest.raises(squama.InputError, match=words) as error:
        squama.inverse_design({**GOOD, **changes}, beam=BEAM)
    assert len(error.value.problems) == 1


@pytest.mark.parametrize(
    ("head", "rate", "angle", "total"),
    [("Phi (rad/m)", 3.0, 0.0, 0.0), ("phi (rad)", 0.0, 3.0, 0.0), ("total (rad)", 0.0, 0.0, 3.0)],
)
def test_a_measured_curve_keeps_its_meaning(head, rate, angle, total, tmp_path):
    (tmp_path / "curve.csv").write_text(f"{head},T (N m)\n1,0.01\n3,0.03\n")
    asked = {"target": {"curve": str(tmp_path / "curve.csv")}, "vary": VARY | {"beam.scales": (10, 20)}}
    at = read_target(asked, beam=BEAM).goals[-1].want.at
    assert at == pytest.approx((rate, angle, total))
    assert at.per_pitch(0.02, 12) == pytest.approx(rate * 0.02 + angle + total / 12)


def test_a_stress_needs_a_modulus_and_a_share_a_strength():
    rigid = BEAM.replace(scale={"youngs_modulus": None, "poisson_ratio": None, "strength": None})
    for stress, missing in (("at most 1 MPa", {"youngs_modulus"}), ("at most 50 %", {"youngs_modulus", "strength"})):
        with pytest.raises(squama.InputError) as error:
            squama.inverse_design({**GOOD, "target": {"points": [PIECE | {"stress": stress}]}}, beam=rigid)
        assert {p.where.rpartition(".")[2] for p in error.value.problems} == missing


@pytest.mark.slow
def test_the_command_writes_millimetres_and_degrees(tmp_path, capsys):
    text = Path("examples/limb.toml").read_text(encoding="utf-8")
    own = tmp_path / "t.toml"
    own.write_text(text.replace('"pla_on_vps.toml"', f'"{Path("examples/pla_on_vps.toml").resolve()}"'))
    flags = ["--starts", "32", "--designs", "1"]
    assert main(["design", str(own), "-o", str(tmp_path / "out"), "--plot", str(tmp_path / "d.png"), *flags]) == 0
    said = capsys.readouterr().out
    assert "target reached (15 scales, free to bow)" in said
    assert "; 1 design\n" in said
    assert "thick, elastic scales on compliant joints" in said
    assert "stiffness ratio at 90 deg total" in said
    lines = (tmp_path / "out" / "design_1.toml").read_text().splitlines()
    for key, unit in (("length", "mm"), ("alpha", "deg"), ("theta0", "deg"), ("thickness", "mm")):
        (line, *_) = (line for line in lines if line.startswith(f"{key} ="))
        value = line.split('"')[1]
        assert value.endswith(f" {unit}")
        assert len(value) < 10
    assert main(["design", str(own), "--json", "--starts", "16", "--designs", "1"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert (record["joint"], record["scales"]) == ("compliant", "thick, elastic scales")
    assert record["designs"][0]["refused"] == []


@pytest.mark.slow
@pytest.mark.usefixtures("unasked")
def test_a_search_goes_on_beyond_a_second_contact():
    plain = squama.Beam.from_toml("examples/pla_on_vps.toml")
    wide = plain.replace(scales=None, substrate={"width": 0.035}, pitch=0.0177)
    asked = {
        "vary": {"scale.length": ("83 mm", "85 mm")},
        "limits": {"printable": False, "edge": False},
        "target": {"points": [{"twist": "0.2 rad/pitch", "stiffness_ratio": "at least 1.5"}]},
    }
    best = squama.inverse_design(asked, beam=wide.replace(scale={"length": 0.084, "width": 0.031}), starts=16)[0]
    one = squama.twist(best.beam, at=["0.2 rad/pitch"])
    assert float(one.phi_second) < 0.2
    assert best.end == "range end"
    assert best.met
    # tolerance: both are the same curve, equal to 1e-15
    assert best.goals[0].reached == pytest.approx(one.stiffness_ratio.item(), rel=1e-3)


@pytest.mark.slow
def test_fronts_on_compliant_joints():
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
        assert not refused(beam, {})
    again = squama.pareto(data, beam=BEAM)
    assert again.identical(front)


@pytest.mark.slow
@pytest.mark.parametrize("ends", ["free", "gripped"])
def test_fronts_of_beams_with_a_number_of_scales_are_judged_by_all_of_them(ends):
    pytest.importorskip("pymoo")
    beam = BEAM.replace(scales=6, ends=ends, hold="nothing")
    front = {"maximise": ["stiffness_ratio"], "minimise": ["stress"], "at": "25 deg total"}
    found = squama.pareto({"vary": VARY, "front": front | {"population": 16, "generations": 6}}, beam=beam)
    assert found.attrs["ends"] == ends
    n = found.sizes["design"]
    assert n > 2
    costs = np.stack([-found["stiffness_ratio"].values, found["stress"].values], axis=1)
    for row in costs:
        assert not ((costs <= row).all(axis=1) & (costs < row).any(axis=1)).any()
    from squama.inverse.front import beams

    for i, one in enumerate(beams(found)):
        assert (one.scales, one.ends) == (6, ends)
        for name, word in (("stiffness_ratio", None), ("stiffness_ratio_endless", "endless")):
            r = squama.twist(one, at="25 deg total", ends=word)
            assert float(found[name][i]) == pytest.approx(float(r.stiffness_ratio[0]), rel=0.02)
    assert (np.abs(found["stiffness_ratio"] / found["stiffness_ratio_endless"] - 1) > 0.01).any()


def test_a_front_of_ends_that_the_beam_cannot_have_is_refused_before_the_search():
    pytest.importorskip("pymoo")
    front = {"maximise": ["stiffness_ratio"], "minimise": ["stress"], "at": "25 deg total"}
    with pytest.raises(squama.InputError, match="gripped"):
        squama.pareto({"vary": VARY, "front": front}, beam=BEAM.replace(scales=6, ends="gripped", hold="bend"))
