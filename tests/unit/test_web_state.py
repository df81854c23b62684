"""The explorer without a browser: fields, states, links, numbers of the page, map, files."""

from __future__ import annotations

import asyncio
import json
import math
import re
import threading
import tomllib
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import squama
from squama.batch import entry
from squama.beam.parts import RATIOS
from squama.cli import main
from squama.errors import InputError
from squama.paper import parameters
from squama.people import turned
from squama.web import charts, fields, live, map, server, state  # noqa: A004
from squama.web.aside import Aside
from squama.web.fields import CHOICES, FIELDS

# tolerances: fields and charts have six digits, what is read two or three
START = state.preset("main")
IN_RANGE = {name: st.floats(f.low, f.high).map(lambda x: f"{x:.4g}") for name, f in FIELDS.items() if not f.whole}


def test_presets_are_the_papers_beams_and_the_example() -> None:
    assert START.beam.replace(friction={"mu": None}) == parameters.main()
    assert state.preset("fig6b2").beam.eta == pytest.approx(2)
    assert state.preset("pla").beam == squama.Beam.from_toml("examples/pla_on_vps.toml")
    with pytest.raises(InputError, match="preset"):
        state.preset("x")
    for name in state.PRESETS:
        one = state.preset(name)
        assert 0 < one.twist < live.motion(one.setting).last


@pytest.mark.parametrize("name", [n for n, f in FIELDS.items() if f.place in RATIOS])
def test_a_ratio_changes_its_dimension_and_nothing_else(name: str) -> None:
    before = START.value(name)
    changed = START.change(name, f"{0.8 * before:.17g}")
    assert changed.value(name) == pytest.approx(0.8 * before, rel=1e-13)
    assert changed.beam.pitch == START.beam.pitch
    flat = [
        {f"{t}.{k}": v for t, part in s.beam.model_dump().items() if isinstance(part, dict) for k, v in part.items()}
        for s in (START, changed)
    ]
    assert len([key for key in flat[0] if flat[0][key] != flat[1][key]]) == 1
    # and the dimension gives the ratio back
    size = {"eta": "length", "beta": "width", "zeta": "embedded", "slenderness": "thickness", "lam": "bar_thickness"}[
        name
    ]
    again = START.change(size, FIELDS[size].shown(changed.value(size)))
    assert again.value(name) == pytest.approx(changed.value(name), rel=1e-5)


def test_what_is_shown_in_a_field_is_read_back() -> None:
    for name, field in FIELDS.items():
        value = START.value(name)
        text = fields.of(name, START.beam).shown(value)
        if not field.optional:
            assert START.change(name, text).value(name) == pytest.approx(value, rel=1e-5)
    assert START.change("length", "6 cm").value("length") == pytest.approx(0.06)
    assert START.change("twist", "90 deg total").twist == pytest.approx(math.pi / 2 / 25)
    assert START.change("twist", "20 deg/pitch").twist == pytest.approx(math.radians(20))


@pytest.mark.parametrize(("scales", "many", "unit"), [(None, 1, "deg per pitch"), (25, 25, "deg")])
def test_a_twist_and_a_bend_are_entered_in_degrees_of_the_whole_beam_and_linked_in_radians(scales, many, unit) -> None:
    now = START._replace(beam=START.beam.replace(scales=scales))
    for text in ("12", "12 deg", "12°"):
        assert now.change("twist", text).twist == pytest.approx(math.radians(12) / many)
    assert now.change("bend", "-6").bend == pytest.approx(-math.radians(6) / many)
    assert now.change("twist", "0.2 rad").twist == pytest.approx(0.2 / many)
    for name, largest in (("twist", 573), ("bend", 57.3)):
        assert fields.of(name, now.beam).unit == unit
        # the bounds are those of a pitch
        with pytest.raises(InputError, match=f"is out of range .* to {float(f'{largest * many:.3g}'):.0f}.* {unit}"):
            now.change(name, f"{1.01 * largest * many:g}")
    # links that were written before show what they did
    found = state.read(re.sub(r"twist=[\d.]+", "twist=0.21", state.query(now)) + "&bend=-0.05")
    assert (found.twist, found.bend) == (0.21, -0.05)
    assert START.change("stiffness", "20 N mm").beam.joint.stiffness == pytest.approx(0.02)
    assert START.change("stiffness", "3").change("stiffness", "").beam.joint.stiffness is None


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("eta", "0", "more than 0"),
        ("eta", "", "not a plain number"),
        ("length", "5 deg", "a length is needed"),
        ("embedded", "700", "goes through the substrate"),
        ("scales", "2.5", "whole number"),
        ("mu", "-1", "0 to 10"),
        ("margin", "1", "below 1"),
        ("alpha", "95", "below 90 deg"),
        ("poisson", "0.5", "-1 to 0.5"),
        ("stiffness", "0", "more than 0"),
        ("twist", "-0.1", "0 to 573 deg per pitch"),
        ("twist", "20 m", "is a length, but a twist rate is needed"),
        ("pitch", "0,5", 'write "0.5"'),
        ("width", "nan", "not a length"),
        ("modulus", "<b>1</b>", "not a pressure"),
        ("law", "other", "edge"),
        ("load", "pull", "twisting"),
    ],
)
def test_what_cannot_be_used_is_one_line_with_what_is_allowed(name: str, text: str, words: str) -> None:
    with pytest.raises(InputError, match=rf"^.*{re.escape(words)}.*\Z"):
        START.change(name, text)


