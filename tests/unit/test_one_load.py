"""One load and what it is held by: the same numbers through every door, free to bow, free to twist, the row beside."""

from __future__ import annotations

import json

import numpy as np
import pint
import pytest

import squama
from squama.cli import main
from squama.curves.bench import bench
from squama.curves.doors import respond
from squama.paper import parameters as par

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
PLA = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None)


@pytest.mark.parametrize(("beam", "neutral"), [(SKIN, "free"), (SKIN, "middle"), (PLA, "free")])
def test_twist_is_the_path_that_twists_alone(beam, neutral):
    """Length and moment held or free alike; linear between points, 250 of them."""
    q = squama.bend_twist(beam, "twist 0.1 rad/pitch", points=251, neutral=neutral)
    phi = q.phi.values[1:]
    r = squama.twist(beam, at=phi / beam.pitch, neutral=neutral)
    assert r.attrs["neutral"] == q.attrs["neutral"] == neutral
    assert r.attrs["rigidity"] == pytest.approx(q.attrs["rigidity"], rel=1e-12)
    for name in ("T", "M", "stretch", "theta", "N", "U_el", "W_fr", "RED"):
        most = float(np.abs(r[name]).max())
        np.testing.assert_allclose(q[name][1:], r[name], rtol=0, atol=2e-4 * most, err_msg=name)


def test_doors_obey_the_line_that_keeps_its_length(tmp_path):
    for neutral in (None, "middle"):
        beam = SKIN.replace(substrate={"neutral": neutral})
        for load, run, name in (("twisting", squama.twist, "T"), ("bending", squama.bend, "M")):
            one = run(beam, at=["0.1 rad/pitch"])
            swept = squama.sweep(
                beam, {"mu": [0.25, 0.3]}, load=load, at="0.1 rad/pitch", out=tmp_path / f"{neutral}{load}.zarr"
            )
            assert float(swept["torque"][0]) == pytest.approx(float(one[name][0]), rel=3e-4)
            assert swept.attrs["neutral"] == one.attrs["neutral"] == ("free" if neutral is None else "middle")
        history = squama.cycle(beam, "0.1 rad/pitch")
        top = int(history.phi.argmax("point"))
        for name in ("T", "M"):
            there = float(squama.twist(beam, at=["0.1 rad/pitch"])[name][0])
            assert float(history[name][top]) == pytest.approx(there, rel=3e-4)


@pytest.mark.parametrize("sense", ["+", "-"])
def test_hinges_tell_the_moment_that_holds_them_straight(sense):
    beam = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="5 deg", theta0="10 deg")
    r = squama.twist(beam, mu=0.3, joint="hinge", sense=sense, points=200)
    far = 0.9 * float(r.phi_end)
    signed = -far if sense == "-" else far
    q = squama.bend_twist(beam, f"twist {signed} rad/pitch", mu=0.3, joint="hinge", points=400)
    there = np.interp(r.phi, np.abs(q.phi), q.M)[r.phi < far]
    np.testing.assert_allclose(r.M[r.phi < far], there, rtol=0, atol=2e-3 * np.abs(there).max())
    assert "M" not in squama.twist(beam, mu=0.3, law="plate")


def test_free_to_bow():
    """Against general contact on the joint's matrix, 0.05 % off, with friction; figures of the nonlinear elements."""
    # tolerance: another program's figures, of three digits
    found = squama.twist(SKIN, mu=0.25, at=["0.06 rad/pitch", "0.08 rad/pitch", "0.1 rad/pitch"])
    np.testing.assert_allclose(found["T"], [5.61e-3, 9.51e-3, 13.2e-3], rtol=0.015)
    np.testing.assert_allclose(found.psi, [-0.00715, -0.0296, -0.0513], atol=1.5e-3)
    assert float(found.stiffness_ratio[-1]) == pytest.approx(2.74, rel=0.02)


