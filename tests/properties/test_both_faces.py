"""Scales on both faces: against plates in space that share nothing with the kernel, virtual work, symmetries."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import squama
from squama.beam.faces import FACES
from squama.cli import main
from squama.contacts import increments, path
from squama.contacts.moved import moved
from squama.contacts.of_face import events_of
from squama.curves import compliant
from squama.curves.both_faces import worst
from squama.errors import InputError
from squama.symbols import OF_A_SCALE

FREE = squama.Beam.from_ratios(eta=3, beta=1.25, lam=0.45, alpha="45 deg", mu=0.2, youngs_modulus="2 MPa")
BEAM = FREE.replace(hold="straight")
BOTH = ("mirrored", "turned")
HINGE = {"joint": "hinge", "ideal": True}


def plate(beam: squama.Beam, theta: float, S: np.ndarray) -> np.ndarray:
    """Return corners D, A, B, C of a scale at z = 0 on the face that S maps the upper one to."""
    a = beam.scale.alpha
    x = np.array([-math.sin(a) * math.cos(theta), math.sin(theta), math.cos(a) * math.cos(theta)])
    y = beam.beta * np.array([math.cos(a), 0.0, math.sin(a)])
    base = np.array([0.0, beam.lam, 0.0])
    return np.array([base - y, base + y, base + y + beam.eta * x, base - y + beam.eta * x]) * S


def next_one(points: np.ndarray, psi: float, phi: float) -> np.ndarray:
    """Move points by a pitch of a bar that is bent by psi towards +y and twisted by phi: a thousand small steps."""
    n = 1000
    w = np.array([-psi, 0.0, -phi]) / n
    angle = np.linalg.norm(w)
    k = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]]) / max(angle, 1e-300)
    R = np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k
    # half a step along the middle line, the turn, half a step
    half = np.array([0.0, 0.0, 0.5 / n])
    for _ in range(n):
        points = (points + half) @ R.T + half
    return points


def through(one: np.ndarray, two: np.ndarray) -> bool:
    """Say whether an edge of one rectangle passes through the other."""
    for a, b in ((one, two), (two, one)):
        o, u, v = b[0], b[1] - b[0], b[3] - b[0]
        n = np.cross(u, v)
        for p, q in zip(a, np.roll(a, -1, axis=0), strict=True):
            hp, hq = (p - o) @ n, (q - o) @ n
            if hp * hq < 0:
                x = p + (q - p) * hp / (hp - hq) - o
                if 0 <= x @ u / (u @ u) <= 1 and 0 <= x @ v / (v @ v) <= 1:
                    return True
    return False


@pytest.mark.parametrize("faces", BOTH)
@pytest.mark.parametrize(("psi", "phi"), [(-0.08, 0.1), (-0.1, 0.0), (-0.06, -0.15), (0.05, -0.15), (-0.02, 0.2)])
def test_plates_in_space_just_touch(faces: str, psi: float, phi: float) -> None:
    r = squama.bend_twist(BEAM.replace(faces=faces), f"bend {psi} rad/pitch, twist {phi} rad/pitch", mu=0, **HINGE)
    assert r.end == "range end"
    for name, S in (("theta", (1, 1, 1)), ("theta_other", FACES[faces].S)):
        theta = float(r[name][-1])

        def meets(theta: float, S: tuple[int, ...] = S) -> bool:
            one = plate(BEAM, theta, np.array(S))
            return through(one, next_one(one, psi, phi))

        assert not meets(theta + 1e-4)
        if theta > BEAM.scale.theta0:
            assert meets(theta - 1e-4)
    # turned, both faces open where the twist does
    assert (float(r.N_other[-1]) + float(r.N[-1]) > 0) == (faces == "mirrored" or phi >= 0)


def work(beam: squama.Beam, psi: float, phi: float, **how: object) -> tuple[float, float, float]:
    path = f"bend {psi!r} rad/pitch, twist {phi!r} rad/pitch"
    r = squama.bend_twist(beam, path, mu=0, points=60, **how)
    return float(r.U_el[-1]), float(r.M[-1]), float(r["T"][-1])


@pytest.mark.parametrize(("how", "tolerance"), [(HINGE, 1e-5), ({"ideal": True}, 2e-3)])
@pytest.mark.parametrize("faces", BOTH)
def test_moment_and_torque_are_slopes_of_the_energy(faces: str, how: dict[str, object], tolerance: float) -> None:
    """Both faces and the bar: M = dU/dkappa, T = dU/dPhi per length."""
    beam, h, d = BEAM.replace(faces=faces), 1e-4, BEAM.pitch
    for psi, phi in ((0.01, 0.13), (-0.01, 0.12), (-0.01, -0.12)):
        _, M, T = work(beam, psi, phi, **how)
        by_psi = work(beam, psi + h, phi, **how)[0] - work(beam, psi - h, phi, **how)[0]
        by_phi = work(beam, psi, phi + h, **how)[0] - work(beam, psi, phi - h, **how)[0]
        assert pytest.approx(by_psi / (2 * h) * d, rel=tolerance, abs=tolerance * abs(T)) == M
        assert pytest.approx(by_phi / (2 * h) * d, rel=tolerance) == T


ALIKE = {"hinge": 1e-9, "compliant": 3e-4}
"""Differences of one face and two: increments of thick scales are as long as the work of both faces allows."""


@pytest.mark.parametrize("joint", ["hinge", "compliant"])
def test_mirrored_beams_do_the_same_both_ways_and_turned_ones_both_at_once(joint: str) -> None:
    beam = BEAM.replace(joint={"inclusion_factor": 1.5})
    at, same = np.linspace(1, 9, 5), ALIKE[joint]
    one, back = (squama.twist(beam, at=at, joint=joint, sense=s) for s in "+-")
    for sense in "+-":
        r = squama.twist(beam.replace(faces="mirrored"), at=at, joint=joint, sense=sense)
        assert r.T_scales.values == pytest.approx((one.T_scales + back.T_scales).values, rel=same)
        assert r.N.values == pytest.approx(one.N.values, rel=same)
        assert r.N_other.values == pytest.approx(back.N.values, rel=same)
        turned = squama.twist(beam.replace(faces="turned"), at=at, joint=joint, sense=sense)
        alone = one if sense == "+" else back
        # work is a sum over increments
        for name, apart in (("T_scales", same), ("W_fr", 50 * same)):
            assert turned[name].values == pytest.approx(2 * alone[name].values, rel=apart)
        assert turned["T"].values == pytest.approx((alone["T"] + alone.T_scales).values, rel=same)


@pytest.mark.parametrize("shift", ["", ", shifted"])
def test_across_the_beam_both_ways_are_one_and_a_shift_changes_nothing(shift: str) -> None:
    beam = BEAM.replace(scale={"alpha": 0})
    found = [
        (
            squama.twist(beam.replace(faces=faces), at=[5.0], joint="hinge")["T"].item(),
            squama.cycle(beam.replace(faces=faces), "0, 0.1, -0.1, 0 rad/pitch", joint="hinge").W_d.values.tolist(),
            squama.bend_twist(
                beam.replace(faces=faces), "bend -0.1 rad/pitch; twist 0.1 rad/pitch", **HINGE
            ).M_c.item(),
        )
        for faces in ("mirrored", "turned" + shift)
    ]
    assert found[0][0] == pytest.approx(found[1][0], rel=1e-12)
    assert found[0][1] == pytest.approx(found[1][1], rel=1e-12)
    assert float(found[0][2]) == pytest.approx(float(found[1][2]), rel=1e-9)


@pytest.mark.parametrize("faces", BOTH)
def test_bent_both_ways_the_beam_is_as_stiff(faces: str) -> None:
    beam = BEAM.replace(faces=faces)
    there, back = (squama.bend_twist(beam, f"bend {v} rad/pitch", **HINGE) for v in (0.1, -0.1))
    alone = squama.bend_twist(BEAM, "bend -0.1 rad/pitch", **HINGE)
    assert float(back.M_c) == pytest.approx(-float(there.M_c), rel=1e-9)
    assert float(back.T_c) == pytest.approx({"mirrored": -1, "turned": 1}[faces] * float(there.T_c), rel=1e-9)
    # scales on one face open
    assert float(alone.M_scales[-1]) == 0
    assert abs(float(back.M_scales[-1])) > abs(float(back.M_c - back.M_scales[-1]))
    one, two = (squama.bend(b, at=[0.1 / BEAM.pitch], joint="hinge") for b in (BEAM, beam))
    assert two.M_scales.item() == pytest.approx(one.M_scales.item(), rel=1e-9)
    # thick scales by the path of both loads that bends alone
    alone, path = squama.bend(beam, to="0.1 rad/pitch"), squama.bend_twist(beam, "bend 0.1 rad/pitch")
    assert (alone.attrs["joint"], alone.attrs["neutral"]) == ("compliant", "middle")
    assert alone.M_c.item() == pytest.approx(path.M_c.item(), rel=1e-4)


@pytest.mark.parametrize("joint", ["hinge", "compliant"])
@pytest.mark.parametrize("faces", BOTH)
def test_a_cycle_goes_up_the_curve(faces: str, joint: str) -> None:
    beam = BEAM.replace(faces=faces)
    history = "0, 0.12, -0.12, 0 rad/pitch" if faces == "mirrored" else "0, 0.12, 0 rad/pitch"
    c = squama.cycle(beam, history, joint=joint)
    r = squama.twist(beam, at="0.12 rad/pitch", joint=joint)
    i = int(np.argmax(c.phi.values))
    for name in ("T", "U_el", "T_scales"):
        assert float(c[name][i]) == pytest.approx(r[name].item(), rel=1e-5)
    if faces == "mirrored":
        assert float(c["T"].min()) == pytest.approx(-float(c["T"].max()), rel=1e-5)
        # a loop on each side
        assert c.W_d.values[0] == pytest.approx(c.W_d.values[1], rel=1e-4)


def test_the_curve_ends_where_one_face_does() -> None:
    """At a small alpha the other face's scales meet in the other sense as well, and are followed in a curve only."""
    beam = BEAM.replace(scale={"alpha": "5 deg"}, faces="mirrored")
    one, back = (squama.twist(BEAM.replace(scale={"alpha": "5 deg"}), sense=s, joint="hinge") for s in "+-")
    r = squama.twist(beam, joint="hinge")
    assert r.end == back.end == "other contact"
    assert float(r.phi_end) == pytest.approx(float(back.phi_end), rel=1e-9)
    assert float(one.phi_end) > float(r.phi_end)
    assert str(r.other_contact.values).startswith("of the other face: ")
    with pytest.raises(InputError, match="of the other face"):
        squama.cycle(beam, "0.16 rad/pitch", joint="hinge")


