"""Settings of hypothesis: the same examples in every run, no clock, no files left behind; what is tested, and first."""

import gc
from collections import Counter

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis.internal.conjecture import providers

settings.register_profile(
    "squama",
    derandomize=True,
    deadline=None,
    max_examples=60,
    print_blob=False,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("mutants", settings.get_profile("squama"), phases=(Phase.explicit, Phase.generate))
settings.load_profile("squama")
# numbers of the modules that happen to be loaded are no examples: they differ from process to process
providers.is_local_module_file = lambda _: False


@pytest.fixture(autouse=True, scope="session")
def compiled():
    """What commands say in the process of the tests does not depend on which code has been compiled before."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("squama.batch.keeping.is_ready", lambda _: True)
        yield


def pytest_collection_finish():
    """Keep modules and tests, which stay to the end, out of later collections of garbage."""
    gc.collect()
    gc.freeze()


LONG = ("test_docs.py", "test_paper_figures.py", "test_beam.py")
"""Files whose tests come first, behind pages in the browser."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Take the mark ``slow(but=n)`` from the first n cases of its test, and put the tests into their order.

    Pages in the browser come first, so that one process has them all and the others take work from its end.

    Pages of the docs follow, the longest of all tests: at the end one of them would keep a single process busy. So do
    files whose tests share what takes long: two processes that have some of them would each make it.
    """
    cases: Counter[str] = Counter()
    for item in items:
        mark = item.get_closest_marker("slow")
        if mark and cases[test := item.nodeid.partition("[")[0]] < mark.kwargs.get("but", 0):
            item.own_markers.remove(mark)
            cases[test] += 1
    items.sort(key=lambda item: ("web" not in item.path.parts, item.path.name not in LONG))
