"""Decks: what they say, that their syntax holds, and that CalculiX runs them with the edges in contact."""

import shutil

import decks
import numpy as np
import pytest
import xarray as xr

import squama
from squama.errors import InputError
from squama.fe import ccx

BEAM = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2)
COARSE = {"size": 0.4, "edge_size": 0.2}
D, E = BEAM.pitch, BEAM.substrate.youngs_modulus
needs_ccx = pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed (calculix-ccx)")


@pytest.fixture(scope="module")
def model():
    pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
    from squama.fe import deck

    return deck.model(BEAM, scales=3, mu=0.2, twist=0.1, ideal=True, **COARSE)


@pytest.fixture(scope="module", params=["calculix", "abaqus"])
def written(model, request):
    from squama.fe import deck

    return request.param, deck.write(model, request.param)


@pytest.mark.slow(but=1)
def test_the_syntax_of_both_dialects(written):
    dialect, text = written
    assert decks.check(text, dialect) == []
    other = {"calculix": "abaqus", "abaqus": "calculix"}[dialect]
    assert any("RIGID BODY" in line for line in decks.check(text, other))


def test_what_a_deck_says(written, model):
    dialect, text = written
    deck = decks.read(text)
    x = np.array([deck.nodes[i] for i in range(1, len(deck.nodes) + 1)])
    assert np.ptp(x[np.array(deck.nsets["EDGES"]) - 1, 0]) == pytest.approx(1.28 * D * 1e3)
    # the tetrahedra fill three pitches of the section less the slots
    tets = np.array([n for n in deck.elements.values() if len(n) == 10]) - 1
    a, b, c, e = (x[tets[:, i]] for i in range(4))
    volume = np.einsum("ij,ij->i", np.cross(b - a, c - a), e - a) / 6
    assert volume.min() > 0
    assert volume.sum() / (D * 1e3) ** 3 == pytest.approx(3 * (1.28 * 0.64 - 0.18 * 1.2 * 0.004), rel=2e-3)
    # each strip looks down on the mid-plane that the next plate's face is
    pairs = [card.data[0][1] for card in deck.cards if card.name == "CONTACT PAIR"]
    assert pairs == [["TIP1", "FACE2"], ["TIP2", "FACE3"]]
    for i, sign in ((1, -1), (2, -1), (3, 1)):
        bricks = np.array([deck.elements[n] for n in deck.elsets[f"{'STRIP' if sign < 0 else 'PLATE'}{i}"]]) - 1
        face = bricks[:, :4] if sign < 0 else bricks[:, 4:]
        p = x[face] / (D * 1e3) - [0, 0.32, i - 1]
        th, al = np.radians(10), np.radians(45)
        nx = np.array([-np.sin(al) * np.cos(th), np.sin(th), np.cos(al) * np.cos(th)])
        ny = np.array([np.cos(al), 0, np.sin(al)])
        assert np.abs(p @ np.cross(nx, ny)).max() < 1e-7
        assert (p @ nx).max() == pytest.approx(3)
        assert np.ptp(p @ ny) == pytest.approx(1.2)
        body = x[bricks].mean(axis=1) / (D * 1e3) - [0, 0.32, i - 1]
        assert (-sign * (body @ np.cross(nx, ny)) > 0).all()
    bodies = [[*p.tied, *p.nodes] for p in model.plates]
    flat = np.concatenate([*bodies, model.sets["FIXED"], model.sets["TURNED"]])
    assert np.unique(flat).size == flat.size
    assert ("NEVER RUN IN ABAQUS" in text) == (dialect == "abaqus")


