"""Every door bends a beam alike: one contact, oblique or across, about the middle of the bar or its face."""

import functools

import numpy as np
import pytest

import squama
from squama.beam import matrixfile
from squama.inverse.hinge_figures import evaluate
from squama.inverse.named_figures import Options, Want, flat
from squama.loads import LOADS
from squama.study.columns import columns
from squama.web import live
from squama.web.state import State

REL = 1e-10
bend = functools.partial(squama.bend, joint="hinge")
BEAMS = {
    f"{degrees} deg, {line}": squama.Beam.from_ratios(
        eta=3.2, beta=1.1, lam=0.45, alpha=f"{degrees} deg", theta0="9 deg", mu=0.3
    ).replace(substrate={"neutral": line})
    for degrees in (0, 45)
    for line in ("middle", "face")
}


@pytest.fixture(params=BEAMS.values(), ids=list(BEAMS))
def beam(request):
    return request.param


@pytest.fixture
def bent(beam):
    return bend(beam)


def same(found, bent, engagement, end, moment):
    """Compare engagement, end and moment at the cut-off with those of squama.bend."""
    values = [float(found[name]) for name in (engagement, end, moment)]
    assert values == pytest.approx([float(bent[name]) for name in ("psi_e", "psi_end", "M_c")], rel=REL)


@pytest.mark.parametrize("seed", range(6))
def test_bend_and_bend_twist_answer_alike_on_hinges(seed):
    """One hinge has one stiffness, by its law, given, or of the joint's matrix."""
    r = np.random.default_rng(seed)
    beam = squama.Beam.from_ratios(
        eta=r.uniform(1.5, 5), beta=r.uniform(0.5, 2), lam=r.uniform(0.3, 0.6), zeta=r.uniform(0.1, 0.5),
        slenderness=r.uniform(3, 40), alpha=np.radians(r.uniform(5, 60)), theta0=np.radians(r.uniform(5, 15)),
        mu=r.uniform(0, 0.4),
    )  # fmt: skip
    if seed % 3 == 1:
        beam = beam.replace(joint={"stiffness": r.uniform(0.3, 3) * beam.joint_stiffness})
    if seed % 3 == 2:
        K = np.diag([1.0, 1.0, 1.0, 0.2, r.uniform(0.01, 0.1), 0.2, 0.05])
        beam = beam.replace(joint={"matrix": matrixfile.stored(beam, K)})
    whole = bend(beam, points=3)
    psi = float(whole.psi_e + r.uniform(0.2, 0.8) * (whole.psi_end - whole.psi_e))
    one = bend(beam, at=[psi / beam.pitch]).isel(point=0)
    both = squama.bend_twist(beam, f"bend {psi!r} rad/pitch", joint="hinge").isel(point=-1)
    assert float(both.K_theta) == beam.joint_stiffness
    for name in ("M", "M_scales", "N", "f", "U_el", "W_fr", "RED", "theta"):
        assert float(one[name]) == pytest.approx(float(both[name]), rel=1e-9), name
    assert float(one["T"]) == pytest.approx(float(both["T"]), rel=1e-9)
    assert float(one.N) > 0


def test_a_joint_that_only_lifts_is_the_hinge_that_is_bent():
    """The compliant joint's limit: stiff in all else, it bends the beam as the hinge with the matrix's K_theta does."""
    beam = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", theta0="10 deg", mu=0.2)
    K = np.diag([1e4, 1e4, 1e4, 1e4, 0.013, 1e4, 0.05, 0.05, 1e4])
    beam = beam.replace(joint={"matrix": matrixfile.stored(beam, K)})
    at = np.array([0.06, 0.1, 0.15]) / beam.pitch
    hinge, joint = bend(beam, at=at), squama.bend(beam, at=at, joint="compliant", ideal=True, hold="straight")
    # 3.3e-6 are measured: the other motions are 1e4 times as stiff, not rigid
    for name in ("M_scales", "T"):
        np.testing.assert_allclose(joint[name], hinge[name], rtol=1e-4)


def test_the_beam_file_says_which_line_keeps_its_length(beam, bent):
    line = beam.substrate.neutral
    assert bent.attrs["neutral"] == line
    again = squama.Beam.from_toml_text(beam.to_toml())
    assert again == beam
    plain = beam.replace(substrate={"neutral": None})
    assert ("neutral" in plain.to_toml(), plain.neutral) == (False, "middle")
    assert float(bend(plain, neutral=line).M_c) == float(bent.M_c)
    with pytest.raises(squama.InputError, match=r'substrate.neutral = "top": must be "middle" or "face"'):
        beam.replace(substrate={"neutral": "top"})


