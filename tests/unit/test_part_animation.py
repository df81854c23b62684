"""The animation of a part under load."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

import squama
from squama import plot
from squama.cli import main

BEAM = "examples/cantilever.toml"


@pytest.mark.slow
def test_the_part_moves_from_frame_to_frame(tmp_path: Path) -> None:
    data = squama.load(squama.Part.from_toml(BEAM), points=6)
    path = plot.part_animation(data, tmp_path / "part.gif", frames=4)
    with Image.open(path) as gif:
        frames = [np.asarray(frame.convert("L"), float) for frame in ImageSequence.Iterator(gif)]
    assert len(frames) == 4
    for one, next_one in itertools.pairwise(frames):
        assert (abs(one - next_one) > 60).sum() > 500
    # the panels stand still: all that changes is inside the axes
    still = abs(frames[0] - frames[-1]) < 60
    assert still[:40].all()
    assert still[:, :80].all()


@pytest.mark.slow
def test_the_command_writes_it_and_refuses_other_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["load", BEAM, "--points", "5", "--gif", str(tmp_path / "p.gif")]) == 0
    assert (tmp_path / "p.gif").stat().st_size > 10_000
    assert main(["load", BEAM, "--gif", str(tmp_path / "p.png")]) == 2
    assert ".gif" in capsys.readouterr().err
    data = squama.load(squama.Part.from_toml(BEAM), points=3)
    with pytest.raises(squama.InputError, match=r"write a name that ends in \.gif"):
        plot.part_animation(data, tmp_path / "p.mp4")
    twisted = squama.twist(squama.Beam.from_toml(BEAM), ends="endless", points=5)
    with pytest.raises(squama.InputError, match=r"no result of squama\.load"):
        plot.part_animation(twisted, tmp_path / "t.gif")
