"""Bending modes of N scales: each cell carries the moment of the mode's inertia forces and has a bend of its own."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import squama
from squama.contacts import row
from squama.contacts.system import PSI
from squama.contacts.ties import LOOSE, freed, of_mode
from squama.curves import compliant
from squama.dynamics import joint_branches
from squama.dynamics.modes import SHAPES
from squama.loads import LOADS

FINGER = squama.Beam.from_toml("examples/finger.toml").replace(scales=8)
MODE = {"load": "bending", "density": 1150, "swings": 1}
FAR = 0.14


def loaded(mode, mu, beam=FINGER):
    one = compliant.Path.of(beam, mu, ("bend",), ideal=False)
    return joint_branches.LoadedBeam(one, LOADS["bending"], 1, "free", mode)


def test_equal_moments_are_those_of_free_ends():
    way, at = loaded("uniform", 0.25).one.way, np.linspace(0.02, FAR, 8)
    ends = row.track(way, 8, at, ends=LOOSE, load=PSI)
    mode = row.tied(way, 8, row.legs(at, PSI), of_mode(PSI, np.ones(8)), freed(way.beams.free, PSI))
    np.testing.assert_allclose(mode.cells, ends.cells, atol=1e-9)


@pytest.mark.parametrize("mode", ["cantilever", "simply supported"])
def test_cells_carry_the_moments_of_the_mode(mode):
    beam = loaded(mode, 0.25)
    track = beam._track(np.array([0.05, FAR]))
    psi, moment = track.cells[..., PSI], track.cells[..., 4 + PSI]
    shape = beam.shape
    np.testing.assert_allclose(
        moment / moment.max(axis=1, keepdims=True), np.tile(shape / shape.max(), (2, 1)), atol=1e-9
    )
    np.testing.assert_allclose(psi @ shape / (shape @ shape), [0.05, FAR], rtol=1e-9)
    # before contact each is bent in proportion to it; behind it not
    np.testing.assert_allclose(psi[0], 0.05 * shape, rtol=1e-6)
    assert np.abs(psi[1] / shape / FAR - 1).max() > 0.05


@pytest.mark.parametrize("mode", ["cantilever", "simply supported"])
def test_without_friction_the_load_is_the_slope_of_the_energy(mode):
    x = np.linspace(0.06, FAR, 200)
    q, stored, end = loaded(mode, 0.0).walk(x)
    assert not end
    assert q[-1] > 0.05 * FAR
    work = np.concatenate([[0.0], np.cumsum((q[1:] + q[:-1]) / 2 * np.diff(x))])
    # tolerance: the trapezoidal rule across engagement
    np.testing.assert_allclose(stored - stored[0], work, atol=1e-3 * stored[-1])


def test_the_door_tells_the_mode_and_the_endless_beam_on_request():
    for mode in ("cantilever", "simply supported"):
        own, endless = (
            squama.vibrate(FINGER, mode=mode, release="0.14 rad/pitch", ends=ends, **MODE) for ends in (None, "endless")
        )
        assert own.attrs["ends"] == mode
        assert "ends" not in endless.attrs
        # a few scales bear less than cells of an endless beam; scales touch by the mean bend of two cells
        assert float(own.psi_e) > float(endless.psi_e) * (1 - 1e-9)
        assert float(endless.period[0]) < float(own.period[0]) < 1 / float(own.f_0)
        assert 0 < float(own.zeta_cycle[0]) < float(endless.zeta_cycle[0])
        # what friction takes is what the peaks lose
        assert float(own.U_turn[0]) > float(own.U_turn[2])


def test_long_beams_engage_where_the_endless_beam_does():
    long = FINGER.replace(scales=60)
    own, endless = (
        squama.vibrate(long, mode="simply supported", release="0.08 rad/pitch", ends=e, **MODE)
        for e in (None, "endless")
    )
    # two equal cells in the middle
    assert float(own.psi_e) == pytest.approx(float(endless.psi_e), rel=1e-6)
    assert float(own.zeta_cycle[0]) == pytest.approx(float(endless.zeta_cycle[0]), rel=0.2)


def test_a_mode_of_moments_has_the_period_of_the_beam_with_all_its_masses():
    """Cells of a bilinear law, M = kappa up to 1 and four times as steep beyond, small deflections."""
    n, mode, peak = 8, SHAPES["cantilever"], 1.5
    h, steep = 1 / n, 4.0
    x, ends, chi = (np.arange(n) + 0.5) * h, np.arange(1, n + 1) * h, mode.of_cells(n)

    def moment(k):
        return np.where(k > 1, 1 + steep * (k - 1), k)

    def bend(m):
        return np.where(m > 1, 1 + (m - 1) / steep, m)

    lever = np.maximum(ends[:, None] - x, 0.0) * h
    mass = np.full(n, h)
    mass[-1] = h / 2
    inverse = np.linalg.inv(lever.T @ (mass[:, None] * lever)) * h
    bare = 2 * math.pi / math.sqrt(np.sort(np.linalg.eigvals(inverse).real)[0])
    start = bend(float(moment(peak)) * chi / chi[0])

    def rates(_, y):
        return np.concatenate([y[n:], -inverse @ moment(y[:n])])

    whole = solve_ivp(rates, (0, 2.2 * bare), np.append(start, 0 * start), rtol=1e-6, atol=1e-9, dense_output=True)
    t = np.linspace(0, 2.2 * bare, 20001)
    tip = (lever @ whole.sol(t)[:n])[-1]
    up = t[1:][(tip[:-1] < 0) & (tip[1:] >= 0)]

    def period(force, top):
        y = np.linspace(0, top, 2001)
        q = np.array([force(v) for v in y])
        V = np.concatenate([[0.0], np.cumsum((q[1:] + q[:-1]) / 2 * np.diff(y))])
        a = np.linspace(0, math.pi / 2, 2001)[:-1]
        speed = np.sqrt(2 * (V[-1] - np.interp(top * np.sin(a), y, V)))
        return (2 * np.trapezoid(top * np.cos(a) / speed, a) / math.pi + 1) / 2 * bare

    def of_moments(a):
        return brentq(lambda load: chi @ bend(load * chi) / (chi @ chi) - a, 0, 1e3)

    found = period(of_moments, chi @ start / (chi @ chi))
    bent = period(lambda a: chi @ moment(a * chi) / (chi @ chi), tip[0] / (lever @ chi)[-1])
    true = float(np.diff(up).mean())
    assert true < 0.95 * bare
    assert found == pytest.approx(true, rel=0.01)
    # the bends of the linear mode are too stiff a shape
    assert bent < 0.99 * true