@pytest.mark.parametrize("call", [
    lambda b: squama.sweep(b, {"alpha": ("30 deg", "40 deg", 3)}, out="store.zarr", joint="hinge"),
    lambda b: squama.uncertainty(b, {"alpha": "+- 1 deg"}, joint="hinge"),
    lambda b: squama.cell(b, to=1.0),
    squama.joint,
    lambda b: squama.bend_twist(b, "bend 1 rad/m", mu=0, free="twisting"),
])  # fmt: skip
def test_what_takes_one_face_says_so(call, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r'beam.faces = "mirrored": is not covered by .*write faces = "one"'):
        call(BEAM.replace(faces="mirrored"))


def test_the_line_between_both_faces_is_in_the_middle() -> None:
    """Of hinges; on compliant joints the bar may stretch."""
    with pytest.raises(InputError, match=r'write "?(neutral=)?"?middle"'):
        squama.bend(BEAM.replace(faces="turned"), neutral="face")
    found = squama.bend_twist(FREE.replace(faces="turned"), "bend 1 rad/m", neutral="free", joint="compliant")
    assert found.attrs["neutral"] == "free"


def test_tabs_of_both_faces_stiffen_the_bar_unless_that_is_given() -> None:
    alone = BEAM.C_f
    both = BEAM.replace(faces="mirrored")
    assert both.C_f == pytest.approx(1 + 2 * (alone - 1), rel=1e-12)
    assert any("tabs in both faces" in line for line in both.warnings())
    one, two = (squama.twist(b, joint="compliant").attrs["rigidity"] for b in (BEAM, both))
    bare = BEAM.G_B * BEAM.J
    assert two - bare == pytest.approx(2 * (one - bare), rel=1e-12)
    given = both.replace(joint={"inclusion_factor": 1.3})
    assert given.C_f == 1.3
    assert squama.twist(given, joint="compliant").attrs["rigidity"] == pytest.approx(1.3 * bare, rel=1e-9)
    assert not any("tabs in both faces" in line for line in given.warnings())
    with pytest.raises(InputError, match="beyond the middle, to those of the other face"):
        both.replace(scale={"embedded": "80 mm", "theta0": "10 deg"})
    with pytest.raises(InputError, match=r'substrate.neutral = "face": .*write "middle"'):
        BEAM.replace(faces="mirrored", substrate={"neutral": "face"})