@pytest.mark.parametrize(("beam", "load", "at"), [(SKIN, "twist", 0.1), (SKIN, "bend", 0.1), (PLA, "bend", 0.15)])
def test_free_of_moment_is_so_by_another_path(beam, load, at):
    """Without friction the way does not count: a straight ray to the same strains has no moment (no torque)."""
    found = getattr(squama, load)(beam, mu=0, at=[at / beam.pitch])
    own, other, held = ("T", "psi", "M") if load == "twist" else ("M", "phi", "T")
    strains = (float(found[other][0]), at)[:: 1 if load == "twist" else -1]
    q = squama.bend_twist(beam, [tuple(v / beam.pitch for v in strains)], mu=0)
    whole = float(np.abs(q[own]).max())
    assert abs(float(q[held][-1])) < 2e-4 * whole
    assert float(found[own][0]) == pytest.approx(float(q[own][-1]), rel=2e-4)


def test_what_is_not_known_is_said():
    seven = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
    from squama.beam.matrixfile import stored
    from squama.curves.compliant import Held

    held = Held.of(seven)
    seven = seven.replace(joint={"matrix": stored(seven, held.K[:7, :7])})
    r = squama.twist(seven, points=5)
    assert "held straight: joint.matrix knows no bend" in r.attrs["warnings"]
    assert (r.attrs["neutral"], r.attrs["hold"]) == ("middle", "straight")
    assert "M" not in r
    found = bench(seven, respond(seven, "twisting", points=20), ideal=False)
    assert any("nine motions" in note for note in found.notes)
    with pytest.raises(squama.InputError, match="neutral"):
        squama.twist(seven, neutral="free")
    with pytest.raises(squama.InputError, match="neutral"):
        squama.twist(SKIN, neutral="middle", joint="hinge")


def test_the_papers_figure_6b_takes_a_moment():
    """Thin, rigid scales on the compliant joint, eta 3: by general contact, over E d^3."""
    # tolerance: another program's figures, of three digits
    beam, phi = par.fig6b(3.0), np.array([0.1, 0.15, 0.2])
    how = {"at": phi / beam.pitch, "joint": "compliant", "ideal": True, "mu": 0.2}
    r, free = squama.twist(beam, hold="straight", **how), squama.twist(beam, **how)
    held = {"T": [0.00934, 0.01839, 0.02813], "M": [0.00337, 0.00883, 0.01581]}
    for name, values in held.items():
        np.testing.assert_allclose(r[name] / beam.unit_moment, values, rtol=0.02)
    np.testing.assert_allclose(free["T"] / beam.unit_moment, [0.00635, 0.01051, 0.01443], rtol=0.02)


