"""Measured tables in the explorer: opened, read by hand, fitted, taken away."""

from __future__ import annotations

import pytest

import squama
from squama.web import state

HINGED = "?" + state.query(state.preset("pla").hinged.started())


def test_a_table_is_opened_and_fitted(visit) -> None:
    page = visit(HINGED)
    file = page.page.locator("input[type=file]")
    file.set_input_files("examples/measured_loop.csv")
    page.page.locator(".measured", has_text="residual rms").wait_for()
    page.until_chart(3, "options.series[0].data.length > 200")
    page.page.locator("[data-do=fit]").click()
    # the page is alive meanwhile
    page.enter("twist", "0.1 rad/pitch")
    page.until("Math.abs(squamaView.state.load - 0.1) < 1e-9")
    page.page.locator(".measured dd").first.wait_for()
    page.until_chart(0, "options.series.some((s) => s.name === 'fitted loop (endless beam)' && s.data.length > 200)")
    assert "mu, " in page.page.locator(".measured dl").inner_text()
    own = squama.fit("examples/measured_loop.csv", squama.Beam.from_toml("examples/pla_on_vps.toml"), joint="hinge")
    page.eventually(lambda: float(page.number("mu").input_value()), pytest.approx(own.values["mu"], rel=1e-4))
    page.shot("fitted")
    page.page.locator("[data-do=unmeasured]").click()
    page.page.locator(".measured").wait_for(state="hidden")


@pytest.mark.slow
def test_a_beam_is_opened_and_what_is_none_refused(visit, tmp_path) -> None:
    page = visit(HINGED)
    file = page.page.locator("input[type=file]")
    beam = tmp_path / "other.toml"
    beam.write_text(squama.Beam.from_toml("examples/pla_on_vps.toml").replace(scale={"length": "50 mm"}).to_toml())
    file.set_input_files(str(beam))
    page.until("Math.abs(squamaView.design.eta - 2.5) < 1e-9")
    notice = page.page.locator(".notice.shown")
    for content, words in ((b"x" * 600_000, "larger than 512 KiB"), (b"[scale]\nlength = 1\n", "bad.toml")):
        bad = tmp_path / "bad.toml"
        bad.write_bytes(content)
        file.set_input_files(str(bad))
        notice.filter(has_text=words).wait_for()
        assert page.state()["eta"] == pytest.approx(2.5)
    file.set_input_files("examples/cantilever.toml")
    notice.filter(has_text="the beam alone is shown, without [support], [[load]], [along]").wait_for()
    assert page.state()["eta"] == pytest.approx(3.5)


@pytest.mark.slow
def test_a_table_that_cannot_be_read_is_read_by_hand(visit, tmp_path) -> None:
    page = visit(HINGED)
    odd = tmp_path / "odd.csv"
    odd.write_text("a;b;c\n0;9;0\n20;9;15\n40;9;33\n")
    page.page.locator("input[type=file]").set_input_files(str(odd))
    page.page.locator(".notice.shown", has_text="odd.csv").wait_for()
    panel = page.page.locator(".measured")
    panel.get_by_text("not read: choose columns and decimals").wait_for()
    columns = page.page.locator("[data-do=columns]")
    columns.fill("1=total (deg), 3=T (N mm)")
    columns.press("Enter")
    panel.get_by_text("of 3 points").wait_for()
    assert columns.input_value() == "1=total (deg), 3=T (N mm)"
    page.until_chart(0, "options.series.some((s) => s.name === 'odd.csv' && s.data.length === 3)")
    # the axes are those of the points
    page.until_chart(0, "options.xAxis[0].max < 43")
    page.shot("by_hand")
    # ends are those that the beam may have
    ends = panel.locator("select").nth(1)
    assert ends.locator("option").all_inner_texts() == ["free", "under a couple", "gripped"]
    ends.select_option("couple")
    page.until("location.search.includes('beam.ends=couple')")
    page.page.locator("header select").select_option("main")
    page.eventually(lambda: ends.locator("option").all_inner_texts(), ["endless"])
    # what is typed and not entered yet is not written over as the page is drawn anew
    columns.evaluate("field => field.value = 'half'")
    page.enter("mu", "0.35")
    page.until("location.search.includes('friction.mu=0.35')")
    assert columns.input_value() == "half"
    columns.fill("9=T (N mm)")
    columns.press("Enter")
    page.page.locator(".notice.shown", has_text="odd.csv").wait_for()
    # what was read before is not taken for it
    panel.get_by_text("not read: choose columns and decimals").wait_for()
    page.until_chart(0, "!options.series.some((s) => s.name === 'odd.csv')")
    page.page.locator("[data-do=unmeasured]").click()
    panel.wait_for(state="hidden")
