"""The torque of N scales over the endless beam's, solved for at one state: against rows that are followed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.campaigns import histories

import squama
from squama.contacts import own_scales, path
from squama.contacts.row import track
from squama.contacts.system import PHI
from squama.contacts.ties import LOOSE
from squama.errors import InputError

SKIN = squama.Beam.from_toml("examples/stiff_skin.toml")


@pytest.mark.parametrize(
    ("ends", "n", "off"), [("free", 5, 1e-3), ("free", 12, 1e-3), ("couple", 9, 1e-2), ("gripped", 12, 5e-3)]
)
def test_a_sweep_tells_what_its_rows_bear(tmp_path: Path, ends: str, n: int, off: float) -> None:
    beam = SKIN.replace(scales=n, ends=ends)
    data = squama.sweep(beam, {"mu": (0, 0.5, 2)}, at="0.09 rad/pitch", out=tmp_path / "s.zarr")
    words = {"couple": "under a couple at the ends"}.get(ends, f"with {ends} ends")
    assert data.attrs["finite"] == f"{n} scales {words}"
    for mu in (0, 0.5):
        row = squama.twist(beam, mu=mu, to="0.09 rad/pitch", points=120).isel(point=-1)
        cell = data.sel(mu=mu)
        assert float(cell.finite_ratio) == pytest.approx(float(row["T"] / row.T_periodic), rel=off)
        assert float(cell.finite_torque) == pytest.approx(float(row["T"]), rel=off)
        assert abs(float(cell.finite_ratio) - 1) > 0.02
        steps = squama.twist(beam, mu=mu, at=["0.088 rad/pitch", "0.09 rad/pitch"])
        tangent = float(np.diff(steps["T"])[0] / np.diff(steps.Phi)[0]) / steps.attrs["rigidity"]
        assert float(cell.finite_stiffness_ratio) == pytest.approx(tangent, rel=0.03)
        assert abs(float(cell.finite_stiffness_ratio / cell.stiffness_ratio) - 1) > 0.05


def test_bending_and_the_twist_of_a_bent_beam(tmp_path: Path) -> None:
    beam = SKIN.replace(scales=6)
    bent = squama.sweep(beam, {"mu": [0.25, 0.5]}, at="0.16 rad/pitch", load="bending", out=tmp_path / "b.zarr")
    row = squama.bend(beam, to="0.16 rad/pitch", points=80).isel(point=-1)
    assert float(bent.finite_torque[0]) == pytest.approx(float(row.M), rel=5e-3)
    held = squama.sweep(beam, {"psi": ["0.01 rad", "0.02 rad"]}, at="0.08 rad/pitch", out=tmp_path / "h.zarr")
    row = squama.bend_twist(beam, "bend 0.01 rad/pitch; twist 0.08 rad/pitch", points=80).isel(point=-1)
    assert float(held.finite_torque[0]) == pytest.approx(float(row["T"]), rel=5e-3)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("n", [6, 20])
def test_random_beams_bear_what_their_rows_do(n: int) -> None:
    off, unknown = [], 0
    for seed in range(24):
        given = histories.drawn(np.random.default_rng([5, seed]))
        way = path.Path.of(given.scale, given.K, given.mu, free=(1, 0, 1, 1))
        twists = np.linspace(0, 2 * way.engaged, 42)[1:]
        if not twists[-1] < 0.3:
            continue
        endless = path.follow_all(way.beams, twists[None], most=0.0, room=path.ROOM)
        ((ratio,), _) = own_scales.ratios(way.beams, endless, own_scales.Own(n), PHI)
        row = track(way, n, twists, ends=LOOSE)
        if not np.isfinite(ratio) or len(row.rows) < twists.size:
            unknown += 1
            continue
        torques = path.named(row.rows)["torque"][-1].mean(), path.named(endless.rows[0])["torque"][-1]
        off.append(abs(ratio * torques[1] / torques[0] - 1))
    assert len(off) >= 12
    assert unknown <= len(off) / 4
    assert max(off) < 0.05
    assert np.median(off) < 5e-3


def test_many_scales_are_as_stiff_as_the_endless_beam() -> None:
    """The end cells' share of the twist falls as 1/N."""
    ratios = [squama.response([0.05, 0.07, 0.09], **_ratios(), scales=n) for n in (12, 50, 200)]
    lost = [n * (1 - r.finite_ratio) for n, r in zip((12, 50, 200), ratios, strict=True)]
    assert 0.5 < ratios[0].finite_ratio < ratios[1].finite_ratio < ratios[2].finite_ratio < 1
    assert lost[2] == pytest.approx(lost[1], rel=0.15)
    assert ratios[2].finite_tangent == pytest.approx(1, abs=0.05)
    assert np.isnan(squama.response([0.05, 0.09], **_ratios()).finite_ratio)


def test_without_contact_all_beams_are_alike_and_one_scale_is_none() -> None:
    nothing = squama.response([0.001, 0.002], **_ratios(), scales=12)
    assert nothing.finite_ratio == 1
    with pytest.raises(InputError, match="scales"):
        squama.response([0.05], **_ratios(), scales=1)


@pytest.mark.slow
def test_a_study_of_tolerances_has_the_scatter_of_the_finite_beam() -> None:
    beam = SKIN.replace(scales=8)
    u = squama.uncertainty(beam, {"mu": "0.25 +- 0.1"}, at="0.09 rad/pitch", samples=3200)
    row = squama.twist(beam, to="0.09 rad/pitch", points=120).isel(point=-1)
    torque, ratio = u.nominal.sel(figure="finite_torque"), u.nominal.sel(figure="finite_ratio")
    assert float(torque) == pytest.approx(float(row["T"]), rel=2e-3)
    assert float(ratio) == pytest.approx(float(row["T"] / row.T_periodic), rel=2e-3)
    assert 0 < float(u.sd.sel(figure="finite_torque")) < 0.2 * float(torque)
    endless = squama.uncertainty(beam.replace(scales=None), {"mu": "0.25 +- 0.1"}, at="0.09 rad/pitch", samples=3200)
    assert "finite_torque" not in endless.figure.values


def _ratios() -> dict[str, Any]:
    return {
        "eta": 4, "beta": 0.5, "lam": 0.4, "zeta": 0.35, "alpha": np.radians(45), "theta0": np.radians(15),
        "thickness": 0.08, "width": 1.2, "nu": 0.48, "mu": 0.3, "modulus_ratio": 3e4,
    }  # fmt: skip
