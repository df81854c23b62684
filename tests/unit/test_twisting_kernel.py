"""One source, many number types: the kernel on floats, arrays, complex step, mpmath and compiled code."""

from __future__ import annotations

import ast
import inspect
import math
from typing import Any

import numpy as np
import pytest

from oracle.twisting import contact as oracle_contact
from oracle.twisting import forces as oracle_forces
from oracle.twisting import phi as oracle_phi
from oracle.vectors import MP, Design, dot, scale
from squama.model import laws, twisting

DESIGNS = [
    # eta, alpha, beta, lam, theta0 in deg; theta in deg; branch (1: beyond the fold)
    ((3, 45, 1.25, 0.45, 10), 50, 0),
    ((3, 45, 1.25, 0.45, 0.1), 0.1, 0),
    ((6.5, 70, 0.4, 0.9, 5), 84, 0),
    ((1.3, 22, 1.8, 0.25, 12), 95, 0),
    ((2, 89, 0.7, 0.5, 3), 40, 0),
    ((3, 5, 1.25, 0.45, 10), 20, 0),
    ((3, 5, 1.25, 0.45, 10), 28, 1),
]


def kernel(theta: Any, d: Design, branch: int = 0, ctx: Any = math) -> tuple[Any, twisting.Root, twisting.Contact]:
    """Ratios, root and contact of a design, executed with the numbers of `ctx`."""
    ratios = (d.sense * ctx.sin(d.alpha), ctx.cos(d.alpha), d.eta, d.beta, d.lam)
    r = twisting.root(ctx.sin(theta), ctx.cos(theta), *ratios)
    q = ctx.sqrt(r.q2)
    return ratios, r, twisting.contact(r, -q if branch else q, *ratios)


def state(theta: Any, d: Design, branch: int = 0, ctx: Any = math) -> dict[str, Any]:
    """Everything the kernel and the two laws give, rates per unit of theta."""
    _, _, c = kernel(theta, d, branch, ctx)
    out = {"phi": 2 * ctx.atan(c.u), "p": c.p, "s": c.s, "dphi": c.phi_rate / c.theta_rate}
    out |= {"da": c.a_rate / c.theta_rate, "dc": c.c_rate / c.theta_rate}
    for name, law in laws.LAWS.items():
        m = law(c, d.eta, ctx.sqrt)
        out |= {f"{name} {k}": v for k, v in m._asdict().items()}
    return out


def close(got: Any, want: Any, tol: float) -> bool:
    return bool(abs(got - want) <= tol * max(1, abs(want)))


@pytest.mark.parametrize(("numbers", "degrees", "branch"), DESIGNS)
def test_mpmath_shows_that_the_algebra_is_exact(numbers: tuple[float, ...], degrees: float, branch: int) -> None:
    d, theta = Design.of(*numbers), MP.mpf(str(degrees)) * MP.pi / 180
    got = state(theta, d, branch, MP)
    phi = oracle_phi(theta, d, branch)
    assert close(got["phi"], phi, 1e-26)
    for law in laws.LAWS:
        c = oracle_contact(theta, phi, d, law)
        want = {"p": c.p, "s": c.s, "dphi": c.dphi_dtheta, "da": c.da_dtheta, "dc": c.dc_dtheta}
        assert all(close(got[k], v, 1e-25) for k, v in want.items())
        _, _, k = kernel(theta, d, branch, MP)
        assert close(got[f"{law} slip_rate"] / abs(k.theta_rate), c.dr_dtheta, 1e-25)
        mu = MP.mpf("0.4")
        f = oracle_forces(theta, phi, d, law, mu)
        lift = theta - d.theta0
        drive = -(got[f"{law} M_N"] + mu * got[f"{law} M_f"])
        assert close(lift * d.eta, f.N0 * drive, 1e-25)
        assert close(-got[f"{law} M_N"] / got[f"{law} M_f"], f.mu_lock, 1e-25)


@pytest.mark.parametrize(("numbers", "degrees", "branch"), DESIGNS)
def test_cosines_and_slip_are_those_of_the_vectors(numbers: tuple[float, ...], degrees: float, branch: int) -> None:
    d, theta = Design.of(*numbers), MP.mpf(str(degrees)) * MP.pi / 180
    _, _, c = kernel(theta, d, branch, MP)
    phi = 2 * MP.atan(c.u)
    one, two = scale(MP, d, theta, phi, 0), scale(MP, d, theta, phi, 1)
    assert close(c.lift_x, -d.eta * c.k_ZX, 1e-27)
    assert close(c.lift_y, c.s * dot(one.y, two.z), 1e-27)
    for name in ("k_YY", "k_ZX", "k_ZY", "k_ZZ"):
        first, second = (getattr(s, axis.lower()) for s, axis in ((one, name[2]), (two, name[3])))
        assert close(getattr(c, name), dot(first, second), 1e-27)
    k_YX = dot(one.y, two.x)
    assert close(c.per_J2 * (1 - k_YX**2), MP.mpf(1), 1e-26)
    assert close(c.slip_x, c.a_rate + k_YX * c.c_rate, 1e-26)
    assert close(c.slip_y, c.c_rate + k_YX * c.a_rate, 1e-26)