def test_the_face_that_comes_to_another_contact_first_ends_the_curve() -> None:
    beam = squama.Beam.from_ratios(mu=0.1, alpha="20 deg", theta0="20 deg")
    alone = squama.twist(beam, sense="-", joint="hinge")
    both = squama.twist(beam.replace(faces="mirrored"), joint="hinge")
    assert (alone.end.item(), both.end.item()) == ("no engagement", "other contact")
    assert both.other_contact.item() == f"of the other face: {alone.other_contact.item()}"
    assert both.phi_end.item() == pytest.approx(alone.phi_touch.item(), rel=1e-12)
    # the curve's own points have its engagement among them
    assert both.phi_e.item() < both.phi_end.item()
    assert both.phi_e.item() in both.phi.values
    assert (both.RED[0], both.U_el[0]) == (0, 0)


def test_what_replaces_a_lock_is_told_of_both_faces() -> None:
    beam = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None).replace(hold="straight")
    one, both = (squama.twist(b) for b in (beam, beam.replace(faces="turned")))
    # the slope right after engagement
    for r in (one, both):
        assert r.phi_twofold.item() == r.phi_fivefold.item() == pytest.approx(r.phi_e.item(), rel=1e-9)
    assert both.stiffness_ratio.max() > 1.2 * one.stiffness_ratio.max()
    # wherever the points stand
    apart = squama.twist(beam.replace(faces="mirrored"), at=[1.0, 12.0])
    assert apart.phi_twofold.item() == pytest.approx(apart.phi_e.item(), rel=1e-9)


