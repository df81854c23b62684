"""What is handed out is asked once more: by the doors that everybody uses, with its own scales, free to bow."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import squama
from squama.cli import main
from squama.inverse.beside import Beside, beside
from squama.inverse.goals import Reached
from squama.inverse.target import read_target

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(hold="bend, lateral bend")
BENT = {
    "load": "bending",
    "designs": 1,
    "scale": {
        "length": 0.02, "width": 0.016, "thickness": 8e-4, "embedded": 3e-3, "alpha": 0.0, "theta0": 0.2618,
        "youngs_modulus": 3e9, "poisson_ratio": 0.35, "strength": 50e6,
    },
    "substrate": {"width": 0.02, "thickness": 0.008, "youngs_modulus": 5e5, "poisson_ratio": 0.49},
    "beam": {"pitch": 0.008, "scales": 15},
    "friction": {"mu": 0.25},
    "vary": {"scale.length": (0.01, 0.04), "scale.theta0": ("8 deg", "30 deg")},
}  # fmt: skip
LIMB = {
    "target": {
        "engagement": "at least 40 deg total",
        "points": [{"twist": "90 deg total", "stiffness_ratio": "at least 4", "stress": "at most 50 %"}],
    },
    "vary": {"scale.length": ("50 mm", "90 mm"), "scale.alpha": ("30 deg", "60 deg")},
    "designs": 1,
}


def test_bending_on_hinges_is_not_reached_where_squama_bend_says_otherwise():
    found = squama.inverse_design({**BENT, "joint": "hinge", "target": {"engagement": "45 deg total"}}, starts=128)
    (best,) = found.designs
    said = math.degrees(float(squama.bend(best.beam, at=[1.0]).psi_e)) * 15
    assert said < 35
    assert best.met
    assert not best.confirmed
    assert not found.confirmed
    words = f"; squama bend of this file says {said:.3g} deg total (engagement, asked 45 deg total)"
    assert found.verdict == f"target reached on hinges (endless){words}"
    assert f"target reached on hinges (endless){words}" in found._repr_html_()
    (goal,) = best.beside[0].goals
    assert goal.reached == pytest.approx(said)
    assert not goal.met
    # the file says so, too
    assert f"reached 45 deg total on hinges (endless); squama bend of this file says {said:.3g}" in best.to_toml()


@pytest.mark.slow
def test_a_design_is_judged_with_its_own_scales():
    """What is reached is what ``squama.twist`` of the design says; the endless beam is stiffer, and no objection."""
    found = squama.inverse_design(LIMB, beam=SKIN.replace(scales=15), starts=128)
    (best,) = found.designs
    assert best.met
    far = np.pi / 2 / best.beam.length
    r = squama.twist(best.beam, at=[far])
    assert best.goals[1].reached == pytest.approx(float(r.stiffness_ratio[0]))
    assert best.goals[2].reached == pytest.approx(100 * float(r.stress.max()) / best.beam.scale.strength)
    endless, bow = best.beside
    assert (endless.key, bow.key) == ("endless", "free_to_bow")
    whole = squama.twist(best.beam, at=[far], ends="endless")
    assert endless.goals[0].reached == pytest.approx(float(whole.stiffness_ratio[0]))
    ratio, twice = best.goals[1].reached, bow.goals[0].reached
    assert 1 < twice < 4 * 0.99 <= ratio < endless.goals[0].reached
    # without the search's shares the endless beam alone would reach it
    assert endless.agrees
    assert not bow.agrees
    assert found.verdict.startswith("target reached (15 scales, held straight); ")
    assert f"{twice:.3g} free to bow (stiffness ratio at 90 deg total, asked at least 4)" in found.verdict
    text = best.to_toml()
    for words in ("(15 scales, held straight)", "as an endless beam", f"{twice:.3g} free to bow"):
        assert words in text


@pytest.mark.slow
def test_a_torque_is_met_with_its_own_scales():
    """The endless beam of the design is far above what is asked: a search that asked that alone would not meet it."""
    asked = {"points": [{"twist": "90 deg total", "torque": 0.02}]}
    given = {"target": asked, "vary": {"scale.length": ("60 mm", "90 mm"), "scale.alpha": ("30 deg", "60 deg")}}
    (best,) = squama.inverse_design({**given, "designs": 1}, beam=SKIN.replace(scales=15), starts=64).designs
    own = squama.twist(best.beam, at=[np.pi / 2 / best.beam.length])
    assert best.met
    # tolerance: a target counts as met within 1 %
    assert float(own["T"][0]) == pytest.approx(0.02, rel=0.01)
    assert float(own.T_periodic[0]) > 1.3 * 0.02


@pytest.mark.slow
def test_an_endless_beam_is_judged_so():
    found = squama.inverse_design(LIMB, beam=SKIN.replace(scales=None, hold="nothing"), starts=64)
    assert found[0].found_by == "(endless, free to bow)"
    assert not found[0].beside


@pytest.mark.slow
def test_the_command_says_it_and_the_record_holds_it(tmp_path, capsys):
    path = tmp_path / "t.toml"
    (tmp_path / "beam.toml").write_text(SKIN.replace(scales=15).to_toml())
    path.write_text(
        'start = "beam.toml"\ndesigns = 1\n[[target.points]]\ntwist = "90 deg total"\ntorque = "at least 0.02 N m"\n'
        '[vary]\nscale.length = ["60 mm", "90 mm"]\n'
    )
    assert main(["design", str(path), "--starts", "32", "--full"]) == 0
    said = capsys.readouterr().out
    assert "target reached (15 scales, held straight)" in said
    for words in ("  as an endless beam", "  free to bow"):
        assert words in said
    assert main(["design", str(path), "--starts", "32", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    one = record["designs"][0]
    assert record["verdict"] == one["verdict"]
    assert one["found_by"] == "(15 scales, held straight)"
    assert set(one["beside"]) == {"endless", "free_to_bow"}
    (endless,), (bow,) = (one["beside"][key]["goals"] for key in ("endless", "free_to_bow"))
    assert {endless["unit"], bow["unit"]} == {"N m"}
    assert 0 < bow["reached"] < one["goals"][0]["reached"] < endless["reached"]
    assert one["beside"]["free_to_bow"]["agrees"] == bow["met"]
    assert record["confirmed"] is all(other["agrees"] for other in one["beside"].values())


def test_nothing_contradicts_an_engagement():
    """All scales touch at once, and nothing holds the beam before."""
    vary = {"scale.length": ("50 mm", "90 mm")}
    asked = {"target": {"engagement": "at least 40 deg total"}, "vary": vary, "designs": 1}
    found = squama.inverse_design(asked, beam=SKIN, starts=32)
    assert found.verdict == "target reached (25 scales, held straight)"
    assert found.confirmed


def test_a_lock_is_none_of_the_door():
    """The door's beam has no lock; one whose joint the law does not know is not asked, and says so."""
    target = read_target({"target": {"lock": "120 deg total"}, "vary": {"scale.length": ("50 mm", "90 mm")}}, beam=SKIN)
    (door,) = beside(target, SKIN, elements=True)
    (goal,) = door.goals
    assert door.says(goal) == "squama twist of this file has none"
    assert not door.agrees
    (door,) = beside(target, SKIN.replace(scale={"thickness": "3 mm"}), elements=True)
    assert not door.goals
    assert "not computed: the joint needs elements, scale.thickness = " in door.note
    assert not door.agrees
    # elements refuse this one: the door answers by hinges
    target = target._replace(goals=target.goals[:0])
    (door,) = beside(target, SKIN.replace(scale={"thickness": "6 mm"}), elements=True)
    assert door.note == "by hinges, too"


