"""Many designs, compiled, against each by Python: the same ends, 1e-9 relative; nothing but the design matters."""

from __future__ import annotations

import errno
import hashlib
import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba.core.caching import IndexDataCacheFile

import squama
from properties.designs import many
from squama import arguments
from squama.batch import Solved, keeping, solved
from squama.batch.answers import FEW, answers
from squama.model import figures

RECORDED = json.loads((Path(__file__).parents[1] / "reference" / "twisting.json").read_text(encoding="utf-8"))
FIGURES = ("load_e", "theta_end", "load_end", "theta_c", "load_c", "f0", "torque", "U_el", "W_fr", "RED")
ONE = {"eta": 3.0, "beta": 1.25, "lam": 0.45, "alpha": np.pi / 4, "theta0": np.radians(10), "mu": 0.5}


def designs(n: int, seed: int) -> dict[str, np.ndarray]:
    """Wide ranges, with the stiffness of the bar."""
    return many(n, seed) | {"stiffness_ratio": np.random.default_rng(seed).uniform(0, 2, n)}


def both(load: str = "twisting", law: str = "edge", sense: str = "+", margin: float = 0.01, **d: Any) -> list[Solved]:
    """Compiled answers and Python's."""
    names = ("eta", "beta", "lam", "alpha", "theta0", "mu", "stiffness_ratio")
    given = {"beta": 1.0, "lam": 1.0, "alpha": 0.5, "stiffness_ratio": 0.0} | d
    columns, shape = arguments.designs(**{name: given[name] for name in names})
    found = (solved(columns, law=law, sense=sense, margin=margin, load=load, few=few) for few in (-1, 10**9))
    return [Solved._make(v.reshape(shape) for v in one) for one in found]


def conditioning(theta0: Any, b: Solved, margin: float) -> Any:
    """Rounding errors of the end (300 times a few 1e-16) where a figure has its pole, over the margin."""
    return 1e-13 / (margin * np.maximum(np.abs(b.theta_end - theta0), 1e-12))


def agree(a: Solved, b: Solved, theta0: Any, margin: float) -> None:
    np.testing.assert_array_equal(a.code, b.code)
    np.testing.assert_array_equal(a.neighbour, b.neighbour)
    rtol = 1e-9 + conditioning(theta0, b, margin)
    for name in FIGURES:
        x, y = getattr(a, name), getattr(b, name)
        assert x.shape == y.shape
        assert x.dtype == y.dtype
        same = x == y
        with np.errstate(invalid="ignore"):
            # beyond a fold the spring comes to rest again: force and torque are zero there but for rounding
            close = np.abs(x - y) <= rtol * np.abs(y) + 1e-13
        assert (same | close).all(), (name, np.flatnonzero(~(same | close))[:5])


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("margin", [1e-1, 1e-2, 1e-4])
@pytest.mark.parametrize("sense", ["+", "-"])
@pytest.mark.parametrize("law", ["edge", "plate"])
def test_wide_ranges(law: str, sense: str, margin: float) -> None:
    d = designs(1000, 7)
    a, b = both(**d, law=law, sense=sense, margin=margin)
    agree(a, b, d["theta0"], margin)
    # every kind of end is there
    kinds = {"no engagement", "off tip edge", "frictional lock", "static lock", "other contact"}
    assert kinds <= set(b.end.tolist()) or sense == "-"


@pytest.mark.parametrize("law", ["edge", "plate"])
def test_recorded_designs(law: str) -> None:
    names = ("eta", "beta", "lam", "mu")
    d = {name: np.array([row[name] for row in RECORDED], float) for name in names}
    d |= {name: np.radians([row[f"{name}_deg"] for row in RECORDED]) for name in ("alpha", "theta0")}
    a, b = both(**d, law=law)
    agree(a, b, d["theta0"], 0.01)


