"""What a summary on the hinge says of other contacts and of a beam that never engages; flags without effect."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import squama
from squama.cli import main, report
from squama.curves.doors import respond

HINGE = ["--joint", "hinge"]


@pytest.fixture
def beam(tmp_path, monkeypatch):
    """A beam that on the hinge does not engage in the other sense; other edges touch there."""
    monkeypatch.chdir(tmp_path)
    beam = squama.Beam.from_ratios(mu=0.5)
    beam.to_toml("beam.toml")
    return beam


def _out(capsys, *arguments):
    assert main(list(arguments)) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


def test_other_contact_of_both_laws_is_told_once(beam, capsys):
    text = _out(capsys, "twist", "beam.toml", *HINGE, "--sense=-", "--mu", "0,0.5", "--full")
    found = [line for line in text.splitlines() if line.startswith("other contact (")]
    assert found == ["other contact (mu = 0, 0.5): side edge A1B1 on base edge D2A2 (k = 1) at 22.2 deg per pitch"]
    # at mu = 0 it ends both curves, at .5 friction locks before
    text = _out(capsys, "twist", "beam.toml", *HINGE, "--mu", "0,0.5", "--full")
    found = [line for line in text.splitlines() if line.startswith("other contact (")]
    assert len(found) == 1
    assert found[0].startswith("other contact (mu = 0): tip edge")


def test_other_contact_of_one_law_is_told_with_it(beam):
    touching, locking = (respond(beam, "twisting", mu=mu, joint="hinge") for mu in (0.1, 0.5))
    (line,) = report._others(beam, {"edge": touching, "plate": locking})
    assert line.startswith("other contact (edge law, mu = 0.1): tip edge C1B1")
    (line,) = report._others(beam, {"edge": touching, "plate": touching})
    assert line.startswith("other contact (mu = 0.1): tip edge C1B1")
    assert report._others(beam, {"edge": locking, "plate": locking}) == []


@pytest.mark.parametrize("mu", ["0.5", "0,0.5"])
@pytest.mark.parametrize("settings", [[], ["--set", "scale.length=8 mm"]])
def test_without_engagement_there_is_no_end(settings, mu, beam, capsys):
    text = _out(capsys, "twist", "beam.toml", *HINGE, "--sense=-", *settings, "--mu", mu, "--full")
    if settings:
        beam = beam.replace(scale={"length": 0.008})
    r = squama.twist(beam, sense="-", mu=0.5, joint="hinge")
    assert r.end.item() == "no engagement"
    assert np.isinf([r.phi_end, r.Phi_end]).all()
    assert bool(np.isnan(r.phi_touch)) == bool(settings)
    # how far the curve is drawn is no end
    assert f"{float(r.Phi[-1]):.4g}" not in text
    assert f"{math.degrees(float(r.Phi[-1]) * beam.length):.4g}" not in text
    assert "90 deg per pitch" not in text
    flags = [*HINGE, "--sense=-", *settings, "--mu", mu.split(",")[-1], "--json"]
    record = json.loads(_out(capsys, "twist", "beam.toml", *flags))
    assert record["figures"]["phi_end"] == "inf"
    assert (record["figures"]["phi_touch"] is None) == bool(settings)


def test_the_name_of_a_file_is_no_markup(beam, capsys):
    beam.to_toml(":bee:[bold].toml")
    assert _out(capsys, "twist", ":bee:[bold].toml").startswith(":bee:[bold].toml: free until")


def test_measured_points_need_a_picture(beam, capsys):
    Path("test.csv").write_text("Phi (rad/m),T (N m)\n1,0.1\n")
    assert main(["twist", "beam.toml", "--data", "test.csv", "--json"]) == 0
    captured = capsys.readouterr()
    assert captured.err == "squama: warning: --data has no effect without --plot; add e.g. --plot picture.png\n"
    assert json.loads(captured.out)["mu"] == 0.5
    assert "--data" not in _out(capsys, "twist", "beam.toml", "--data", "test.csv", "--plot", "a.png")


def test_without_engagement_the_end_is_named_and_nothing_is_said_of_the_cut_off(beam, capsys):
    lines = _out(capsys, "twist", "beam.toml", *HINGE, "--sense=-", "--full").splitlines()
    assert next(line.split() for line in lines if line.startswith("end ")) == ["end", *["no", "engagement"] * 2]
    assert not any("cut-off" in line or "dissipation RED" in line for line in lines)
    lines = _out(capsys, "twist", "beam.toml", *HINGE, "--sense=-", "--mu", "0,0.5", "--compare").splitlines()
    row = ["0.5", "no", "engagement", "never", "-", "-", "-", "1", "-"]
    assert [line.split() for line in lines].count(row) == 3


def test_bending_says_which_line_keeps_its_length(beam, capsys):
    lines = _out(capsys, "bend", "beam.toml", "--joint", "hinge", "--full").splitlines()
    (model,) = [line for line in lines if line.startswith("  model ")]
    assert "thin, rigid scales on hinges; endless beam; " in model
    assert model.endswith("; the line in the middle of the bar keeps its length")
    assert any(line.startswith("  torque T that keeps it from twisting") for line in lines)
    assert "in the face of the bar" in _out(capsys, "bend", "beam.toml", "--neutral", "face")
    assert "is not in it" not in squama.bend(beam, joint="hinge").warnings