@pytest.mark.parametrize(("numbers", "degrees", "branch"), DESIGNS)
def test_floats_keep_their_digits(numbers: tuple[float, ...], degrees: float, branch: int) -> None:
    d, theta = Design.of(*numbers).floats(), math.radians(degrees)
    exact = Design(*(MP.mpf(v) for v in (d.eta, d.alpha, d.beta, d.lam, d.theta0)))
    got, want = state(theta, d, branch), state(MP.mpf(theta), exact, branch, MP)
    for name, value in want.items():
        # the moments lose what the lever arms cancel
        tol = 1e-12 if abs(value) > 1e-6 else 1e-10
        assert abs(got[name] - value) <= tol * abs(value) + 1e-14, name


@pytest.mark.parametrize("sense", [1, -1])
def test_arrays_give_the_floats(sense: int) -> None:
    theta = np.radians([12.0, 20.0, 33.0, 47.0])
    columns = [np.array(v) for v in ([4.0, 3.5, 3.0, 6.0], [1.0, 0.5, 0.3, 1.1], [0.5, 0.6, 0.4, 0.3])]
    alpha = np.radians([50.0, 60.0, 30.0, 8.0])
    d = Design(columns[0], alpha, columns[1], columns[2], None, sense)
    with np.errstate(invalid="ignore"):
        got = state(theta, d, 0, np)
    assert np.isfinite(got["phi"]).tolist() == [True, True, True, False]
    for i in range(3):
        one = Design(*(float(c[i]) for c in (columns[0], alpha, *columns[1:])), 0.1, sense)
        for name, value in state(float(theta[i]), one).items():
            assert got[name][i] == pytest.approx(value, rel=1e-13, abs=1e-14), name


@pytest.mark.parametrize(("numbers", "degrees", "branch"), DESIGNS)
def test_rates_against_complex_step_and_central_differences(
    numbers: tuple[float, ...], degrees: float, branch: int
) -> None:
    d, theta = Design.of(*numbers).floats(), math.radians(degrees)
    here = state(theta, d, branch)
    step = {k: np.imag(v) / 1e-30 for k, v in state(theta + 1e-30j, d, branch, np).items()}
    h = 1e-5 * theta
    up, down = state(theta + h, d, branch), state(theta - h, d, branch)
    for name, rate, sign in (("phi", "dphi", 1), ("s", "da", -1), ("p", "dc", 1)):
        assert step[name] == pytest.approx(sign * here[rate], rel=1e-12, abs=1e-14)
        assert (up[name] - down[name]) / (2 * h) == pytest.approx(sign * here[rate], rel=2e-6, abs=2e-7)
    for name in ("edge M_N", "edge M_f", "plate M_N", "plate M_f", "plate slip_rate"):
        difference = (up[name] - down[name]) / (2 * h)
        assert step[name] == pytest.approx(difference, rel=2e-6, abs=2e-7), name


def test_numba_compiles_the_same_source() -> None:
    numba = pytest.importorskip("numba")
    sqrt = math.sqrt
    root, contact = numba.njit(twisting.root), numba.njit(twisting.contact)
    plate, edge = numba.njit(laws.plate), numba.njit(laws.edge)

    @numba.njit
    def compiled(sn, cs, sa, ca, eta, beta, lam, sign):
        r = root(sn, cs, sa, ca, eta, beta, lam)
        c = contact(r, sign * sqrt(r.q2), sa, ca, eta, beta, lam)
        return r, c, plate(c, eta, sqrt), edge(c, eta, np.sqrt)

    for numbers, degrees, branch in DESIGNS:
        d, theta = Design.of(*numbers).floats(), math.radians(degrees)
        ratios, r, c = kernel(theta, d, branch)
        want = (*r, *c, *laws.plate(c, d.eta, math.sqrt), *laws.edge(c, d.eta, math.sqrt))
        parts = compiled(math.sin(theta), math.cos(theta), *ratios, -1.0 if branch else 1.0)
        got = [v for part in parts for v in part]
        np.testing.assert_allclose(got, want, rtol=1e-13)


@pytest.mark.parametrize("module", [twisting, laws])
def test_only_arithmetic_and_sqrt(module: Any) -> None:
    """The functions hold + - * / and calls of sqrt and of the result's type: nothing else."""
    tree = ast.parse(inspect.getsource(module))
    names = {n.name for n in tree.body if isinstance(n, ast.ClassDef)}
    # "moments" only looks a law up by its name
    functions = [n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name != "moments"]
    assert len(functions) == 2
    for function in functions:
        for node in (n for statement in function.body for n in ast.walk(statement)):
            if isinstance(node, ast.Call):
                assert isinstance(node.func, ast.Name)
                assert node.func.id in names | {"sqrt"}
            elif isinstance(node, ast.BinOp):
                assert isinstance(node.op, ast.Add | ast.Sub | ast.Mult | ast.Div)
            elif isinstance(node, ast.UnaryOp):
                assert isinstance(node.op, ast.USub)
            else:
                plain = (ast.Assign, ast.Return, ast.Expr, ast.Name, ast.Constant, ast.Attribute, ast.Tuple)
                assert isinstance(node, (*plain, ast.operator, ast.unaryop, ast.expr_context)), ast.dump(node)
    imports = [n for n in ast.walk(tree) if isinstance(n, ast.Import | ast.ImportFrom)]
    assert {n.module for n in imports} <= {"__future__", "collections.abc", "typing", "squama.model.twisting"}


def test_there_are_about_125_operations() -> None:
    count = sum(isinstance(n, ast.BinOp | ast.UnaryOp) for n in ast.walk(ast.parse(inspect.getsource(twisting))))
    assert count < 200
