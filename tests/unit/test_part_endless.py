"""A part beside the law of the endless beam at each place, and the frames of its sections."""

from __future__ import annotations

import numpy as np
import pytest

import squama
from squama.cli import main

FINGER = squama.Beam.from_toml("examples/finger.toml").replace(scales=8)


@pytest.mark.parametrize("mu", [0.0, 0.25])
def test_bent_alike_each_cell_has_the_moment_of_the_endless_beam(mu):
    """There and back: the law is of history, too."""
    r = squama.load(FINGER, "50 deg bend", support="simple", mu=mu, back=True, points=20)
    psi = r.turn.values / 8
    c = squama.cycle(
        FINGER, [f"{np.degrees(psi.max())} deg/pitch", "0 deg/pitch"], load="bending", mu=mu, ends="endless"
    )
    way = np.argmax(psi)
    up = c.M.values[: int(np.argmax(c.psi.values)) + 1]
    law = np.interp(psi[: way + 1], c.psi.values[: up.size], up)
    # tolerance: lines between the points of the cycle
    np.testing.assert_allclose(r.moment_periodic.values[: way + 1], law, atol=2e-3 * law.max())
    back = np.interp(psi[way:], c.psi.values[up.size - 1 :][::-1], c.M.values[up.size - 1 :][::-1])
    np.testing.assert_allclose(r.moment_periodic.values[way:], back, atol=2e-3 * law.max())
    # the end scales lack a neighbour
    assert float(r.moment.max()) < 0.98 * float(r.moment_periodic.max())


def test_before_contact_both_are_the_same_and_a_longer_part_is_nearer():
    shares = []
    for n in (6, 12, 24):
        r = squama.load(FINGER, f"{6 * n} deg bend", support="simple", scales=n, mu=0.0, points=30)
        # a cell alone touches where it is bent most, a scale and the next one by the mean of both
        before = r.share.values < 0.8 * float(r.share_e)
        assert before.sum() > 3
        np.testing.assert_allclose(r.moment[before], r.moment_periodic[before], atol=1e-9 * float(r.moment.max()))
        shares.append(float((r.moment / r.moment_periodic)[-1]))
    r = squama.load(FINGER, "14 mm up at tip", scales=6, mu=0.0, points=30)
    assert 0.3 < float((r.F / r.F_periodic)[-1]) < 0.7
    assert shares[0] < 0.95
    assert shares == sorted(shares)


def test_frames_turn_with_the_sections():
    r = squama.load(FINGER, "0.1 N up at tip", points=10)
    frame, place = r.frame.values, np.stack([r[f"{v}_axis"].values for v in "xyz"], axis=-1)
    assert r.frame.dims == ("point", "section", "axis", "direction")
    np.testing.assert_allclose(frame[:, 0], np.tile(np.eye(3), (11, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(frame @ frame.swapaxes(-1, -2), np.broadcast_to(np.eye(3), frame.shape), atol=1e-12)
    # a cell's chord lies halfway between its sections' own axes
    chord = np.diff(place[-1], axis=0)
    middle = frame[-1, :-1, :, 2] + frame[-1, 1:, :, 2]
    along = chord / np.linalg.norm(chord, axis=1, keepdims=True)
    np.testing.assert_allclose(along, middle / np.linalg.norm(middle, axis=1, keepdims=True), atol=2e-3)


def test_the_command_tells_it_with_all_figures_and_in_files(tmp_path, capsys):
    file = tmp_path / "finger.toml"
    FINGER.to_toml(file)
    given = ["load", str(file), "--load", "0.1 N up at tip", "--points", "20"]
    assert main(given) == 0
    assert "endless" not in capsys.readouterr().out
    assert main([*given, "--full"]) == 0
    assert "with the law of the endless beam at each place: 0." in capsys.readouterr().out
    assert main([*given, "--csv", str(tmp_path / "part.csv")]) == 0
    data = squama.read(tmp_path / "part.csv")
    assert np.isfinite(data.F_periodic).all()
    assert data.frame.shape == (21, 9, 3, 3)