@pytest.mark.slow
@given(st.sampled_from(sorted(IN_RANGE)), st.data())
def test_every_place_of_a_slider_is_shown_or_explained(name: str, data: st.DataObject) -> None:
    text = data.draw(IN_RANGE[name])
    try:
        shown = live.scene(now := START.change(name, text))["state"]
    except InputError as error:
        # what two fields can be at odds about
        if any(words in str(error) for words in ("tab goes through", "softer than its joint", "is beyond the beam's")):
            return
        raise
    assert all(math.isfinite(shown[key]) for key in ("load", "theta", "N", "f", "torque", "x"))
    json.dumps([charts.line_options(now, plot, dark=False) for plot in charts.PLOTS], allow_nan=False)
    assert state.read(state.query(now)) == now


def test_compliant_joints_are_shown_by_default_and_named() -> None:
    now = state.preset("pla")
    m = live.motion(now.setting)
    assert now.quick
    assert (m.joint, m.model) == ("compliant", "thick, elastic scales on compliant joints")
    # behind a second contact, too
    assert m.end == "range end"
    assert "other contact: " in live.outcome(now)[1]
    r = squama.twist(now.beam, at=[f"{m.last} rad/pitch"], ends="endless")
    assert m.curve["torque"][-1] == pytest.approx(r["T"].item(), rel=1e-6)
    words = dict(live.readings(now))
    at = squama.twist(now.beam, at=[f"{now.twist} rad/pitch"], ends="endless")
    ratio = re.search(r"free until 46\.9 deg .*, ([\d.]+) times as stiff as the bar at 301 deg", live.verdict(now))
    assert float(ratio[1]) == pytest.approx(at.stiffness_ratio.item(), rel=0.02)
    assert float(words["stress"].split()[0]) == pytest.approx(at.stress.item() / 1e6, rel=1e-2)
    where = live.outcome(now.change("scale_modulus", "300"))[1]
    twice = squama.twist(now.beam.replace(scale={"youngs_modulus": "300 GPa"}), ends="endless").phi_twofold.item()
    assert f"twice as stiff as the bar from {turned(twice, now.beam)}" in where
    rows = [row.split(",") for row in live.make_file(now, "csv")[1].decode().splitlines() if not row.startswith("#")]
    assert float(rows[-1][rows[0].index("phi (rad)")]) == pytest.approx(m.last)


def test_choices_that_belong_together_go_together() -> None:
    now = state.preset("pla")
    thin = now.change("ideal", "yes")
    assert live.motion(thin.setting).model == "thin, rigid scales on compliant joints"
    hinge = now.change("joint", "hinge")
    assert (hinge.ideal, live.motion(hinge.setting).model) == ("yes", "thin, rigid scales on hinges, edge law")
    assert live.motion(hinge.change("ideal", "no").setting).model == "thick, rigid scales on hinges, edge law"
    plate = now.change("law", "plate")
    assert (plate.joint, live.motion(plate.setting).model) == ("hinge", "thin, rigid scales on hinges, plate law")
    back = plate.change("joint", "compliant")
    assert (back.law, back.ideal) == ("edge", "no")
    for one in (now, thin, hinge, hinge.change("ideal", "no"), plate):
        assert state.read(state.query(one)) == one
    # links from before the scales' idealisation
    assert state.read(state.query(hinge).replace("&ideal=yes", "")) == hinge
    assert state.read(state.query(now).replace("&ideal=no", "")) == now
    bent = now.change("load", "bending")
    assert live.motion(bent.setting).joint == "compliant"
    for other in (bent.change("path", "decay"), bent.change("joint", "hinge").change("ideal", "no")):
        assert live.motion(other.setting).model == "thin, rigid scales on hinges"