THICK = BEAM.replace(scale={"thickness": 0.05 * D})
PRINTED = THICK.replace(scale={"youngs_modulus": 2e3 * E, "poisson_ratio": 0.35})


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("beam", [THICK, PRINTED], ids=["rigid", "elastic"])
def test_a_deck_of_thick_scales(beam):
    pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
    from squama.fe import deck

    made = deck.model(beam, scales=2, mu=0.2, twist=0.1, **COARSE)
    for dialect in ("calculix", "abaqus"):
        assert decks.check(deck.write(made, dialect), dialect) == []
    read = decks.read(deck.write(made, "calculix"))
    th, al = np.radians(10), np.radians(45)
    nx = np.array([-np.sin(al) * np.cos(th), np.sin(th), np.cos(al) * np.cos(th)])
    ny = np.array([np.cos(al), 0, np.sin(al)])
    axes = np.array([nx, ny, np.cross(nx, ny)])

    def local(numbers, i):
        return (np.array([read.nodes[n] for n in numbers]) / (D * 1e3) - [0, 0.32, i]) @ axes.T

    elastic = beam is PRINTED
    for i, plate in enumerate(made.plates):
        tip, side = local(plate.tip, i), local(plate.side, i)
        # the lower tip edge from C to B, the upper side edge from D to C
        np.testing.assert_allclose(tip[[0, -1]], [[3, -0.6, -0.025], [3, 0.6, -0.025]], atol=1e-7)
        np.testing.assert_allclose(side[[0, -1]], [[0, -0.6, 0.025], [3, -0.6, 0.025]], atol=1e-7)
        under = read.elsets[f"UNDER{i + 1}" if elastic else f"STRIP{i + 1}"]
        upon = read.elsets[f"UPON{i + 1}" if elastic else f"PLATE{i + 1}"]
        low = local(np.concatenate([read.elements[n][:4] for n in under]), i)
        high = local(np.concatenate([read.elements[n][4:] for n in upon]), i)
        np.testing.assert_allclose(low[:, 2], -0.025, atol=1e-7)
        np.testing.assert_allclose(high[:, 2], 0.025, atol=1e-7)
        assert low[:, 0].min() == pytest.approx(2.88)
        assert np.ptp(high, axis=0) == pytest.approx([3, 1.2, 0], abs=2e-7)
        if elastic:
            bricks = np.array([read.elements[n] for n in read.elsets[f"BLADE{i + 1}"]])
            size = [np.ptp(local(brick, i), axis=0).prod() for brick in bricks]
            assert sum(size) == pytest.approx(3 * 1.2 * 0.05, rel=1e-5)
            root = [n for n in np.unique(bricks) if abs(local([n], i)[0, 0]) < 1e-7]
            assert set(root) <= set(read.nsets[f"BODY{i + 1}"])
            assert set(np.unique(bricks)) & set(read.nsets[f"BODY{i + 1}"]) == set(root)
            assert np.unique(bricks).max() < plate.ref


@pytest.mark.slow
def test_a_deck_of_long_tabs():
    """Plain bar closes the leaning ends: its faces are planes, and nothing else is held."""
    pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
    from squama.fe import deck

    sheets = squama.Beam.from_toml("examples/long_tabs.toml").replace(scale={"width": 0.01})
    made = deck.model(sheets, scales=2, mu=0.2, twist=0.1, size=0.4, edge_size=0.3)
    for dialect in ("calculix", "abaqus"):
        assert decks.check(deck.write(made, dialect), dialect) == []
    x = made.nodes / 10
    a, b, c, e = (x[made.tets[:, i] - 1] for i in range(4))
    volume = np.einsum("ij,ij->i", np.cross(b - a, c - a), e - a) / 6
    assert volume.min() > 0
    assert volume.sum() == pytest.approx((2 + 3) * 2.5 * 1.25 - 2 * 1.28 * 1.0 * 0.1, rel=1e-6)
    front, back = (x[made.sets[name] - 1] for name in ("FIXED", "TURNED"))
    places = [at[:, 2] - at[:, 0] * np.tan(np.radians(40)) for at in (front, back)]
    assert [np.ptp(place) for place in places] == pytest.approx([0, 0], abs=1e-9)
    assert places[1].mean() - places[0].mean() == pytest.approx(5)
    assert x[made.ref - 1][2] == pytest.approx(places[1].mean())
    assert made.angle == pytest.approx(0.2)