@pytest.mark.parametrize(
    ("change", "end"),
    [
        ({}, "frictional lock"),
        ({"mu": 0.0}, "kinematic lock"),
        ({"mu": 9.0}, "static lock"),
        ({"beta": 0.01, "alpha": 0.05, "lam": 2.0}, "no engagement"),
        ({"alpha": np.radians(5), "mu": 0.1}, "off tip edge"),
        ({"eta": 3.641775, "beta": 2.659367, "lam": 1.065016, "alpha": 0.038242, "theta0": 0.523658}, "released"),
        # neighbour 4 comes in, and goes, well between two of the five samples of the quick look
        (
            {
                "eta": 1.53076017,
                "beta": 2.90128356,
                "lam": 0.05809257,
                "alpha": 0.71168567,
                "theta0": 0.55392178,
                "mu": 1.2,
            },
            "other contact",
        ),
        # the margin of friction dips below zero over .0004 rad, in the interval in which the path leaves the side edge
        (
            {
                "eta": 2.3969483286387416,
                "beta": 1.8611437475451507,
                "lam": 0.09395055504211196,
                "alpha": 0.4635137594494696,
                "theta0": 0.2355563565250404,
                "mu": 0.06505588684312158,
            },
            "frictional lock",
        ),
        # the margin of friction is below zero between two close samples, the second of which is the last before another
        # margin ends the path
        (
            {
                "eta": 4.151126347437024,
                "beta": 2.3458493931939057,
                "lam": 1.1189408937123626,
                "alpha": 0.266678145182986,
                "theta0": 0.27834934911067005,
                "mu": 0.06591067433762736,
            },
            "frictional lock",
        ),
        # many neighbours within reach
        ({"eta": 60.0}, None),
    ],
)
def test_single_designs(change: dict[str, float], end: str | None) -> None:
    d = ONE | change
    a, b = both(**d)
    agree(a, b, d["theta0"], 0.01)
    assert end is None or str(a.end) == end