def test_a_joint_that_is_not_known_at_once_is_not_waited_for(monkeypatch) -> None:
    # steeper than the law of the joint goes
    far = START.change("theta0", "36").change("joint", "compliant")
    assert not far.quick
    assert far.hinged.quick
    assert far.change("theta0", "29").quick
    assert not far.change("load", "bending").quick

    def elements(_: object) -> None:
        raise AssertionError

    monkeypatch.setattr("squama.joints.choice._found", elements)
    assert live.linked(state.query(far)) == far
    assert state.of(far.beam).twist == far.hinged.started().twist
    # where nobody knows it the beam is on hinges, and that is told
    monkeypatch.setattr("squama.joints.choice.impossible", lambda _: "there are no elements")
    m = live.motion(far._replace(margin=0.02).setting)
    assert (m.joint, m.model) == ("hinge", "thin, rigid scales on hinges, edge law")
    assert "there are no elements" in live.warnings(far._replace(margin=0.02))


def test_designs_are_kept_shown_and_dropped() -> None:
    now = START
    for eta in ("2", "2.5", "3.5"):
        now = now.change("eta", eta).keep()
    assert [round(one.beam.eta, 6) for one in now.kept] == [2, 2.5, 3.5]
    with pytest.raises(InputError, match="kept already"):
        now.keep()
    with pytest.raises(InputError, match="3 designs are kept"):
        now.change("eta", "4").keep()
    assert now.show(0).beam.eta == pytest.approx(2)
    assert now.show(0).kept == now.kept
    assert [round(one.beam.eta, 6) for one in now.drop(1).kept] == [2, 3.5]
    assert state.read(state.query(now)) == now
    rows = live.compared(now.drop(2))
    assert [row["name"] for row in rows] == ["A", "B", "now"]
    r = squama.twist(now.kept[0].beam, mu=0.5, joint="hinge")
    assert (rows[0]["end"], rows[0]["RED"]) == (r.end.item(), f"{r.RED_c.item():.4g}")


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("scale.length=5", "has no unit"),
        ("x=1", "not known"),
        ("load=twisting", "is missing"),
        ("keep=a%3D1&" * 4, "at most 3"),
        ("a" * 30_000, "longer than"),
        (state.query(START).replace("law=edge", "law=x"), "law"),
        (re.sub(r"twist=[\d.]+", "twist=-1", state.query(START)), "0 to 573 deg per pitch"),
        (state.query(START) + "&keep=x%3D1", "not known"),
        (state.query(START) + "&joint.matrix=%2Fetc%2Fpasswd", 'joint.matrix = "/etc/passwd": names a file'),
        (state.query(START) + "&joint.matrix=", 'joint.matrix = "": names a file'),
        (state.query(START) + "&mu=1" * 64, "more than 64 values"),
    ],
)
def test_a_link_that_cannot_be_used_says_why(query: str, words: str) -> None:
    with pytest.raises(InputError, match=re.escape(words)):
        state.read(query)


@pytest.mark.parametrize("name", ["main", "pla"])
@pytest.mark.parametrize("law", ["edge", "plate"])
def test_the_plots_are_the_answers_curves(name: str, law: str) -> None:
    now = state.preset(name).hinged.started().change("law", law)
    r = squama.twist(now.beam, law=law, points=live.POINTS, joint="hinge")
    for plot, variable, unit in (("torque", r["T"], 1.0), ("theta", np.degrees(r.theta), 1.0), ("f", r.f, 1.0)):
        options = charts.line_options(now, plot, dark=False)
        own = next(s for s in options["series"] if s["name"] == charts.OWN)
        x, y = np.array(own["data"]).T
        factor = y[-1] / variable.values[-1]
        assert np.log10(factor) == pytest.approx(round(np.log10(factor)), abs=1e-4)
        degrees = np.degrees(now.beam.scales or 1)
        assert np.allclose(x, degrees * r.phi, rtol=1e-5, atol=1e-9)
        assert np.allclose(y, unit * factor * variable.values, rtol=1e-5, atol=1e-9 * abs(y).max())
        # the current point lies on the curve
        left, top, _ = charts.point(now, plot)
        assert left * options["xAxis"]["max"] == pytest.approx(degrees * now.twist, rel=1e-5)
        low, high = (options["yAxis"][end] for end in ("min", "max"))
        assert low + (1 - top) * (high - low) == pytest.approx(np.interp(degrees * now.twist, x, y), rel=2e-3)
        assert 0 < top < 1
    for twist in ("0", "0.05 rad/pitch", "0.14 rad/pitch", "9 rad/pitch"):
        for plot in charts.PLOTS:
            assert all(0 <= at <= 1 for at in charts.point(now.change("twist", twist), plot)[:2])