@pytest.mark.parametrize(("faces", "both"), [("turned", 2), ("mirrored", 1)])
def test_a_second_contact_of_a_face_goes_on(faces: str, both: int) -> None:
    """Mirrored, the other face opens; turned, both do the same."""
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None).replace(hold="straight")
    r = squama.twist(beam.replace(faces=faces), to="0.24 rad/pitch")
    assert float(r.phi_second) < float(r.phi[-1]) == pytest.approx(0.24)
    one = squama.twist(beam, at=r.Phi.values)
    np.testing.assert_allclose(r.T_scales, both * one.T_scales, rtol=ALIKE["compliant"], atol=1e-12)
    assert float(one.N[-1]) > 0


@pytest.mark.parametrize("faces", BOTH)
def test_points_are_even_up_to_the_end(faces: str) -> None:
    beam = squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scales=None)
    one = squama.twist(beam, points=20)
    r = squama.twist(beam.replace(faces=faces), points=20)
    assert r.end.item() == "range end"
    assert r.other_contact.item().split(" at ")[0] == one.other_contact.item().split(" at ")[0]
    assert np.isfinite(r["T"].values).all()
    assert float(r.phi[-1]) == pytest.approx(float(one.phi[-1]), abs=5e-3)
    assert float(r.T_c) == float(r["T"][-1])