def test_arrays(beam, bent):
    K = beam.joint_stiffness
    height = beam.lam if beam.neutral == "middle" else 0
    ratios = beam.ratios | {"lam": height, "mu": 0.3, "stiffness_ratio": beam.bending_rigidity / (K * beam.pitch)}
    for n in (1, 200):
        s = squama.solve(**(ratios | {"mu": np.full(n, 0.3)}), load="bending")
        assert s.end[0] == bent.end.item()
        same({"e": s.load_e[-1], "end": s.load_end[-1], "M": K * s.torque[-1]}, bent, "e", "end", "M")


def test_sweep(beam, bent, tmp_path):
    axes = {"mu": [0.1, 0.3], "alpha": [beam.scale.alpha, beam.scale.alpha + 0.2]}
    data = squama.sweep(beam, axes, load="bending", joint="hinge", out=tmp_path / "s.zarr")
    cell = data.isel(mu=1, alpha=0)
    same(cell, bent, "psi_e", "psi_end", "torque")


def test_uncertainty(beam):
    vary = {"mu": "+- 0.1", "theta0": "+- 1 deg"}
    u = squama.uncertainty(beam, vary, load="bending", joint="hinge", samples=3200, keep=True)
    one = u.isel(sample=7)
    own = beam.replace(friction={"mu": float(one["friction.mu"])}, scale={"theta0": float(one["scale.theta0"])})
    same(one, bend(own), "psi_e", "psi_end", "M_c")


def test_designs(beam, bent):
    c = flat(columns(beam, {}, load="bending"), 1)
    wants = [Want("engagement"), Want("lock")]
    found = evaluate(c, [], wants, Options(load="bending"), plates=True).values[:, 0]
    assert found == pytest.approx([float(bent.psi_e), float(bent.psi_end)], rel=REL)


def test_cycle_and_fit(beam, bent):
    top = 0.9 * float(bent.psi_end) / beam.pitch
    there = bend(beam, at=[top])
    c = squama.cycle(beam, [0, top, 0], load="bending", joint="hinge", points=20)
    assert (c.attrs["neutral"], float(c.psi_e[0])) == (beam.neutral, float(bent.psi_e))
    i = int(c.psi.values.argmax())
    assert float(c.M[i]) == pytest.approx(float(there.M[0]), rel=REL)
    start = beam.replace(friction={"mu": 0.2})
    fit = squama.fit(
        {"psi": c.psi.values, "M": c.M.values}, start, parameters=("mu",), load="bending", noise=1e-3, joint="hinge"
    )
    assert fit.values["mu"] == pytest.approx(0.3, rel=1e-8)


def test_vibration(beam, bent):
    start = f"{0.8 * float(bent.psi_end)!r} rad/pitch"
    v = squama.vibrate(beam, release=start, load="bending", rotor="1e-4 kg m2", swings=1, joint="hinge")
    c = squama.cycle(beam, start, load="bending", joint="hinge", points=4)
    top = int(c.psi.values.argmax())
    assert float(v.psi_e) == pytest.approx(float(bent.psi_e), rel=REL)
    assert float(v.U_turn[0]) == pytest.approx(float(c.U_el[top]) * beam.length, rel=1e-8)
    # half a swing rubs away what the way back does
    lost = float(c.W_fr[-1] - c.W_fr[top]) * beam.length
    assert float(v.U_turn[0] - v.U_turn[1]) == pytest.approx(lost, rel=1e-6)


def test_explorer(beam, bent):
    now = State(beam, 0.0).change("load", "bending").change("joint", "hinge")
    assert live.outcome(now)[0] == bent.end.item()
    figures = live.motion(now.setting).figures
    assert [figures["load_e"], figures["load_end"]] == pytest.approx([float(bent.psi_e), float(bent.psi_end)], rel=REL)


def test_the_explorer_hints_at_what_its_model_takes():
    """Bent or twisted, an empty field shows the stiffness and the factor of the model on the page."""
    skin = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
    for load, call in (("twisting", squama.twist), ("bending", squama.bend)):
        for joint in ("compliant", "hinge"):
            shown = State(skin, 0.1, load=load, joint=joint, ideal="yes" if joint == "hinge" else "no")
            found = live.own_joint(shown)
            r = call(skin, joint=joint, points=3)
            kind = LOADS[load]
            assert found["stiffness"] == pytest.approx(r.attrs.get("K_theta", skin.joint_stiffness), rel=1e-9)
            wanted = r.attrs.get("rigidity", kind.rigidity(skin)) / kind.rigidity(skin) * kind.inclusion(skin)
            assert found["inclusion"] == pytest.approx(wanted, rel=1e-9)
            # tabs stiffen a bent bar, which the hinge leaves out
            assert (found["inclusion"] > 1.2) == (load == "twisting" or joint == "compliant")