def test_bending_is_a_mode_of_its_own() -> None:
    now = START.change("load", "bending")
    assert live.outcome(now)[0] == squama.bend(now.beam, joint="hinge").end.item()
    words = dict(live.readings(now))
    assert "Moment M" in words
    assert live.scene(now)["design"]["height"] == now.beam.lam
    both = now.keep().change("load", "twisting")
    assert len(both.kept) == 1
    names = [s["name"] for s in charts.line_options(both, "torque", dark=True)["series"]]
    assert "A" not in names, "a bent beam has no place among twisted ones"
    assert live.warnings(now) == now.beam.warnings("bending")


def test_the_outcome_is_told_in_words() -> None:
    end, where, sentence = live.outcome(START)
    assert (end, where) == ("frictional lock", "at 15.4 deg per pitch")
    assert live.verdict(START) == "Endless beam: free until 2.76 deg per pitch, locks at 15.4 deg per pitch"
    assert live.readings(START)[0] == ("Twist", "10.7 deg per pitch")
    long = START.change("scales", "25")
    free, locks = "free until 69 deg (2.76 deg per pitch)", "locks at 385 deg (15.4 deg per pitch)"
    assert live.verdict(long) == f"Endless beam: {free}, {locks}"
    assert live.readings(long)[0] == ("Twist", "268 deg (10.7 deg per pitch) over 25 scales")
    assert sentence.startswith("Friction holds")
    assert "Shown at its last state, 15.3 deg per pitch" in live.outcome(START.change("twist", "1 rad/pitch"))[2]
    never = START.change("eta", "0.5").change("beta", "0.2")
    assert live.outcome(never)[0] == "no engagement"
    assert live.verdict(never) == "Endless beam: the scales never touch; twisted, it is as soft as its bar"
    assert live.compared(never)[0]["engagement"] == "never"


@pytest.mark.parametrize(
    ("load", "x", "y"), [("twisting", "mu", "alpha"), ("twisting", "beta", "lam"), ("bending", "mu", "eta")]
)
def test_a_cell_of_the_map_is_that_design(load: str, x: str, y: str) -> None:
    now = START.change("load", load)
    found = map.grid(map.key(now, x, y))
    for i, j in ((3, 27), (20, 16), (35, 5)):
        design = map.take(now, x, y, (i, j))
        assert design.value(x) / FIELDS[x].factor == pytest.approx(found.x[i], rel=1e-5)
        assert design.value(y) / FIELDS[y].factor == pytest.approx(found.y[j], rel=1e-5)
        b = design.beam
        if load == "twisting":
            e = squama.ends(**b.ratios, mu=design.mu)
            assert map.CODES[found.code[j, i]] == e.end.item()
            assert found.load_end[j, i] == pytest.approx(e.phi_end.item(), rel=1e-4)
            if live.motion(design.setting).figures["other_contact"] == "":
                assert found.figure[j, i] == pytest.approx(
                    squama.twist(b, joint="hinge").RED_c.item(), rel=1e-3, abs=1e-12
                )
        else:
            assert map.CODES[found.code[j, i]] == squama.bend(b, joint="hinge").end.item()
    options = map.options(map.key(now, x, y), found, dark=False)
    cells = next(s for s in options["series"] if s["name"] == "end")["data"]
    assert len(cells) == found.x.size * found.y.size
    assert cells[found.x.size * 5 + 35][:3] == [35, 5, int(found.code[5, 35])]
    json.dumps(options, allow_nan=False)


def test_marks_lie_over_the_cells_of_their_designs() -> None:
    now = START.change("mu", "0.5").keep().change("mu", "2").change("alpha", "80")
    key = map.key(now, "mu", "alpha")
    kept, own = map.marks(now, key)
    assert (kept.letter, own.letter) == ("A", "")
    # the middle of the last column and of the highest row
    assert own.left == pytest.approx(1 - 0.5 / map.SIZE[0])
    assert own.top == pytest.approx(0.5 / map.SIZE[1])
    assert kept.left == pytest.approx((0.5 / 2 * (map.SIZE[0] - 1) + 0.5) / map.SIZE[0])
    assert len(map.marks(now.change("mu", "3"), key)) == 1, "off the map"