SKIN = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None).replace(hold="straight")


@pytest.mark.parametrize("joint", ["hinge", "compliant"])
@pytest.mark.parametrize("faces", BOTH)
def test_every_figure_of_a_scale_is_told_of_the_other_face(faces: str, joint: str) -> None:
    """They are those of one face on the path that the other one sees."""
    bend, twist, _ = FACES[faces].seen
    paths = [f"bend {0.15 * b} rad/pitch, twist {0.03 * t} rad/pitch" for b, t in ((-1, 1), (-bend, twist))]
    both, one = (
        squama.bend_twist(beam, path, points=30, joint=joint)
        for beam, path in zip((SKIN.replace(faces=faces), SKIN), paths, strict=True)
    )
    assert both.contact_other.values[-1] == one.contact.values[-1] == "BF"
    told = [name for name in OF_A_SCALE if name in one and name != "contact"]
    assert len(told) >= (4 if joint == "hinge" else 20)
    for name in told:
        assert float(both[f"{name}_other"][-1]) == pytest.approx(float(one[name][-1]), rel=ALIKE[joint]), name
        assert both[f"{name}_other"].attrs["long_name"] == f"{one[name].attrs['long_name']}, of the other face"
    if joint == "compliant":
        # the scaled face is open: what is held against a strength is the other's
        assert (float(both.stress[-1]), float(both.stress_other[-1]) > 1e6) == (0, True)
        assert worst({"stress": both.stress.values, "stress_other": both.stress_other.values}, "stress")[-1] > 1e6


def test_a_strength_is_held_against_the_face_with_the_larger_stress(tmp_path, capsys) -> None:
    (tmp_path / "beam.toml").write_text(SKIN.replace(faces="mirrored").to_toml())
    found = []
    for sign in (1, -1):
        path = f"bend {0.15 * sign} rad/pitch"
        assert main(["bend-twist", str(tmp_path / "beam.toml"), "--path", path, "--points", "20", "--json"]) == 0
        found.append(json.loads(capsys.readouterr().out)["ways"]["compliant"]["stress"][0])
    assert found[0] == pytest.approx(found[1], rel=1e-9)
    assert found[0] > 1e6


@pytest.mark.parametrize("sense", ["+", "-"])
def test_limits_are_those_of_the_face_that_comes_to_them_first(sense: str) -> None:
    given = {"scale": {"strength": 1e6}, "substrate": {"strain_limit": 0.05}}
    one = squama.twist(SKIN.replace(**given), points=50)
    both = squama.twist(SKIN.replace(faces="mirrored", **given), points=50, sense=sense)
    for name in ("phi_strength", "phi_strain"):
        assert float(both[name]) == pytest.approx(float(one[name]), rel=1e-3)
    np.testing.assert_array_equal(both.stress_other, 0)
    assert {f"{name}_other" for name in OF_A_SCALE if name in one and name != "contact"} <= set(both)


def half_of(beam: squama.Beam, free: tuple[int, ...]) -> path.Path:
    """Return scales on one face of half a bar: half of a cell that both faces halve."""
    held, order = compliant.Held.of(beam), (1, 0, 3)
    K = held.K.copy()
    for row, strain in enumerate(order):
        K[6 + row, 6 + row] -= held.own[strain] / 2
    return path.Path.of(compliant.scale(beam, ideal=False), K, 0.0, free=free, aside=0.0)


