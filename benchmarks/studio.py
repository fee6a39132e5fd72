"""What a person at the studio waits for: from the key to the new rings, from the hand to the map.

    python benchmarks/studio.py [--strokes 24] [--drags 12]

A studio in a process of its own, Debian's Chromium beside it on the same machine, simulated
scenes. Writes benchmarks/results/studio.json: medians and 90 % quantiles, milliseconds of the
clock, and the machine's load meanwhile (on a busy machine everything waits for the processor).

- stroke: from the end of a stroke to the path drawn by the server
- verdict: from the key A or R to the sentence and rings that count it (goal: 200), where the
  person looked at the path for 0.7 s first; meanwhile both answers are computed
- verdict at once: the same of a key pressed as soon as the path was drawn
- drag: from a move of the control point to verdict, map and deciding place of a learned rule
  (goal: 100)
- object: the same from a move of an object, whose picture is painted anew (goal: 100)
- inside, object inside: what the server waited for of that, by its own clock
- rest: from the last move to the sentence that says how much further away would do (the page
  waits 160 for another move first)
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path
from typing import Any

import numpy as np
import psutil

RESULTS = Path(__file__).parent / "results"
CLOCK = """
async ([act, done]) => {
  const until = new Function("return " + done);
  const began = performance.now();
  new Function(act)();
  for (;;) {
    if (until()) return performance.now() - began;
    if (performance.now() - began > 60000) throw new Error("waited a minute for " + done);
    await new Promise((next) => setTimeout(next, 10));
  }
}
"""


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--strokes", type=int, default=24)
    parser.add_argument("--drags", type=int, default=12)
    options = parser.parse_args()
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        process, address = started(Path(folder) / "taught")
        try:
            browser = driver.chromium.launch(
                executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
            )
            page = browser.new_page(viewport={"width": 1280, "height": 900})
            server = psutil.Process(process.pid)
            spent = [cpu_s(server)]
            times = taught(page, address, options.strokes)
            spent.append(cpu_s(server))
            times |= explored(page, address, options.drags)
            spent.append(cpu_s(server))
            browser.close()
        finally:
            process.terminate()
            process.wait(10)
    document = {
        "command": "python " + " ".join(["benchmarks/studio.py", *sys.argv[1:]]),
        "machine": {
            "system": platform.system(), "cores": os.cpu_count(),
            "python": platform.python_version(),
            "load": [round(v, 1) for v in os.getloadavg()],
        },
        "milliseconds": {
            name: {"n": len(v), "median": round(float(np.median(v)), 1),
                   "q90": round(float(np.quantile(v, 0.9)), 1)}
            for name, v in times.items()
        },
        "server_cpu_ms": {
            "a stroke, its verdict and the advice": round(
                1e3 * (spent[1] - spent[0]) / options.strokes, 1
            ),
            "opening Explore, and its drags": round(1e3 * (spent[2] - spent[1]), 1),
        },
    }  # fmt: skip
    text = json.dumps(document, indent=1)
    (RESULTS / "studio.json").write_text(text + "\n", encoding="utf-8")
    print(text)
    return 0


def cpu_s(process: Any) -> float:
    """Processor seconds so far: what the machine's other work does not change much."""
    used = process.cpu_times()
    return float(used.user + used.system)


def started(out: Path, *arguments: str) -> tuple[subprocess.Popen[bytes], str]:
    """A studio of its own, and its address once it answers."""
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        port = int(s.getsockname()[1])
    process = subprocess.Popen(
        [sys.executable, "-m", "demospec", "studio", *arguments, "--port", str(port),
         "--no-browser", "--out", str(out)],
        stderr=subprocess.DEVNULL,
    )  # fmt: skip
    address = f"http://127.0.0.1:{port}"
    for _ in range(600):
        try:
            with urllib.request.urlopen(address + "/studio-static/studio.css", timeout=1):
                return process, address
        except OSError:
            time.sleep(0.1)
    raise RuntimeError("the studio did not start")


def taught(page: Any, address: str, strokes: int) -> dict[str, list[float]]:
    """Strokes of random bend in all scenes, judged by a distance of 4 px from glasses."""
    from demospec.demonstrations import bezier_points, simulate_set
    from demospec.rules import nearest_approach

    data, _ = simulate_set(train_scenes=12, test_scenes=1, demonstrations=1, seed=0)
    rng = np.random.default_rng(0)
    page.goto(address + "/teach")
    page.wait_for_selector("body[data-ready=yes] .counts", timeout=60_000)
    found: dict[str, list[float]] = {"stroke": [], "verdict": [], "verdict at once": []}
    for i in range(strokes):
        scene = data.scenes[i % 12]
        path = bezier_points(scene.start, scene.goal, rng.uniform(10, 90, (1, 1, 2)), 60)[0]
        valid = bool(nearest_approach(scene, [path], ("glass",))[0, 0] >= 4)
        stroke = json.dumps({"scene": scene.scene_id, "points": path.tolist(), "t": None})
        name = f"drawn-{i + 1:04d}"
        shown = f"!!document.querySelector('.path.chosen.unsaid[data-id=\"{name}\"]')"
        found["stroke"].append(
            page.evaluate(CLOCK, [f"emitEvent('teach_stroke', {stroke})", shown])
        )
        looks = i % 24 < 12  # once in every scene, then at once in every scene
        if looks:
            page.wait_for_timeout(700)
        key = "accept" if valid else "reject"
        counted = (
            "(t => t && t[1] * 1 + t[2] * 1)(document.querySelector('.counts').innerText"
            f".match(/(\\d+) accepted\\s+(\\d+) rejected/)) === {i + 1}"
        )
        found["verdict" if looks else "verdict at once"].append(
            page.evaluate(CLOCK, [f"emitEvent('teach_key', '{key}')", counted])
        )
        page.wait_for_timeout(1000)  # a person looks before the next stroke
    return found


def explored(page: Any, address: str, drags: int) -> dict[str, list[float]]:
    """Moves of the control point and of an object under the rule that was taught, by keys."""
    page.goto(address + "/explore")
    page.wait_for_selector('body[data-ready=yes] #explore[data-ready="yes"]', timeout=60_000)
    root = "document.querySelector('#explore').dataset"
    thing = page.evaluate("document.querySelector('.ex-object').dataset.handle")
    found: dict[str, list[float]] = {
        "drag": [], "inside": [], "rest": [], "object": [], "object inside": []
    }  # fmt: skip
    for handle in ("control", thing):
        names = ("drag", "inside") if handle == "control" else ("object", "object inside")
        for i in range(-1, drags):
            key = "ArrowLeft" if i % 4 < 2 else "ArrowRight"
            press = (
                f"window.was = {root}.answered;"
                f"document.querySelector('[data-handle=\"{handle}\"]').dispatchEvent("
                f"new KeyboardEvent('keydown', {{key: '{key}', shiftKey: true, bubbles: true}}))"
            )
            took = page.evaluate(CLOCK, [press, f"{root}.answered !== window.was"])
            inside = float(page.evaluate(f"{root}.milliseconds"))
            more = page.evaluate(CLOCK, ["", f"{root}.settled === {root}.answered"])
            if i >= 0:  # the first move of all paints what is under the object
                found[names[0]].append(took)
                found[names[1]].append(inside)
                if handle == "control":
                    found["rest"].append(took + more)
            page.wait_for_timeout(100)
    return found


if __name__ == "__main__":
    sys.exit(main())