GOOD = """*HEADING
a brick
*NODE, NSET=NALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
*ELEMENT, TYPE=C3D8, ELSET=ALL
1, 1, 2, 3, 4, 5, 6, 7, 8
*MATERIAL, NAME=M
*ELASTIC
1., 0.3
*SOLID SECTION, ELSET=ALL, MATERIAL=M
*SURFACE, NAME=TOP, TYPE=ELEMENT
ALL, S2
*STEP, NLGEOM, INC=10
*STATIC
0.1, 1., 1e-5, 0.1
*BOUNDARY
NALL, 1, 3, 0.
*END STEP
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("*STATIC", "*STATICS", "STATICS: is no keyword"),
        ("INC=10", "INCR=10", "INCR: unknown parameter"),
        ("NAME=M\n", "NAMES=M\n", "lacks NAME"),
        ("MATERIAL=M", "MATERIAL=STEEL", "no material STEEL"),
        ("NALL, 1", "FIXED, 1", "no node or node set FIXED"),
        ("NALL, 1, 3", "NALL, 1, 7", "degrees of freedom"),
        ("ALL, S2", "ALL, S9", "S9: is no face"),
        ("ALL, S2", "BALL, S2", "no element set BALL"),
        ("5, 6, 7, 8\n", "5, 6, 7, 9\n", "there is no node 9"),
        ("5, 6, 7, 8\n", "5, 6, 7, 7\n", "twice"),
        ("5, 6, 7, 8\n", "5, 6, 7\n", "7 nodes, C3D8 has 8"),
        ("8, 0., 1., 1.", "8, 0., 1.", "cannot be read"),
        ("1., 0.3", "1.", "*ELASTIC: 1 entries"),
        ("0.1, 1., 1e-5, 0.1\n", "", "has 0 data lines"),
        ("*END STEP\n", "", "no complete step"),
        ("*STEP, NLGEOM, INC=10\n", "", "belongs into a step"),
        ("*END STEP\n", "*SOLID SECTION, ELSET=ALL, MATERIAL=M\n*END STEP\n", "belongs before the step"),
        ("a brick", "a brick" + 250 * "x", "characters, 256 at most"),
        ("*STEP", "*NSET, NSET=A\n" + ", ".join("1" * 17) + "\n*STEP", "17 entries"),
    ],
)
def test_the_reader_finds(old, new, words):
    assert decks.check(GOOD, "abaqus") == []
    assert GOOD.count(old) >= 1
    try:
        found = decks.check(GOOD.replace(old, new, 1), "abaqus")
    except InputError as error:
        found = [str(error)]
    assert any(words in line for line in found), found


def corners(theta, phi, scales):
    """Corners D, A, B, C of scales along the helix, in pitches."""
    al = BEAM.scale.alpha
    nx = np.array([-np.sin(al) * np.cos(theta), np.sin(theta), np.cos(al) * np.cos(theta)])
    ny = np.array([np.cos(al), 0, np.sin(al)])
    flat = [BEAM.lam * np.eye(3)[1] + X * nx + Y * ny for X, Y in ((0, -0.6), (0, 0.6), (3, 0.6), (3, -0.6))]
    out = []
    for i in range(scales):
        c, s = np.cos(i * phi), np.sin(i * phi)
        out.append([[c * v[0] + s * v[1], c * v[1] - s * v[0], v[2] + i] for v in flat])
    return np.array(out)


def test_gap_and_attitude_of_known_places():
    ratios = BEAM.ratios
    theta0, phi_e = ratios["theta0"], float(squama.ends(**ratios, mu=0).phi_e)
    states = np.array([corners(theta0, phi, 3) for phi in (0, phi_e, 1.2 * phi_e)])
    D, _, B, C = np.moveaxis(states, 2, 0)
    gap = ccx._gaps(np.stack([C, B], axis=2), np.stack([D, C], axis=2))
    assert gap[0, 0] > 0.05
    assert np.abs(gap[1, :2]).max() < 1e-9
    assert gap[2, 0] < -0.01
    assert np.isnan(gap[:, 2]).all()
    # with points between, the same
    more = np.linspace(0, 1, 4)[:, None]
    tips, sides = (a[:, :, None] * (1 - more) + b[:, :, None] * more for a, b in ((C, B), (D, C)))
    np.testing.assert_allclose(ccx._gaps(tips, sides), gap, atol=1e-12)
    states = np.stack([corners(theta0, 0, 3), corners(0.3, 0.1, 3)])
    local = np.array([[0, 0, 0], [0, 0.1, 0.2]])
    w = ccx._turns(states, local)
    np.testing.assert_allclose(theta0 - w[..., 1], [[theta0] * 3, [0.3] * 3], atol=1e-12)
    assert np.abs(w[..., ::2]).max() < 1e-12


def test_a_lost_contact_is_refused():
    gap = np.array([[0.1, np.nan], [-0.001, np.nan], [-0.06, np.nan], [-0.2, np.nan]])
    data = xr.Dataset({"gap": (("point", "scale"), gap)}, coords={"phi": ("point", [0, 0.05, 0.1, 0.15])})
    with pytest.raises(ccx.CalculixError, match="contact of scales 1 and 2 was lost in increment 2") as caught:
        ccx.audit(data)
    assert caught.value.done.sizes["point"] == 2
    assert ccx.audit(data.isel(point=slice(0, 2))).sizes["point"] == 2


def test_calculix_that_is_missing(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="apt-get install calculix-ccx"):
        ccx.run_calculix(tmp_path / "beam.inp")


@needs_ccx
def test_a_run_that_does_not_come_through(model, tmp_path):
    from squama.fe import deck

    place = tmp_path / "beam.inp"
    text = deck.write(model, "calculix")
    place.write_text(text)
    with pytest.raises(ccx.CalculixError, match=r"stopped after 0.2 s; 0 increments are done: give it more time"):
        ccx.run_calculix(place, timeout=0.2)
    place.write_text(text.replace("TYPE=C3D10", "TYPE=C3D99"))
    with pytest.raises(ccx.CalculixError, match=r"stopped after 0 increments \(\*ERROR"):
        ccx.run_calculix(place)
    place.write_text(GOOD)
    with pytest.raises(InputError, match="not written by squama deck"):
        ccx.run_calculix(place)


def test_results_of_a_run_that_broke_off(model):
    from squama.fe import deck

    text = deck.write(model, "calculix")
    parsed = decks.read(text)

    def table(words, name, time, value):
        lines = [f" {n} {value} 0. 0." for n in parsed.nsets[name]]
        return "\n".join([f" {words} for set {name} and time {time}", "", *lines, ""])

    def increment(time, value):
        return "".join(
            table(words, name, time, value)
            for words, name in (("displacements (vx,vy,vz)", name) for name in ("CORNERS", "TIP", "SIDE", "EDGES"))
        ) + table("forces (fx,fy,fz)", "FIXED", time, 0.0)

    whole = increment("0.1", 0.0) + increment("0.2", 1.0)
    found = ccx.results(text, whole)
    np.testing.assert_allclose(found.phi, [0, 0.01, 0.02])
    # all moved sideways together: nothing turned, the gaps as they were
    np.testing.assert_allclose(found.theta.values, BEAM.scale.theta0)
    np.testing.assert_allclose(found.gap.values[:, :2], found.gap.values[0, 0])
    for cut in (whole[:-30], whole[: len(whole) * 3 // 5]):
        assert ccx.results(text, cut).sizes["point"] == 2
    assert ccx.results(text, whole[:300]).sizes["point"] == 1


def test_the_command(tmp_path, monkeypatch, capsys):
    pytest.importorskip("netgen", reason="meshes need netgen-mesher (the extra fe)")
    from squama.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "beam.toml").write_text(BEAM.to_toml())
    flags = ["--scales", "2", "--size", "0.4", "--edge-size", "0.2"]
    assert main(["deck", "beam.toml", "-o", "beam.inp", "--for", "abaqus", *flags]) == 0
    assert "never run in Abaqus" in capsys.readouterr().out
    assert decks.check((tmp_path / "beam.inp").read_text(), "abaqus") == []


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--for", "ansys"], '--for = "ansys": must be "calculix" or "abaqus"'),
        (["--scales", "1"], "--scales"),
        (["--scales", "101"], "--scales"),
        (["--to", "3 deg"], "--to"),
        (["--to", "-1 rad/m"], "--to"),
        (["--increments", "0"], "--increments"),
        (["--material", "steel"], "--material"),
        (["--size", "x"], "--size"),
        (["-o", "nowhere/beam.inp"], "nowhere"),
        (["-o", "beam.txt"], "allowed: .inp"),
    ],
)
def test_bad_flags(flags, words, tmp_path, monkeypatch, capsys):
    from squama.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "beam.toml").write_text(BEAM.to_toml())
    arguments = flags if "-o" in flags else ["-o", "beam.inp", *flags]
    assert main(["deck", "beam.toml", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert all(line.startswith("squama: error: ") for line in said.splitlines())
    assert [p.name for p in tmp_path.iterdir()] == ["beam.toml"]