@pytest.mark.parametrize("beam", [SKIN, FREE])
def test_turned_faces_keep_a_free_beam_straight(beam: squama.Beam) -> None:
    """By symmetry it neither bows nor bends sideways, and each face twists half the bar, which stretches."""
    both = beam.replace(faces="turned", hold="nothing")
    at = np.array([0.06, 0.1, 0.15])
    r, rubbed = (squama.twist(both, mu=mu, at=at / beam.pitch) for mu in (0, 0.3))
    assert r.attrs["hold"] == "nothing"
    assert float(np.abs([rubbed.psi, rubbed.chi]).max()) < 1e-8
    assert float(np.abs([r.psi, r.chi]).max()) < 1e-9
    assert float(np.abs([r.M, r.M_lat, r.P]).max()) == 0
    (half,) = half_of(both, (0, 0, 0, 1)).follow(at).rows
    np.testing.assert_allclose(r["T"], 2 * beam.unit_moment * path.named(half)["torque"], rtol=1e-7)
    np.testing.assert_allclose(r.stretch, path.named(half)["stretch"], rtol=1e-7)
    for name in ("theta", "N", "slip"):
        np.testing.assert_allclose(rubbed[f"{name}_other"], rubbed[name], rtol=1e-7)
    # nothing else is held, so that holding it takes nothing
    guided = squama.twist(both, mu=0, at=at / beam.pitch, hold="bend, lateral bend")
    np.testing.assert_allclose(guided["T"], r["T"], rtol=1e-7)
    assert float(np.abs([guided.M, guided.M_lat]).max()) < 1e-7 * float(r["T"].max())


@pytest.mark.parametrize("sense", ["+", "-"])
def test_mirrored_faces_let_a_free_beam_bow_until_the_other_one_touches(sense: str) -> None:
    """One face's scales push the beam off; bent so far, the other ones come in, which a straight beam keeps open."""
    both, how = FREE.replace(faces="mirrored"), {"mu": 0.3, "to": "0.2 rad/pitch", "points": 60, "sense": sense}
    held, free = (squama.twist(both, hold=hold, **how) for hold in ("straight", "nothing"))
    assert math.isinf(float(held.phi_e_other))
    assert float(free.phi_e) < 0.04 < 0.1 < float(free.phi_e_other) < 0.18
    assert float(free["T"][-1]) < 0.8 * float(held["T"][-1])
    assert abs(float(free.psi[-1])) > 0.05
    # each sense bows the beam to its own side
    assert float(free.psi[-1]) * {"+": 1, "-": -1}[sense] < 0
    assert (float(held.N_other[-1]), float(free.N_other[-1]) > 0) == (0, True)
    for r in (held, free):
        assert abs(float(r.energy_error)) < 1e-4
        assert (r.stiffness_ratio[r.phi < r.phi_e] == 1).all()


@pytest.mark.parametrize("faces", BOTH)
@pytest.mark.parametrize("hold", ["nothing", "lateral bend", "twist, stretch"])
def test_the_load_of_a_free_beam_is_the_slope_of_its_energy(faces: str, hold: str) -> None:
    beam, h = FREE.replace(faces=faces, hold=hold), 3e-4
    for load, torque, angle in ((squama.twist, "T", "phi"), (squama.bend, "M", "psi")):
        at = np.array([0.17 - h, 0.17, 0.17 + h])
        r = load(beam, mu=0, at=at / beam.pitch, joint="compliant")
        np.testing.assert_allclose(r[angle], at, rtol=1e-12)
        slope = float(r.U_el[2] - r.U_el[0]) / (2 * h) * beam.pitch
        assert float(r[torque][1]) == pytest.approx(slope, rel=1e-4)