@pytest.mark.parametrize(
    ("law", "design"),
    [
        (
            "edge",
            (
                3.452570707333269,
                1.9368477496868548,
                0.2529463174266702,
                0.08760309083839056,
                0.29224458450728935,
                1.2876723256122566,
            ),
        ),
        (
            "plate",
            (
                1.7977718642973473,
                1.8015225363532081,
                0.33187202006464434,
                0.0973140966083756,
                0.10641236701684233,
                1.053226765002182,
            ),
        ),
    ],
)
def test_work_that_no_rule_serves(law: str, design: tuple[float, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """The slip has a corner: the path is taken in parts."""
    taken, parts = [], figures.in_parts
    monkeypatch.setattr(figures, "in_parts", lambda *args: taken.append(1) or parts(*args))
    d = dict(zip(("eta", "beta", "lam", "alpha", "theta0", "mu"), design, strict=True))
    a, b = both(**d | {"alpha": math.asin(d["alpha"])}, law=law)
    assert taken == [1]
    agree(a, b, d["theta0"], 0.01)


@pytest.mark.parametrize("shape", [(), (0,), (1,), (3, 0), (5, 1, 2)])
def test_shapes(shape: tuple[int, ...]) -> None:
    mu = np.linspace(0, 1, int(np.prod(shape))).reshape(shape)
    a, b = both(**ONE | {"mu": mu})
    assert a.RED.shape == shape
    agree(a, b, ONE["theta0"], 0.01)


def test_bending() -> None:
    dice = np.random.default_rng(6)
    eta, theta0 = dice.uniform(0.5, 8, 1000), dice.uniform(0.001, 1.5, 1000)
    d = {"eta": eta, "theta0": theta0, "mu": dice.choice([0, 1, 9], 1000) * dice.uniform(0, 1, 1000)}
    a, b = both(**d, stiffness_ratio=0.3, load="bending")
    agree(a, b, theta0, 0.01)
    assert len(set(b.end.tolist())) > 3


@pytest.mark.parametrize("law", ["edge", "plate"])
def test_few_and_many_agree(law: str) -> None:
    """One public function, whichever way answers."""
    d = designs(2 * FEW, 12)
    many = squama.solve(**d, law=law)
    for part in (slice(0, FEW), slice(7, 9)):
        few = squama.solve(**{name: v[part] for name, v in d.items()}, law=law)
        agree(Solved._make(v[part] for v in many), few, d["theta0"][part], 0.01)


def test_neither_place_nor_company_nor_threads_matter() -> None:
    n = 20_011
    columns = tuple(designs(n, 3).values())
    common = {"law": "edge", "sense": "+", "margin": 0.01, "load": "twisting"}
    one = solved(columns, **common, threads=1)
    for x, y in zip(one, solved(columns, **common, threads=3), strict=True):
        np.testing.assert_array_equal(x, y)
    order = np.random.default_rng(1).permutation(n)[:9_001]
    some = solved(tuple(v[order] for v in columns), **common, threads=2)
    for name, x, y in zip(one._fields, one, some, strict=True):
        np.testing.assert_array_equal(x[order], y, err_msg=name)


def test_a_changed_kernel_is_compiled_anew() -> None:
    """The copy on the disk is known by a digest of all that is compiled, not of one file."""
    entry = import_module("squama.batch.entry")
    stamp = hashlib.sha256(b"".join(file.read_bytes() for file in entry.SOURCES)).hexdigest()
    # every function that is compiled comes from a file in the digest
    kernel = import_module("squama.batch.kernel")
    files = {Path(f.__code__.co_filename) for f in kernel._names.values() if hasattr(f, "__code__")}
    assert len(files) > 3
    assert files <= set(entry.SOURCES)
    # a copy from other sources is not even opened: it may name modules that are not there
    assert stamp[:16] in entry.fill.py_func.__qualname__


RUN = """
import numpy as np, squama
s = squama.solve(eta=3, beta=1.25, lam=0.45, alpha=0.8, theta0=0.2, mu=np.linspace(0, 1, 200))
print(s.end[100])
"""


ELEMENTS = """
import numpy as np
from squama.fe.elements import Elements, Material
nodes = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1],
                  [0, 1, 1]], float)
found = Elements(nodes, np.arange(10)[None], Material())(nodes)
print("at rest" if abs(found.forces).max() < 1e-12 else found)
"""


def run(folder: Path, code: str = RUN) -> subprocess.CompletedProcess[str]:
    """Run with that folder as the only one where Numba keeps code."""
    only = {"NUMBA_CACHE_DIR": str(folder), "NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator"}
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env={**os.environ, **only}
    )


@pytest.mark.slow
@pytest.mark.parametrize(("code", "said"), [(RUN, "frictional lock\n"), (ELEMENTS, "at rest\n")])
def test_no_folder_for_compiled_code_can_be_written(tmp_path: Path, code: str, said: str) -> None:
    """A file stands in the place of the folder; one line tells of the compilation, and that it recurs."""
    place = tmp_path / "file"
    place.write_text("")
    done = run(place, code)
    assert done.stdout == said
    assert done.stderr.count("\n") == 1
    assert "a minute or two in each run: no folder for its cache can be written" in done.stderr


@pytest.fixture
def double(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], Any]:
    """Return a maker of a compiled function whose copy is kept in a folder of the test."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(numba.config, "CACHE_LOCATOR_CLASSES", "UserProvidedCacheLocator")

    def make() -> Any:
        def f(x: float) -> float:
            return 2 * x

        return keeping.kept(f, [Path(__file__)])

    return make


def test_a_full_disk_under_the_cache_costs_one_line(
    double: Callable[[], Any], monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(IndexDataCacheFile, "_save_data", full)
    assert [double()(1.5), double()(2.5)] == [3.0, 5.0]
    (line,) = caplog.messages
    assert line.startswith(f"squama: {tmp_path}")
    assert line.endswith("the cache cannot be written (no space left on device); each run makes the compiled code anew")


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize("left", [0, 9, 200])
def test_a_damaged_copy_of_compiled_code_is_made_anew(
    double: Callable[[], Any], caplog: pytest.LogCaptureFixture, tmp_path: Path, ending: str, left: int
) -> None:
    assert double()(1.5) == 3.0
    (place,) = tmp_path.rglob(f"*.{ending}")
    place.write_bytes(place.read_bytes()[:left])
    again = double()
    assert again(2.5) == 5.0
    assert not again.stats.cache_hits
    # no fixed size: Numba numbers its functions, and numbers grow
    assert place.stat().st_size > left
    third = double()
    assert third(3.5) == 7.0
    assert third.stats.cache_hits
    assert not caplog.messages


@pytest.mark.slow
def test_compiled_code_is_kept(tmp_path: Path) -> None:
    first, again = run(tmp_path), run(tmp_path)
    assert first.stdout == again.stdout == "frictional lock\n"
    assert "compiling" in first.stderr
    assert again.stderr == ""


def test_a_mistake_in_a_thread_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = import_module("squama.batch.entry")

    def fill(*_: Any) -> None:
        message = "broken"
        raise ArithmeticError(message)

    monkeypatch.setattr(entry, "fill", fill)
    monkeypatch.setattr(import_module("squama.batch.keeping"), "tell", lambda *_: None)
    with pytest.raises(ArithmeticError, match="broken"):
        answers(tuple(designs(3000, 1).values())[:6], law="edge", sense="+", load="twisting", threads=2)