def test_the_map_is_computed_anew_only_where_it_must() -> None:
    key = map.key(START, "mu", "alpha")
    assert map.key(START.change("mu", "1").change("twist", "0.1 rad/pitch"), "mu", "alpha") == key
    assert map.key(START.change("law", "plate"), "mu", "alpha") != key
    assert map.key(START.change("eta", "2"), "mu", "alpha") != key
    with pytest.raises(InputError, match="choose two of"):
        map.check_axes("mu", "mu")


def test_the_map_is_warmed_up_behind_the_page(monkeypatch) -> None:
    filled, known = [], entry.fill

    def fill(*given):
        filled.append(threading.current_thread())
        return known(*given)

    fill.stats, fill.signatures, fill.py_func = known.stats, known.signatures, known.py_func
    monkeypatch.setattr(entry, "fill", fill)
    thread = map.warm_up()
    thread.join(60)
    assert filled == [thread]
    # one compiled function serves the map of any load
    before = len(known.signatures)
    for now in (START, START.change("load", "bending"), START.change("ideal", "no")):
        map.grid(map.key(now, "mu", "eta"))
    assert len(known.signatures) == before == 1
    assert thread.daemon, "closing the explorer does not wait for it"
    # the server starts it
    started: list[object] = []
    monkeypatch.setattr("nicegui.app.on_startup", started.append)
    monkeypatch.setattr("nicegui.ui.page", lambda *_, **__: lambda page: page)
    monkeypatch.setattr("nicegui.ui.run_with", lambda *_, **__: None)
    monkeypatch.setattr("uvicorn.Server.run", lambda _: None)
    server.serve(START, 1, browser=False, ready=print)
    assert map.warm_up in started


def test_work_beside_the_loop_is_bounded_in_time_and_number() -> None:
    let_go, running = threading.Event(), []

    def work(name: str) -> str:
        running.append(name)
        if name == "slow":
            let_go.wait(30)
        if name == "wrong":
            raise InputError(name)
        return name

    async def ask() -> None:
        aside = Aside(work, most=1, limit=30)
        assert await aside("quick") == "quick"
        with pytest.raises(InputError, match="wrong"):
            await aside("wrong")
        aside.limit = 0.5
        for name in ("slow", "behind"):
            with pytest.raises(TimeoutError):
                await aside(name)
        assert running == ["quick", "wrong", "slow"], "no more than one at a time, even if nobody waits for it"
        let_go.set()
        aside.limit = 30
        assert await aside("after") == "after"

    # a thread of its own: where a browser is open, this one has a loop already
    with ThreadPoolExecutor() as other:
        other.submit(asyncio.run, ask()).result()


def test_what_a_beam_refuses_is_told_by_the_fields_name() -> None:
    with pytest.raises(InputError) as error:
        START.change("embedded", "700")
    assert [problem.where for problem in error.value.problems] == ["Embedded length"]
    with pytest.raises(InputError) as error:
        START.change("eta", "0")
    assert str(error.value).startswith('Overlap ratio l/d = "0": is out of range')


def test_files_are_those_of_the_commands() -> None:
    now = START.change("law", "plate")
    name, content = live.make_file(now, "toml")
    assert name == "beam.toml"
    assert squama.Beam.from_toml_text(content.decode()) == now.beam
    assert tomllib.loads(content.decode())["friction"]["mu"] == 0.5
    _, table = live.make_file(now, "csv")
    r = squama.twist(now.beam, law="plate")
    last = [float(v) for v in table.decode().splitlines()[-1].split(",")[:2]]
    assert any(np.isclose(last[0], r[v].values[-1]) for v in ("phi", "Phi", "theta"))
    assert b"law" in table
    assert b"importmap" in live.make_file(now, "html")[1]
    assert "M (N m)" in live.make_file(now.change("load", "bending"), "csv")[1].decode()
    with pytest.raises(InputError, match="kind"):
        live.make_file(now, "pdf")


def test_bad_input_of_the_command_is_one_line(capsys, monkeypatch) -> None:
    import socket

    with socket.socket() as taken:
        taken.bind((server.HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["explore", "--no-browser", "--port", str(port)]) == 2
    assert main(["explore", "none.toml", "--port", "70000"]) == 2
    assert main(["explore", "--set", "scale.alpha=30 deg"]) == 2
    monkeypatch.setattr("squama.cli.short.find_spec", lambda _: None)
    assert main(["explore"]) == 2
    lines = [line.removeprefix("squama: error: ") for line in capsys.readouterr().err.splitlines()]
    assert [line.split(":")[0] for line in lines] == [
        f"--port {port}",
        '--port = "70000"',
        "none.toml",
        "--set",
        "squama explore needs NiceGUI; install it with",
    ]
    assert set(CHOICES) == {"load", "path", "law", "sense", "joint", "ideal"}