@pytest.mark.slow
def test_the_bench_is_what_the_summary_says(capsys):
    free, straight = "endless, free to bow", "endless, held straight by a bending moment of"
    for hold, order in (("nothing", (free, straight)), ("bend", (straight, free))):
        own = f"25 scales with free ends{', held straight' * (hold == 'bend')}: "
        assert main(["twist", "examples/stiff_skin.toml", "--hold", hold, "--compare"]) == 0
        lines = capsys.readouterr().out.splitlines()
        start = next(i for i, line in enumerate(lines) if line.startswith("at "))
        said = (own, "of the endless beam's torque", "25 scales under a couple", "25 scales with gripped ends", *order)
        if hold == "bend":
            # grips bend the cells beside them
            said = (*said[:3], *said[4:])
        below = lines[start + 1 : start + 1 + len(said)]
        assert [part in line for part, line in zip(said, below, strict=True)] == [True] * len(said)
    assert main(["twist", "examples/stiff_skin.toml", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)["bench"]
    own = SKIN.replace(scales=25)
    found = bench(own, respond(own, "twisting", points=200), ideal=False)
    assert record["endless"]["torque"] == pytest.approx(found.endless.torque)
    assert record["straight"]["holding"] == pytest.approx(found.other.holding)
    assert found.other.stiffness_ratio > 3 * found.endless.stiffness_ratio
    assert found.row.torque < found.endless.torque
    at = [found.at / SKIN.pitch]
    assert found.other.holding == pytest.approx(float(squama.twist(SKIN, at=at, hold="straight").M[0]), rel=1e-3)
    row = squama.row(SKIN, to=found.at / SKIN.pitch, points=60)
    assert found.row.torque == pytest.approx(float(row["T"][-1]), rel=1e-3)


def test_other_ends_are_in_the_summary(capsys):
    """With the torque that each of them has through the public door, at the twist of the figures."""
    five, at, unit = SKIN.replace(scales=5), "27.4 deg total", 1e3
    flags = ["examples/stiff_skin.toml", "--set", "beam.scales=5", "--to", at, "--points", "9"]
    torque = {e: unit * float(squama.twist(five, at=at, ends=e)["T"][0]) for e in ("free", "couple", "gripped")}
    endless = unit * float(squama.twist(SKIN, at=f"{27.4 / 5} deg/pitch")["T"][0])
    # three digits are printed
    assert torque["gripped"] > 1.02 * torque["free"]
    for ends, T in torque.items():
        assert main(["twist", *flags, "--ends", ends]) == 0
        figures = dict(line.strip().split("  ", 1) for line in capsys.readouterr().out.splitlines() if "  " in line)
        ratio = f"(ratio {T / endless:.3g})"
        assert figures["torque"].strip() == f"{T:.3g} N mm; endless beam {endless:.3g} N mm {ratio}"
        words = {"free": "with free ends", "couple": "under a couple at the ends", "gripped": "with gripped ends"}
        others = ", ".join(f"{torque[e]:.3g} N mm {words[e]}" for e in torque if e != ends)
        assert figures["other ends"].strip() == others
    assert main(["twist", *flags, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)["bench"]
    for ends, state in record["other_ends"].items():
        assert unit * state["torque"] == pytest.approx(torque[ends], rel=1e-5)
    assert list(record["other_ends"]) == ["couple", "gripped"]


def test_what_is_held_is_given_once(capsys):
    assert main(["twist", "examples/stiff_skin.toml", "--hold", "bend", "--set", "beam.hold=bend"]) == 2
    assert "--hold: is given twice" in capsys.readouterr().err
    assert main(["twist", "examples/stiff_skin.toml", "--hold", "bow"]) == 2
    assert '--hold = "bow": must be some of' in capsys.readouterr().err


def test_the_bench_of_a_bent_beam():
    found = bench(SKIN, respond(SKIN, "bending", points=200), ideal=False)
    assert found.endless.torque < 0.3 * found.other.torque
    assert "free to twist" in next(found.lines)


def test_no_contact_no_bench():
    assert bench(SKIN, respond(SKIN, "twisting", to=1.0), ideal=False) is None


@pytest.mark.parametrize("load", ["twist", "bend"])
def test_units_are_read_and_equations_are_the_models(load):
    registry = pint.UnitRegistry()
    r = getattr(squama, load)(SKIN, points=5)
    for name, v in r.variables.items():
        if v.attrs.get("units"):
            registry.parse_units(v.attrs["units"])
        assert not v.attrs.get("equation", "").startswith("paper"), name
    hinge = squama.twist(SKIN, points=5, joint="hinge")
    assert hinge["T"].attrs["equation"] == "paper Eq. 14"


@pytest.mark.parametrize(
    ("load", "first"),
    [("twist", ["Phi", "phi", "T", "T_scales", "K_t"]), ("bend", ["kappa", "psi", "M", "M_scales", "K_b"])],
)
def test_the_load_comes_first(load, first, tmp_path):
    """And then one order, whatever contact followed it."""
    columns = []
    for beam in (SKIN, PLA):
        file = tmp_path / "curve.csv"
        squama.save(getattr(squama, load)(beam, points=5), file)
        columns.append(next(line for line in file.read_text().splitlines() if line[0] != "#").split(","))
    assert columns[0] == columns[1]
    assert [name for name in (c.split(" ")[0] for c in columns[0]) if name != "mu"][:5] == first