@pytest.mark.parametrize("faces", BOTH)
def test_derivatives_of_both_faces_are_those_of_differences(faces: str) -> None:
    """With a complex step in the twist, friction and free strains."""
    beam = FREE.replace(faces=faces)
    held, step = compliant.Held.of(beam), 1e-6
    scale, mus = path.Scale(*np.array([compliant.scale(beam, ideal=False)]).T), np.array([0.3])
    one = path.beams(scale, held.K[None], mus, **held.bar)
    at = np.array([[0.1, 0.17]])
    found = moved(one, at + 1e-20j * np.array([[0.0, 1.0]]), 1, most=0.0)
    up, down = (path.follow_all(one, at + np.array([[0.0, v]]), most=0.0) for v in (step, -step))
    for face, a, b in zip(found.faces, up.faces, down.faces, strict=True):
        for name in ("torque", "psi", "N", "w_Y"):
            slope = (path.named(a.rows)[name] - path.named(b.rows)[name])[0, 1] / (2 * step)
            told = path.named(face.rows)[name][0, 1].imag / 1e-20
            assert told == pytest.approx(slope, rel=1e-3, abs=1e-6)


def test_a_cycle_goes_on_where_both_faces_touch() -> None:
    """At a small alpha both faces of a mirrored beam take part in either sense."""
    wide = {"width": 1.1 * FREE.scale.width}
    beam = FREE.replace(scale={"alpha": "5 deg"}, substrate=wide, faces="mirrored", hold="straight")
    c = squama.cycle(beam, "0, 0.2, -0.2, 0 rad/pitch", mu=0.3, joint="compliant", points=20)
    r = squama.twist(beam, at="0.2 rad/pitch", mu=0.3, joint="compliant")
    i, j = int(c.phi.values.argmax()), int(c.phi.values.argmin())
    for name in ("T", "N", "N_other", "M", "W_fr"):
        assert float(c[name][i]) == pytest.approx(r[name].item(), rel=1e-3), name
    assert 0 < float(c.N_other[i]) < float(c.N[i])
    for name, sign in (("T", -1), ("N", 1), ("N_other", 1), ("M", -1)):
        assert float(c[name][j]) == pytest.approx(sign * float(c[name][i]), rel=1e-6), name
    assert abs(float(c.energy_error)) < 1e-3
    assert c.W_d.values[0] == pytest.approx(c.W_d.values[1], rel=1e-6)


def test_events_name_the_face() -> None:
    """Bent to and fro: one face touches and opens, then the other one."""
    r = squama.bend_twist(SKIN.replace(faces="mirrored"), "bend 0.1 rad/pitch; bend -0.1 rad/pitch", points=20)
    told = [word for word in r.event.values.tolist() if word.endswith("engagement (BF)")]
    assert told == ["engagement (BF)", "of the other face: engagement (BF)"]
    place = {word: float(psi) for word, psi in zip(r.event.values.tolist(), r.psi_event, strict=True)}
    assert place[told[1]] == pytest.approx(-place[told[0]], rel=1e-6)
    assert (r.N[-1].item(), r.contact[-1].item(), r.contact_other[-1].item()) == (0, "", "BF")


def test_events_are_those_of_the_face_whose_contacts_change() -> None:
    """A jump, too, whichever contact it is told of; one that changes no contact is of that contact's face."""
    one, other = 80.0, increments.SCALE + 80.0
    told = [
        (increments.ENGAGE, 0, (one,)),
        (increments.ENGAGE, 1, (one, other)),
        (increments.SNAP, 0, (one,)),
        (increments.CHANGE, 0, (one,)),
    ]
    events = np.full((1, 6, increments.EVENT + path.ROOM), -1.0)
    for row, (kind, face, after) in zip(events[0], told, strict=False):
        row[0], row[6], row[increments.AFTER : increments.AFTER + len(after)] = kind, face, after
    ends = np.array([[0.0, 0.3, len(told), 1.0]])
    for face, kinds in enumerate([[increments.ENGAGE, increments.CHANGE], [increments.ENGAGE, increments.SNAP]]):
        own, last = events_of(face, events, ends)
        assert own[0, : int(last[0, 2]), 0].tolist() == kinds
        assert own[0, : len(kinds), 13].tolist() == [1, 1 - face]
