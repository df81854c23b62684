"""From a slider of the explorer to the picture, in a real browser without a graphics card.

A change is timed in the page, from the slider's event to the drawn picture (pixels read back) and to the painted first
plot with the new curve; where the twist changes, with the mark at its new place, as the curve stays. On a busy machine
look at the processor's seconds of a change, of server and browser together.
"""

from __future__ import annotations

import os
import re
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
# Chromium paints as it does on its own where there is no graphics card; told to use ANGLE on SwiftShader, it takes that
# for a card and composes the whole page by it, in several times the work
FLAGS = ["--no-sandbox", "--enable-unsafe-swiftshader"]
CHANGE = """async ([name, value]) => {
  const slider = document.querySelector(`[data-field=${name}]`), plot = document.querySelector('.plot');
  const curves = () => [...plot.querySelectorAll('path')].map((path) => path.getAttribute('d')).join();
  const shown = name === 'twist' ? () => plot.querySelector('.marks b').style.cssText : curves;
  const state = squamaView.state, before = shown();
  const drawn = new Promise((done) => { squamaView.onDraw = () => { if (squamaView.state !== state) done(); }; });
  const plotted = new Promise((done) => { const seen = new MutationObserver(() => {
      if (shown() === before) return;
      seen.disconnect();
      // a message comes after the frame's layout and painting
      const after = new MessageChannel();
      after.port1.onmessage = () => done(performance.now());
      requestAnimationFrame(() => after.port2.postMessage(0));
    });
    seen.observe(plot, {subtree: true, childList: true, attributes: true}); });
  const start = performance.now();
  slider.value = value;
  slider.dispatchEvent(new Event('input'));
  await drawn;
  const gl = squamaView.renderer.getContext();
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  const picture = performance.now() - start;
  return [picture, Math.max(picture, (await plotted) - start)];
}"""


@pytest.fixture(scope="module")
def page() -> Iterator[Any]:
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("Chromium is missing; install it with: apt-get install chromium")
    from playwright.sync_api import sync_playwright

    plain = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "NICEGUI"))}
    command = [sys.executable, "-m", "squama", "explore", "--no-browser"]
    with (
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT, env=plain) as server,
        sync_playwright() as play,
    ):
        assert server.stdout is not None
        address = re.search(r"http\S+", server.stdout.readline())
        assert address
        browser = play.chromium.launch(executable_path=chromium, args=FLAGS)
        shown = browser.new_page(viewport={"width": 1280, "height": 800})
        shown.goto(address[0])
        shown.wait_for_function("window.squamaView && window.squamaView.contacts")
        time.sleep(2)
        yield shown
        browser.close()
        server.terminate()


def cpu() -> float:
    """Processor seconds of this process and all that have come from it, that still live."""
    ticks = os.sysconf("SC_CLK_TCK")
    parents, seconds = {}, {}
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            try:
                fields = (folder / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            parents[int(folder.name)], seconds[int(folder.name)] = int(fields[1]), sum(map(int, fields[11:13])) / ticks
    family = {os.getpid()}
    while more := {pid for pid, parent in parents.items() if parent in family} - family:
        family |= more
    return sum(seconds[pid] for pid in family if pid in seconds)


@pytest.mark.parametrize("name", ["twist", "eta", "mu"])
def test_from_slider_to_picture(benchmark, page: Any, name: str) -> None:
    times: list[list[float]] = []
    places = iter([0.2 + 0.01 * i for i in range(60)])

    def change() -> None:
        times.append(page.evaluate(CHANGE, [name, next(places)]))

    change()
    times.clear()
    before = cpu()
    benchmark.pedantic(change, rounds=30)
    spent = (cpu() - before) / len(times)
    pictures, plots = zip(*times, strict=True)
    benchmark.extra_info["median ms to the picture"] = round(statistics.median(pictures))
    benchmark.extra_info["95 % of changes, ms to the picture"] = round(sorted(pictures)[int(0.95 * len(pictures))])
    benchmark.extra_info["median ms to the plot"] = round(statistics.median(plots))
    benchmark.extra_info["95 % of changes, ms to the plot"] = round(sorted(plots)[int(0.95 * len(plots))])
    benchmark.extra_info["processor ms of a change, server and browser"] = round(1e3 * spent)
    benchmark.extra_info["load average of the machine"] = round(os.getloadavg()[0], 1)