def test_other_models_in_words():
    one = Reached("torque", "N m", ">=", 2.0, 1.5, -0.5, met=False)
    none = Reached("torque", "N m", "=", 2.0, math.nan, math.nan, met=False)
    assert one.wanted == "at least 2 N m"
    assert Beside("endless", "as an endless beam", (one,)).says(one) == "1.5 N m as an endless beam"
    assert Beside("endless", "as an endless beam", (one,)).agrees
    assert Beside("free_to_bow", "free to bow", (none,), "ends").says(none) == "not known free to bow"
    assert not Beside("free_to_bow", "free to bow", (none,), "ends").agrees
    assert not Beside("door", "squama bend of this file", (), "not asked").agrees
    assert Beside("door", "squama bend of this file", ()).agrees


@pytest.mark.parametrize(
    ("more", "remedy"),
    [
        ({"joint": "hinge"}, 'leave out joint = "hinge"'),
        ({"law": "plate"}, 'leave out law = "plate"'),
        ({"target": {"lock": 4.0}}, "leave out target.lock"),
        ({"law": "plate", "target": {"RED": 0.3}}, 'leave out law = "plate" and target.RED'),
    ],
)
def test_a_remedy_on_hinges_names_what_the_file_has(more, remedy):
    points = {"points": [{"twist": "60 deg total", "stiffness_ratio": 3.0}]}
    data = {"vary": {"scale.length": (0.05, 0.09)}, **more, "target": {**more.get("target", {}), **points}}
    with pytest.raises(squama.InputError) as error:
        read_target(data, beam=SKIN)
    assert str(error.value) == f"target.points[0].stiffness_ratio: is not a figure of hinges; {remedy}"
    assert read_target({"vary": data["vary"], "target": points}, beam=SKIN).compliant


@pytest.mark.parametrize("command", ["design", "pareto"])
def test_force_needs_a_folder(command, tmp_path, capsys):
    path = tmp_path / "t.toml"
    path.write_text("")
    assert main([command, str(path), "--force"]) == 2
    assert (
        "squama: error: --force: replaces designs in the folder that -o names; give -o too" in capsys.readouterr().err
    )
