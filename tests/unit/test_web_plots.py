"""What the explorer's plots show without a browser: both models, axes, loops, measured tables, fits, prints."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from fig6b import BEAM

import squama
from squama.errors import InputError
from squama.plot.palette import THEMES
from squama.web import charts, live, prints, state, tables
from squama.web.fields import MATERIALS, made_of, material

PLA = state.preset("pla")
HINGE = PLA.hinged.started()
LOOP = Path("examples/measured_loop.csv").read_bytes()


def named(
    now: state.State, plot: str = "torque", table: tables.Table | None = None, fit: tables.Fitted | None = None
) -> dict[str, charts.Line]:
    return {line.name: line for line in charts.lines(now, plot, dark=False, table=table, fit=fit)}


def test_compliant_and_hinge_curves_stand_together() -> None:
    for now, other, joint in ((PLA, "on hinges", "hinge"), (HINGE, "on compliant joints", "compliant")):
        shown = named(now)
        assert list(shown) == ["without contact", other, charts.OWN]
        r = squama.twist(now.beam, joint=joint, at=["0.1 rad/pitch"], ends="endless")
        assert np.interp(0.1, shown[other].x, shown[other].y) == pytest.approx(r["T"].item(), rel=0.015)
    bent = named(PLA.change("load", "bending"))
    assert list(bent) == ["without contact", "on hinges", charts.OWN]
    for name, joint in (("on hinges", "hinge"), (charts.OWN, "compliant")):
        r = squama.bend(PLA.beam, joint=joint, at=["0.1 rad/pitch"], ends="endless")
        assert np.interp(0.1, bent[name].x, bent[name].y) == pytest.approx(r["M"].item(), rel=0.015)
    # it is not there beside a joint that is not known at once
    assert list(named(state.preset("main").change("theta0", "36"))) == ["without contact", charts.OWN]


def test_the_explorer_takes_the_compliant_joint() -> None:
    now = state.of(BEAM).change("joint", "compliant").change("twist", "0.2 rad/pitch")
    assert state.read(state.query(now)) == now
    live.prepare(now)
    shown = live.scene(now)
    assert np.shape(shown["state"]["pose"]) == (3, 3)
    json.dumps([shown, *(charts.line_options(now, plot, dark=False) for plot in charts.PLOTS)], allow_nan=False)
    assert live.verdict(now).startswith("Endless beam: free until ")
    assert "u_X (m)" in live.make_file(now, "csv")[1].decode()
    assert "compliant" in live.compared(now)[0]["model"]


def test_a_torque_near_a_lock_does_not_set_the_scale() -> None:
    own = charts.frame(PLA, "torque").top
    assert own == pytest.approx(1.04 * live.along(PLA.setting).torque.max())
    # nor does a kept one on hinges, or the place of the current point
    assert charts.frame(HINGE.keep()._replace(joint="compliant", ideal="no"), "torque").top == pytest.approx(own)
    last = HINGE.change("twist", "1 rad/pitch")
    assert charts.frame(last, "torque") == charts.frame(HINGE, "torque")
    assert live.motion(last.setting).state(last.twist).torque > 2 * charts.frame(last, "torque").top
    assert charts.point(last, "torque")[1] == 0
    # what is kept and bounded does: it can be read
    stiff = PLA.change("material", "steel")
    assert charts.frame(stiff.keep()._replace(beam=PLA.beam), "torque").top > 1.5 * own
    # inclinations are bounded, and drawn where they are
    ends = charts.frame(HINGE, "theta")
    assert ends.low < math.degrees(PLA.beam.scale.theta0) < live.along(HINGE.setting).theta.max() < ends.top
    narrow = charts.frame(PLA, "theta")
    assert narrow.top - narrow.low == pytest.approx(charts.FLAT)


def test_a_loop_goes_up_and_back() -> None:
    for now in (
        PLA.change("path", "cycle"),
        HINGE.change("path", "cycle"),
        PLA.change("path", "cycle").change("sense", "-"),
    ):
        m = live.motion(now.setting)
        sign = "-" if now.sense == "-" else ""
        c = squama.cycle(
            now.beam, f"{sign}{now.twist} rad/pitch", joint=m.joint, ideal=now.setting.ideal, points=70, ends="endless"
        )
        back = live.back(now)
        assert back
        down = c.isel(point=c.leg.values == 2)
        at = 0.8 * now.twist
        assert np.interp(at, back.load[::-1], back.torque[::-1]) == pytest.approx(
            np.interp(at, np.abs(down.phi.values[::-1]), np.abs(down["T"].values[::-1])), rel=1e-4
        )
        # it begins where the way up ended
        up = live.along(now.setting)
        # tolerance: straight lines between points, 3e-4 measured, on every processor
        assert (back.load[0], back.torque[0]) == pytest.approx(
            (now.twist, np.interp(now.twist, up.load, up.torque)), rel=1e-3
        )
        assert dict(live.readings(now))["dissipated"] == live.quantity(float(c.W_d[0]), "J/m")
        assert named(now)["unloading"].y.shape == back.torque.shape
        assert charts.frame(now, "f").low <= back.f.min() + 1e-12
        assert (back.f.min() < 0) == m.engaged, "friction has turned round"
        assert state.read(state.query(now)) == now
        rows = [row for row in live.make_file(now, "csv")[1].decode().splitlines() if row[0] != "#"]
        assert "leg (1)" in rows[0].split(",")
        json.dumps([charts.line_options(now, plot, dark=True) for plot in charts.PLOTS], allow_nan=False)
    # as far as the curve goes
    far = PLA.change("path", "cycle").change("twist", "1 rad/pitch")
    assert live.back(far).load[0] == pytest.approx(live.motion(far.setting).last)
    assert live.loop(PLA.change("path", "cycle").change("twist", "0")) == "nothing moves"


@pytest.mark.slow
def test_a_decay_is_that_of_vibrate_picture_by_picture() -> None:
    bent = HINGE.change("load", "bending")
    for one in (PLA, HINGE, PLA.change("sense", "-"), bent):
        now = one.change("path", "decay")
        m, played, sided = live.motion(now.setting), live.swing(now), now.load == "twisting"
        release = f"{'-' if now.sense == '-' else ''}{now.twist} rad/pitch"
        endless, ideal = now.beam.replace(scales=None), now.setting.ideal
        v = squama.vibrate(endless, release=release, rotor=1, load=now.load, joint=m.joint, ideal=ideal)
        angle = v.phi if sided else v.psi
        every = np.arange(len(played.frames)) * played.step / live.PERIOD
        wanted = np.interp(every, v.t.values * float(v.f_0), angle.values)
        shown = [frame["design"]["sense"] * frame["state"]["load"] for frame in played.frames]
        assert shown == pytest.approx(wanted.tolist(), abs=1e-12)
        assert every[-1] * live.PERIOD + played.step > float(v.t[-1] * v.f_0) * live.PERIOD
        first, opened = played.frames[0]["state"], min(played.frames, key=lambda f: f["state"]["load"])["state"]
        assert (opened["load"] < 0) == (not sided)
        assert first["theta"] == pytest.approx(m.state(now.twist).theta)
        assert opened["name"] == "free"
        assert all(frame["state"]["x"] == 0 for frame in played.frames)
        assert f"{float(v.zeta_cycle[0]):.3g} in the first" in played.words
        assert state.read(state.query(now)) == now
        # small enough to be sent at once
        assert len(json.dumps(played.frames, allow_nan=False)) < 250_000
    with pytest.raises(InputError, match="nothing moves"):
        live.swing(HINGE.change("twist", "0"))


def test_a_decay_is_coloured_by_contact_and_tells_what_vibrate_warns_of() -> None:
    # its way goes beyond 0.3 rad per pitch, where curves end, in the sense in which nothing touches
    skin = squama.Beam.from_toml("examples/stiff_skin.toml").replace(scales=None)
    now = state.of(skin).change("path", "decay").change("twist", "0.3 rad/pitch")
    m, played = live.motion(now.setting), live.swing(now)
    frames = [(f["design"]["sense"] * f["state"]["load"], f["state"]["name"]) for f in played.frames]
    assert min(load for load, _ in frames) < -0.3
    assert frames == [(load, "sliding" if load > m.load_e else "free") for load, _ in frames]
    v = squama.vibrate(now.beam, release="0.3 rad/pitch", rotor=1)
    assert v.attrs["warnings"], "what is to be told"
    for line in v.attrs["warnings"].splitlines():
        assert line in live.warnings(now) or f"Warning: {line}" in played.words.splitlines()
    assert all(line.startswith("Warning: ") for line in played.words.splitlines()[1:])


def test_a_loop_that_is_refused_is_told(monkeypatch) -> None:
    def refused(*_: object) -> None:
        raise InputError("the scales do not slide back")

    # only plates whose other contacts are left out come there
    monkeypatch.setattr(live, "history", refused)
    held = HINGE.change("path", "cycle")
    assert live.back(held) is None
    assert "no unloading is shown: the scales do not slide back" in live.warnings(held)
    assert "unloading" not in named(held)
    with pytest.raises(InputError, match="do not slide back"):
        live.make_file(held, "csv")


@pytest.mark.parametrize("name", list(MATERIALS))
def test_a_material_gives_its_values(name: str) -> None:
    now = PLA.change("material", name)
    assert material(now.beam.scale) == name
    assert now.beam == PLA.beam.replace(scale=made_of(name))
    assert state.read(state.query(now)) == now
    assert ("rigid" if name == "rigid" else "elastic") in live.motion(now.setting).model
    assert material(now.change("scale_modulus", "7").beam.scale) == "other"
    with pytest.raises(InputError, match="material"):
        PLA.change("material", "cheese")


def test_a_measured_table_is_laid_beside_the_curve() -> None:
    found = tables.opened("measured loop.csv", LOOP, HINGE)
    assert isinstance(found, tables.Table)
    assert (found.name, found.points.rate.size) == ("measured_loop.csv", 259)
    load, torque = tables.shown(found, HINGE)
    assert np.allclose(load, found.points.rate * 0.02)
    assert np.allclose(torque, found.points.load)
    assert named(HINGE, table=found)[found.name].points
    # none of its points is of the other sense, or of another load
    assert tables.shown(found, HINGE.change("sense", "-"))[0].max(initial=0) == 0
    assert tables.shown(found, HINGE.change("load", "bending"))[0].size == 0
    assert tables.residual(found, HINGE.change("load", "bending")) is None
    # the axes are those of the points, whatever the curve does
    for now in (HINGE, PLA):
        ends = charts.frame(now, "torque", found)
        assert ends.right == pytest.approx(1.03 * load.max())
        assert torque.max() < ends.top < 1.1 * torque.max()
        assert ends.low <= torque.min()
    # an arrow to a point that is beyond them, on the page and in print
    for now, arrow in (
        (PLA.change("twist", "0.3 rad/pitch"), charts.RIGHT),
        (PLA.change("twist", "0.1 rad/pitch"), ""),
    ):
        assert (now.twist > charts.frame(now, "torque", found).right) == bool(arrow)
        for plot in charts.PLOTS:
            at = charts.point(now, plot, found)
            assert at.arrow == arrow
            assert (at.left == 1) == bool(arrow)
        drawn = prints.figure(now, found)
        points = [ax.lines[-1] for ax in list(drawn.axes)[:3]]
        assert [one.get_marker() for one in points] == [prints.MARKS[arrow]] * 3
    high = charts.point(HINGE.change("twist", "9 rad/pitch"), "torque")
    assert (high.top, high.arrow) == (0, charts.UP)
    for plot in (*charts.PLOTS, charts.RESIDUAL):
        json.dumps(charts.line_options(HINGE, plot, dark=False, table=found), allow_nan=False)


def test_what_is_guessed_of_a_table_is_said() -> None:
    found = tables.opened("loop.csv", b"Phi (rad/m);T (N m)\n0;0\n1,5;0,02\n2,5;0,04\n", PLA)
    assert found.points.rate.tolist() == [0, 1.5, 2.5]
    assert found.said.startswith("loop.csv is read ")


@pytest.mark.parametrize("sense", ["+", "-"])
@pytest.mark.parametrize("start", [PLA, HINGE])
def test_the_residual_is_measured_less_computed_on_every_way(start: state.State, sense: str) -> None:
    now = start.change("sense", sense)._replace(twist=0.1)
    joint = live.motion(now.setting).joint
    sign = "-" if sense == "-" else ""
    ways = [f"{sign}{phi} rad/pitch" for phi in (0.12, 0.05, 0.13)]
    c = squama.cycle(
        now.beam, ["0 rad/pitch", *ways, "0 rad/pitch"], joint=joint, ideal=now.setting.ideal, points=40, ends="endless"
    )
    added = 0.01
    rows = [f"{x},{y + added}" for x, y in zip(c.Phi.values.tolist(), c["T"].values.tolist(), strict=True)]
    found = tables.opened("loop.csv", "\n".join(["Phi (rad/m), T (N m)", *rows]).encode(), now)
    left = tables.residual(found, now)
    assert left.torque.size > 0.6 * c.sizes["point"]
    # tolerance: straight lines between 40 points, 0.1 % measured, on every processor
    assert np.allclose(left.torque, -added if sense == "-" else added, atol=2e-3 * np.abs(c["T"].values).max() / 4)
    assert left.words.startswith("residual rms ")
    assert left.words.endswith(", against the endless beam's curve")


@pytest.mark.slow
def test_a_fit_is_the_packages_own() -> None:
    table = tables.opened("loop.csv", LOOP, HINGE)
    found = tables.fitted(table, HINGE)
    own = squama.fit("examples/measured_loop.csv", HINGE.beam, joint="hinge")
    assert found.beam == own.beam
    assert list(found.lines) == own.summary().splitlines()
    assert [name for name, _, _ in found.values] == list(own.parameters)
    assert list(found.doubts) == [*own.doubts, *filter(None, [own.disagreement])]
    assert (found.model, found.specimen) == (own.scales, own.fitted_as)
    now = HINGE._replace(beam=found.beam)
    before, after = (tables.residual(table, one) for one in (HINGE, now))
    assert np.sum(after.torque**2) < np.sum(before.torque**2) / 2
    # the loop that was fitted, as long as its beam is shown
    loop = named(now, table=table, fit=found)["fitted loop (endless beam)"]
    covered = np.isfinite(own.fitted)
    assert np.allclose(loop.y, own.fitted[covered], rtol=1e-12)
    assert np.allclose(loop.x, table.points.rate[covered] * 0.02, rtol=1e-12)
    left = tables.residual(table, now, found)
    assert np.allclose(left.torque, own.residuals[np.isfinite(own.residuals)], rtol=1e-12)
    assert not any("fitted loop" in name for name in named(HINGE, table=table, fit=found))
    json.dumps([charts.line_options(now, plot, dark=False, table=table, fit=found)
                for plot in (*charts.PLOTS, charts.RESIDUAL)], allow_nan=False)  # fmt: skip
    few = tables.opened("few.csv", b"Phi (rad/m), T (N m)\n0,0\n1,0.001\n", HINGE)
    with pytest.raises(InputError, match="usable points"):
        tables.fitted(few, HINGE)


def test_a_fit_has_the_specimens_own_scales_and_ends(monkeypatch) -> None:
    """What is asked of the fit is the beam of the page, with its number of scales and its ends."""
    asked: list[tuple] = []
    monkeypatch.setattr(tables.pickle, "dumps", lambda request: asked.append(request) or b".")
    few = tables.opened("few.csv", b"Phi (rad/m), T (N m)\n0,0\n1,0.001\n", PLA)
    held = PLA.change("scales", "9")
    held = held._replace(beam=held.beam.replace(ends="gripped"))
    with pytest.raises(InputError, match="no fit is found"):
        tables.fitted(few, held)
    ((_, beam, _),) = asked
    assert (beam.scales, beam.ends) == (9, "gripped")


def test_columns_and_decimals_are_chosen_by_hand() -> None:
    content = b"a;b;c\n0;9;0\n90;9;1,5\n180;9;3,5\n"
    for how in (tables.How("1=total (deg), 3=T (N mm)", ","), tables.How("a=total (deg), c=T (N mm)")):
        found = tables.opened("x.csv", content, PLA, how)
        assert found.points.load.tolist() == pytest.approx([0, 1.5e-3, 3.5e-3])
        assert found.points.rate[1] == pytest.approx(math.radians(90) / (25 * 0.02))
    with pytest.raises(InputError, match=r"x\.csv"):
        tables.opened("x.csv", content, PLA, tables.How("7=T (N mm)"))
    with pytest.raises(InputError, match="does not name columns"):
        tables.opened("x.csv", content, PLA, tables.How("=" * 200))


def test_a_fit_is_given_up_in_time(monkeypatch) -> None:
    monkeypatch.setattr(tables, "SECONDS", 0.01)
    with pytest.raises(InputError, match=re.escape("no fit is found within 0.01 s")):
        tables.fitted(tables.opened("loop.csv", LOOP, HINGE), HINGE)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("beam.toml", b"", "beam.toml: is empty"),
        ("beam.toml", b"x" * 70_000, "beam.toml: is larger than 64 KiB"),
        ("loop.csv", b"1,2\n" * 200_000, "loop.csv: is larger than 512 KiB"),
        ("beam.toml", b"[scale\n", "beam.toml: line 1"),
        ("beam.toml", b"a = " + b"[" * 60_000, "beam.toml"),
        ("beam.toml", b"\xff\xfe\x00", "beam.toml: is a binary file"),
        ("../../etc/passwd", b"root:x:0:0\n", "passwd"),
        ("", b"\n\n", "table.csv"),
        ("picture.png", b"\x89PNG\r\n\x1a\n\0\0", "picture.png: is a binary file"),
        (
            "loop.csv",
            b"Phi, T\n1,2\n",
            "has no unit; write a header like: Phi (rad/m), T (N m); or give its unit with columns",
        ),
        ("loop.csv", b"Phi (rad/m), T (N m)\n1,x\n", "loop.csv: line 2"),
    ],
)
def test_files_that_cannot_be_used_say_why(name: str, content: bytes, words: str) -> None:
    with pytest.raises(InputError) as error:
        tables.opened(name, content, PLA)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
    assert "/" not in str(error.value).split(":")[0]


def test_a_beam_file_is_opened_and_names_no_other() -> None:
    text = PLA.beam.replace(scale={"alpha": "50 deg"}).to_toml()
    found = tables.opened("my beam.toml", text.encode(), PLA.keep())
    assert math.degrees(found.beam.scale.alpha) == pytest.approx(50)
    assert len(found.kept) == 1
    named_file = f'{text}\n[joint]\nmatrix = "/etc/passwd"\n'
    with pytest.raises(InputError, match="names a file"):
        tables.opened("my beam.toml", named_file.encode(), PLA)


def test_designs_are_told_by_what_differs() -> None:
    def told(now: state.State) -> list[str]:
        return [row["what"] for row in live.compared(now)]

    assert told(PLA) == ["μ = 0.25, η = 3, α = 60 deg"]
    assert told(PLA.keep().change("theta0", "18")) == ["θ₀ = 15 deg", "θ₀ = 18 deg"]
    assert told(PLA.keep().change("twist", "0.1 rad/pitch")) == ["μ = 0.25, η = 3, α = 60 deg"] * 2
    bent = PLA.change("bend", "60")
    assert told(PLA.keep()._replace(bend=bent.bend)) == ["Nψ = 0 deg", "Nψ = 60 deg"]
    shorter = bent.change("scales", "5")
    assert told(PLA.keep()._replace(bend=bent.bend, beam=shorter.beam)) == [
        "ψ = 0 deg per pitch, N = 25",
        "ψ = 2.4 deg per pitch, N = 5",
    ]
    assert told(PLA.keep().change("eta", "3.001").change("mu", "0.3")) == ["μ = 0.25, η = 3", "μ = 0.3, η = 3.001"]
    assert told(PLA.keep().change("length", "50 mm")) == ["η = 3", "η = 2.5"]
    assert told(PLA.keep().change("pitch", "25")) == ["d = 20 mm", "d = 25 mm"]
    assert told(PLA.keep().change("zeta", "0.35")) == ["ζ = 0.3", "ζ = 0.35"]
    assert told(PLA.keep().change("slenderness", "8")) == ["tₛ = 0.8 mm", "tₛ = 0.75 mm"]
    assert told(PLA.keep().change("sense", "-")) == [
        "μ = 0.25, η = 3, α = 60 deg, sense +",
        "μ = 0.25, η = 3, α = 60 deg, sense -",
    ]
    assert told(PLA.keep().change("stiffness", "0.02")) == ["K_θ = not given", "K_θ = 0.02 N m"]
    # in print, too, whatever it is
    now = PLA.keep()
    for name, text in (("theta0", "18"), ("bar_width", "50"), ("scales", "20"), ("modulus", "2"), ("poisson", "0.4"),
                       ("scale_modulus", "4"), ("scale_poisson", "0.3"), ("scale_strength", "60"), ("zeta", "0.35"),
                       ("slenderness", "8"), ("beta", "0.7"), ("lam", "0.5"), ("stiffness", "0.02"), ("margin", "0.02"),
                       ("strength", "3"), ("strain_limit", "2"), ("inclusion", "1.1")):  # fmt: skip
        now = now.change(name, text)
    drawn = prints.figure(now.change("mu", "0.4").change("alpha", "55"))
    drawn.draw_without_rendering()
    assert drawn.legends[0].get_window_extent().x1 <= drawn.bbox.x1
    words = " ".join(t.get_text() for t in drawn.legends[0].get_texts())
    assert "θ₀ = 18 deg" in words
    assert "tₛ = " in words


def test_plots_are_printed_with_what_they_show() -> None:
    now = PLA.change("mu", "0.5").keep().change("mu", "0.25").change("path", "cycle")
    table = tables.opened("loop.csv", LOOP, now)
    drawn = prints.figure(now, table)
    assert drawn.get_figwidth() == pytest.approx(7.2)
    assert len(drawn.axes) == 4
    names = [t.get_text() for t in drawn.legends[0].get_texts()]
    assert names[0] == "μ = 0.25; thick, elastic scales on compliant joints"
    assert names[1] == "A: μ = 0.5; thick, elastic scales on compliant joints"
    assert {"without contact", "on hinges", "unloading", "loop.csv"} < set(names)
    # nothing is cut off, and the legend is beside the plots
    drawn.draw_without_rendering()
    sheet = drawn.bbox
    for ax in drawn.axes:
        box = ax.get_tightbbox()
        assert box.x0 >= 0
        assert box.x1 <= sheet.x1 + 1
        assert not box.overlaps(drawn.legends[0].get_window_extent())
    assert drawn.legends[0].get_window_extent().x1 <= sheet.x1
    ends = charts.frame(now, "torque", table)
    assert drawn.axes[0].get_xlim() == pytest.approx((0, 25 * math.degrees(ends.right)))
    assert drawn.axes[0].get_xlabel() == "Twist over 25 scales Nφ (deg)"
    # of beams with different numbers of scales, or none, a pitch is what they have in common
    assert charts.axes(PLA.keep().change("scales", "9"), "f", ends)[0].label == "Twist φ (deg per pitch)"
    for kind, start in (("svg", b"<?xml"), ("png", b"\x89PNG")):
        name, content = prints.made(now, None, kind)
        assert name == f"plots.{kind}"
        assert content.startswith(start)
    assert THEMES["light"]["curve"].encode() in prints.made(now, None, "svg")[1]
