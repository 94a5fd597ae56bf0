"""Two operators at the same planner, each in a browser of its own: one guides the target, the other one changes things.

By hand, with the figures as JSON: ``python -m tests.planner.web.operation --seconds 600 [--robot panda] [--alone]
[--apart]``. The planner is a process of its own, so that its memory and its periods are those of a planner; with
``--apart`` it has the machine's first processor, and the browsers have the second one.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[3]
CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
STRATEGIES = ("hybrid", "newton", "damped", "transpose")
PERIOD = 1 / 60

MEASURE = """() => {
    const moves = [];
    window.latency = [];
    window.drawn = [];
    const { canvas } = planner.view;
    for (const kind of ["pointermove", "pointerrawupdate"]) canvas.addEventListener(kind, (event) => {
        if (event.buttons) moves.push([event.timeStamp, event.offsetX, event.offsetY]);
    }, true);
    canvas.addEventListener("pointerup", () => (moves.length = 0), true);
    const look = (now) => {
        window.drawn.push(now);
        if (window.drawn.length > 4000) window.drawn.splice(0, 2000);
        const [u, v] = planner.view.toScreen([...planner.state.frame.position]);
        moves.sort((a, b) => a[0] - b[0]);
        const at = moves.findLastIndex((move) => Math.hypot(move[1] - u, move[2] - v) < 1.5);
        if (at >= 0) window.latency.push(now - moves[at][0]);
        moves.splice(0, at + 1);
        requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
}"""
"""From a motion of the pointer to the time stamp of the animation frame that draws the target there [ms]."""


def serve(robot: str, seconds: float) -> None:
    """The process of the planner: serves, and prints figures when its input ends."""
    import jtik
    from jtik.cli.plan import leave_alone
    from jtik.planner import Planner

    scene = jtik.Scene({"ball": jtik.Sphere((0.45, 0.45, 0.35), 0.08)})
    options: dict[str, Any] = {} if robot == "planar" else {"robot": jtik.Robot.builtin(robot), "scene": scene}
    planner = Planner(**options, target_speed=(1000.0, 100.0), folder=False)
    times, builds, told = list[float](), list[bool](), list[str]()
    tick = planner.loop.tick

    def timed(now: float) -> None:
        times.append(now)
        builds.append(planner.loop.status.rebuilding)
        tick(now)

    planner.loop.tick = timed  # type: ignore[method-assign]
    leave_alone()
    with planner:
        print(planner.serve().url, flush=True)
        memory, seen, end = [], -1, time.monotonic() + seconds + 600
        while time.monotonic() < end and not _input_has_ended():
            memory.append(_memory())
            for number, level, text in tuple(planner.loop.messages):
                if number > seen:
                    seen = number
                    told += [text] if level == "error" else []
    periods, building = 1e3 * np.diff(times), np.array(builds[1:])
    quiet = periods[~building]
    figures = {
        "periods": len(periods),
        "period, p50 and p99 and largest [ms]": _quantiles(periods),
        "the same while no solver is built": _quantiles(quiet),
        "share of the time in which a solver is built": float(building.mean()),
        "late": planner.loop.status.late,
        "memory, first and last tenth [MiB]": [float(np.mean(part)) for part in _ends(memory)],
        "errors told": sorted(set(told)),
    }
    print(json.dumps(figures), flush=True)


def _input_has_ended() -> bool:
    """Whether the caller has closed the input; waits up to a second."""
    import select

    return bool(select.select([sys.stdin], [], [], 1.0)[0])


def _ends(values: list[float]) -> tuple[list[float], list[float]]:
    tenth = max(1, len(values) // 10)
    return values[tenth // 2 : tenth // 2 + tenth], values[-tenth:]


def _memory() -> float:
    """Resident memory of this process [MiB]."""
    found = re.search(r"VmRSS:\s+(\d+) kB", Path("/proc/self/status").read_text())
    return int(found[1]) / 1024 if found else 0.0


def _quantiles(values: Any) -> list[float]:
    return [round(float(x), 1) for x in np.percentile(values, [50, 99, 100])] if len(values) else []


class Browser:
    """A browser that shows the planner, in the thread that made it."""

    def __init__(self, url: str, complaints: list[str], *, processors: set[int] | None = None) -> None:
        from playwright.sync_api import sync_playwright

        command = next(filter(None, map(shutil.which, CHROMIUM)))
        own = os.sched_getaffinity(0) if processors else None
        if processors:
            os.sched_setaffinity(0, processors)  # of this thread; processes that it starts take it over
        self._playwright = sync_playwright().start()
        options = ["--no-sandbox", "--enable-unsafe-swiftshader", "--enable-precise-memory-info"]
        self._browser = self._playwright.chromium.launch(executable_path=command, args=options)
        self.page = self._browser.new_context(viewport={"width": 1440, "height": 900}).new_page()
        self.page.on("pageerror", lambda error: complaints.append(str(error)))
        self.page.on("console", lambda line: complaints.append(line.text) if line.type == "error" else None)
        if own is not None:
            os.sched_setaffinity(0, own)
        self.page.goto(url)
        self.page.wait_for_function("() => window.planner?.view && planner.state.frame && planner.state.status")
        box = self.page.locator("#view").bounding_box()
        assert box is not None
        self.box = box

    def pixel(self, place: list[float]) -> tuple[float, float]:
        u, v = self.page.evaluate("(place) => planner.view.toScreen(place)", place)
        return self.box["x"] + u, self.box["y"] + v

    def target(self) -> tuple[float, float]:
        return self.pixel(self.page.evaluate("() => [...planner.state.frame.position]"))

    def heap(self) -> float:
        """Memory of the page's scripts [MiB]."""
        used: float = self.page.evaluate("() => performance.memory.usedJSHeapSize")
        return used / 2**20

    def close(self) -> None:
        self._browser.close()
        self._playwright.stop()


def guide(browser: Browser, generator: np.random.Generator, end: float) -> dict[str, Any]:
    """Drag the target to and fro, a motion each period, until a time."""
    browser.page.evaluate(MEASURE)
    heaps = []
    while time.monotonic() < end:
        heaps.append(browser.heap())
        start = np.array(browser.target())
        middle = np.array([browser.box["x"] + browser.box["width"] / 2, browser.box["y"] + browser.box["height"] / 2])
        goal = middle + generator.uniform(-0.25, 0.25, 2) * (browser.box["width"], browser.box["height"])
        browser.page.mouse.move(*start)
        browser.page.mouse.down()
        due = time.monotonic()
        for share in np.linspace(0, 1, 60)[1:]:
            browser.page.mouse.move(*(start + share * (goal - start)))
            due = max(due + PERIOD, time.monotonic() - PERIOD)
            time.sleep(max(0.0, due - time.monotonic()))
        browser.page.mouse.up()
    latency, drawn = browser.page.evaluate("() => [window.latency, window.drawn]")
    return {
        "mouse to page as drawn, p50 and p99 and largest [ms]": _quantiles(latency),
        "answers": len(latency),
        "animation frames, p50 and p99 and largest [ms]": _quantiles(np.diff(drawn)),
        "memory of the page's scripts, first and last tenth [MiB]": [float(np.mean(each)) for each in _ends(heaps)],
    }


def change(browser: Browser, generator: np.random.Generator, end: float) -> dict[str, Any]:
    """Change obstacles and settings, record, play and delete attempts, until a time."""
    page, done, heaps = browser.page, 0, []

    def send(edit: str, **fields: Any) -> None:
        page.evaluate("([edit, fields]) => planner.send(edit, fields)", [edit, fields])

    def joint() -> str:
        names: list[str] = page.evaluate("() => planner.state.setup.joints.map(({ name }) => name)")
        return str(generator.choice(names))

    def drag_obstacle() -> None:
        places = page.evaluate(
            "() => Object.values(planner.state.settings.scene).map((each) => each.center).filter(Boolean)"
        )
        if places:
            at = np.array(browser.pixel(places[generator.integers(len(places))]))
            page.mouse.move(*at)
            page.mouse.down()
            page.mouse.move(*(at + generator.uniform(-60, 60, 2)), steps=8)
            page.mouse.up()

    def slide() -> None:
        number = page.locator('input[type="range"][aria-label]').nth(int(generator.integers(2, 8)))
        number.evaluate(
            """(node, at) => {
                node.value = +node.min + at * (node.max - node.min);
                node.dispatchEvent(new Event("input"));
            }""",
            generator.uniform(),
        )

    def record() -> None:
        page.locator("#record").click()
        page.wait_for_timeout(600)
        page.locator("#record").click()
        page.wait_for_timeout(300)

    def play() -> None:
        names = page.evaluate("() => planner.state.attempts.map(({ name }) => name)")
        if names:
            send("play", attempt=names[-1])
            page.wait_for_timeout(400)
            send("live")
        for name in names[:-4]:
            send("delete_attempt", attempt=name)

    def choose_strategy() -> None:
        page.locator('select[aria-label="strategy"]').select_option(str(generator.choice(STRATEGIES)))

    choices = [
        *[drag_obstacle] * 4,
        *[slide] * 4,
        record,
        play,
        choose_strategy,
        lambda: send("set_criteria", names=["joint_centering", "obstacle_avoidance"][: int(generator.integers(1, 3))]),
        lambda: send("set_joint_weights", weights={joint(): float(generator.choice([0.2, 1.0, 5.0]))}),
        lambda: send("jog", rate=float(generator.uniform(-1, 1))),
        lambda: send("jog", rate=0.0),
        lambda: send("take_posture"),
        lambda: page.locator("#theme").click(),
        lambda: send("set_limits", on=bool(generator.integers(2))),
    ]
    while time.monotonic() < end:
        choices[generator.integers(len(choices))]()
        heaps.append(browser.heap())
        done += 1
        page.wait_for_timeout(float(generator.uniform(50, 500)))
    return {
        "changes": done,
        "memory of the other page's scripts [MiB]": [float(np.mean(each)) for each in _ends(heaps)],
    }


def operate(
    seconds: float, *, robot: str = "planar", seed: int = 0, alone: bool = False, apart: bool = False
) -> dict[str, Any]:
    """Operate a planner from two browsers, or from the one that guides alone, and give what was measured."""
    if apart:
        os.sched_setaffinity(0, {0})  # the planner takes it over
    command = [sys.executable, "-m", "tests.planner.web.operation", "--serve", "--robot", robot]
    path = os.pathsep.join([str(ROOT), str(ROOT / "formulations"), *filter(None, sys.path)])
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    environment = {**os.environ, "PYTHONPATH": path}
    with subprocess.Popen(
        [*command, "--seconds", str(seconds)], **pipes, text=True, cwd=ROOT, env=environment
    ) as server:
        assert server.stdout is not None
        url = server.stdout.readline().strip()
        complaints, results, failed = list[str](), dict[str, Any](), list[BaseException]()
        end = time.monotonic() + seconds + 10
        load = [os.getloadavg()[0]]

        def work(what: Any, number: int) -> None:
            try:
                with contextlib.closing(Browser(url, complaints, processors={1} if apart else None)) as browser:
                    results.update(what(browser, np.random.default_rng([seed, number]), end))
            except BaseException as error:
                failed.append(error)

        threads = [threading.Thread(target=work, args=each) for each in ((guide, 1), (change, 2))[: 1 if alone else 2]]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        load.append(os.getloadavg()[0])
        printed, errors = server.communicate(timeout=120)
    if failed:
        raise failed[0]
    return {
        **json.loads(printed.splitlines()[-1]),
        **results,
        "complaints of the pages": complaints,
        "printed as an error": errors,
        "load of the machine, at first and at last": load,
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--serve", action="store_true")
    parser.add_argument("--robot", default="planar")
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--alone", action="store_true", help="without the one who changes things")
    parser.add_argument("--apart", action="store_true", help="planner and browsers on a processor each")
    given = parser.parse_args()
    if given.serve:
        serve(given.robot, given.seconds)
    else:
        options = {"robot": given.robot, "seed": given.seed, "alone": given.alone, "apart": given.apart}
        print(json.dumps(operate(given.seconds, **options), indent=1))
