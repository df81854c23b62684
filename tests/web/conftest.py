"""One server and one browser for the tests of the explorer, and what every page must hold to."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from web_raw import ROOT, explorer

SCREENS = ROOT / "out" / "screens"
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-gpu-rasterization"]
READY = """window.squamaView && squamaView.state && squamaView.contacts && location.search.length > 10
  && [0, 1, 2].every((i) => squamaTest.chart(i)?.getOption().series.length)"""
HELPERS = """window.squamaTest = {
  chart: (i) => getElement(Number(document.querySelectorAll('.chart')[i]?.id.slice(1)))?.chart,
  curve: (i) => squamaTest.chart(i).getOption().series.find((s) => s.name.startsWith('this design')).data }"""


def chromium() -> str:
    """Path of Chromium; a test that needs it is left out where it is missing."""
    found = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if found is None:
        pytest.skip("Chromium is missing; install it with: apt-get install chromium")
    return found


@pytest.fixture(scope="session")
def browser() -> Iterator:
    path = chromium()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        shown = play.chromium.launch(executable_path=path, args=FLAGS)
        yield shown
        shown.close()


@pytest.fixture(scope="session")
def address() -> Iterator[str]:
    chromium()
    with explorer() as (_, found):
        yield found


class Visit:
    """An open page with its complaints and its requests."""

    def __init__(self, context, address: str) -> None:
        self.context, self.address = context, address
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.page = context.new_page()
        self.page.add_init_script(HELPERS)
        self.page.set_default_timeout(60_000)
        self.page.on("console", lambda m: self.complaints.append(m.text) if m.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda r: self.requests.append(r.url))
        self.page.on("websocket", lambda socket: self.requests.append(socket.url))

    def open(self, query: str = "") -> Visit:
        # every visit is a browser of its own, that shows its secret first
        self.page.goto(self.address + query.replace("?", "&", 1))
        self.page.wait_for_function(READY)
        return self

    def state(self) -> dict:
        return self.page.evaluate("({...squamaView.state, ...squamaView.design})")

    def until(self, script: str) -> None:
        self.page.wait_for_function(script)

    def number(self, name: str):
        return self.page.locator(f'[data-number="{name}"]')

    def slider(self, name: str):
        return self.page.locator(f'[data-field="{name}"]')

    def enter(self, name: str, text: str) -> None:
        self.number(name).fill(text)
        self.number(name).press("Enter")

    def until_chart(self, i: int, what: str) -> None:
        """Wait until something holds with ``options``, those of the i-th plot."""
        script = f"const options = squamaTest.chart({i}).getOption(); return {what};"
        # what is not there yet is waited for, too
        self.until(f"(() => {{ try {{ {script} }} catch {{ return false; }} }})()")

    def eventually(self, see: Callable[[], object], wanted: object) -> None:
        """Wait until something seen is what is wanted: plots and fields follow the view, on a busy machine late."""
        last = time.monotonic() + 60
        while (seen := see()) != wanted and time.monotonic() < last:
            self.page.wait_for_timeout(50)
        assert seen == wanted

    def shot(self, name: str, *, full: bool = False) -> None:
        """Keep a picture of the page, to be looked at."""
        self.page.screenshot(path=self.place(name), full_page=full)

    def place(self, name: str) -> Path:
        SCREENS.mkdir(parents=True, exist_ok=True)
        return SCREENS / f"{name}.png"


@pytest.fixture
def visit(browser, address: str) -> Iterator[Callable[..., Visit]]:
    """Open pages; afterwards nothing may have been complained about, and nothing asked of another host."""
    opened: list[Visit] = []

    def start(query: str = "", **options) -> Visit:
        context = browser.new_context(
            **{"viewport": {"width": 1280, "height": 800}, "accept_downloads": True, **options}
        )
        opened.append(Visit(context, address))
        return opened[-1].open(query)

    yield start
    for one in opened:
        one.context.close()
    here = urlsplit(address).netloc
    for one in opened:
        assert one.complaints == []
        assert one.requests
        places = [urlsplit(url) for url in one.requests]
        assert {p.netloc for p in places if p.scheme not in ("data", "blob")} == {here}
