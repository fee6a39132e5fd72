"""How soon the studio's pages answer about 400 scenes with 40 paths each.

    python benchmarks/studio_large.py [--scenes 400] [--paths 40] [--set SET]

Simulated scenes and paths of three people; a studio in a process of its own. Writes
benchmarks/results/studio_large.json: milliseconds of the clock of each request that a page
makes when it is opened, before anything was learned, while rules are being learned after a
label has changed, and when they are known (goal: 300 each). A page says that it learns and asks
again; how long learning took stands beside.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import tempfile
import time
import urllib.request
from pathlib import Path
from typing import Any

import numpy as np

from studio import started

RESULTS = Path(__file__).parent / "results"
OPENED = (
    "/demonstrations", "/api/gallery?wait=false", "/api/gallery?contradicting=true&wait=false",
    "/api/history", "/check", "/api/check?wait=false", "/api/people?wait=false", "/results",
    "/table", "/api/table", "/api/steps", "/api/set",
)  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scenes", type=int, default=400)
    parser.add_argument("--paths", type=int, default=40)
    parser.add_argument("--set", type=Path, default=None)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        data = options.set or made(Path(folder) / "set", options.scenes, options.paths)
        process, address = started(Path(folder) / "taught", str(data))
        try:
            document = measured(address)
        finally:
            process.terminate()
            process.wait(60)
    document = {
        "command": "python " + " ".join(["benchmarks/studio_large.py", *sys.argv[1:]]),
        "machine": {
            "system": platform.system(), "cores": os.cpu_count(),
            "python": platform.python_version(), "load": [round(v, 1) for v in os.getloadavg()],
        },
        **document,
    }  # fmt: skip
    text = json.dumps(document, indent=1)
    (RESULTS / "studio_large.json").write_text(text + "\n", encoding="utf-8")
    print(text)
    return 0


def made(place: Path, scenes: int, paths: int) -> Path:
    from dataclasses import replace

    from demospec.demonstrations import simulate_set, write_set

    each = -(-paths // 3)
    data, _ = simulate_set(train_scenes=scenes, test_scenes=1, demonstrations=each, seed=0)
    first = np.concatenate([rows[:paths] for rows in data.rows_by_scene().values()])
    mine = data.select(np.sort(first))
    return write_set(replace(mine, name="large"), place)


def asked(address: str, path: str, body: Any = None) -> tuple[Any, float]:
    """(answer, milliseconds)."""
    began = time.perf_counter()
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(address + path, data, {"Content-Type": "application/json"})
    with urllib.request.urlopen(request, timeout=900) as answer:
        text = answer.read()
    took = 1000 * (time.perf_counter() - began)
    return (json.loads(text) if path.startswith("/api/") else None), round(took, 1)


def opened(address: str) -> dict[str, float]:
    return {path: asked(address, path)[1] for path in OPENED}


def learned_s(address: str) -> float:
    """Seconds until nothing is being learned any more, asked for as a page does."""
    began = time.perf_counter()
    paths = ("/api/check?wait=false", "/api/people?wait=false")
    while any(asked(address, path)[0]["learning"] for path in paths):
        time.sleep(0.5)
    return round(time.perf_counter() - began, 1)


def measured(address: str) -> dict[str, Any]:
    size = asked(address, "/api/set")[0]
    found: dict[str, Any] = {"set": {k: v for k, v in size.items() if k in ("demonstrations",)}}
    found["milliseconds, at first"] = opened(address)
    found["learned_s, at first"] = learned_s(address)
    found["milliseconds, known"] = opened(address)
    path = asked(address, "/api/gallery")[0]["demonstrations"][0]
    change = {"demo_ids": [path["demo_id"]], "valid": not path["valid"]}
    found["milliseconds, a label changed"] = asked(address, "/api/change", change)[1]
    found["milliseconds, while it is learned"] = opened(address)
    found["learned_s, with a contradiction"] = learned_s(address)
    return found


if __name__ == "__main__":
    sys.exit(main())
