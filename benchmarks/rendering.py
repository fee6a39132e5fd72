"""How long scenes take: sprites, tables, whole scenes, overlays, simulated sets.

    python benchmarks/rendering.py [--quick]

CPU time of one thread, median of repeats. The bound beside a whole scene is the time to copy,
once, every byte that it must touch (sprite samples and picture) in the same process.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

from demospec.demonstrations import simulate_set  # noqa: E402
from demospec.scene import (  # noqa: E402
    Placement,
    Scene,
    compose_scene,
    draw_light,
    draw_scene,
    draw_table,
    free_places,
    load_catalogue,
    overlay,
    placebo_patch,
    remove_object,
)

RESULTS = Path(__file__).parent / "results" / "rendering.json"


def cpu_ms(work: Callable[[int], object], repeats: int) -> float:
    """Median CPU milliseconds of work(0), work(1), …"""
    times = []
    for i in range(repeats):
        began = time.process_time()
        work(i)
        times.append(1e3 * (time.process_time() - began))
    return statistics.median(times)


def again(scene: Scene, table_seed: int) -> Scene:
    """The same objects composed anew, on a table that is not kept from before."""
    recipe = scene.recipe
    assert recipe is not None
    catalogue = load_catalogue()
    placements = [
        Placement(catalogue.item(recipe.items[o.id].item), o.center, recipe.items[o.id].angle)
        for o in scene.listed_objects()
    ]
    table = replace(recipe.table, seed=table_seed)
    size = scene.size_px
    assert size is not None
    return compose_scene("s", placements, table=table, light=recipe.light, size_px=size[0])


def bytes_of(scene: Scene) -> int:
    """Sprite samples and float picture of a scene."""
    recipe = scene.recipe
    assert recipe is not None
    catalogue = load_catalogue()
    total = scene.pixels().size * 8
    for entry in recipe.items.values():
        total += catalogue.item(entry.item).sprite(entry.angle, 1 / recipe.metres_per_px).nbytes
    return int(total)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer repeats")
    quick = parser.parse_args().quick
    repeats = 10 if quick else 40
    rows: list[dict[str, object]] = []

    def row(work: str, ms: float, goal: float | None = None, note: str = "") -> None:
        rows.append({"work": work, "cpu_ms": round(ms, 3), "goal_ms": goal, "note": note})

    began = time.process_time()
    simulate_set()
    row("simulate 20+20 scenes x 10 x 3, cold", 1e3 * (time.process_time() - began), 5000.0)
    row(
        "the same, another seed",
        cpu_ms(lambda i: simulate_set(seed=1 + i), 2 if quick else 3),
        5000.0,
    )

    catalogue = load_catalogue("builtin", "train")
    rng = np.random.default_rng(0)
    for size, n in ((100, repeats), (400, min(repeats, 10))):
        # Few enough for the sprite cache (128 MiB) at 400x400: about 3 MB a sprite.
        scenes = [draw_scene(rng, catalogue, size_px=size) for _ in range(n)]
        new = cpu_ms(lambda i, s=scenes: again(s[i], 10**6 + i), n)  # type: ignore[misc]
        touched = [bytes_of(s) for s in scenes]
        blocks = [np.ones(b // 8) for b in touched]
        floor = cpu_ms(lambda i, b=blocks: b[i].copy(), n)  # type: ignore[misc]
        row(
            f"scene {size}x{size}, sprites kept, new table", new, 10.0 if size == 100 else None,
            f"{new / floor:.0f} x copying its {statistics.median(touched) / 1e6:.2f} MB",
        )  # fmt: skip
        row(
            f"scene {size}x{size}, sprites and table kept",
            cpu_ms(lambda i, s=scenes: again(s[i], 10**6 + i), n),  # type: ignore[misc]
        )

    n = repeats
    scenes = [draw_scene(rng, catalogue) for _ in range(n)]
    places = [free_places(s, 8.0, 1, rng) for s in scenes]
    usable = [(s, p[0]) for s, p in zip(scenes, places, strict=True) if len(p)]
    item = catalogue.item("plate-train-00")
    item.sprite(0.0, 100 / 0.82)
    row("overlay on 100x100, sprite kept", cpu_ms(lambda i: overlay(*_at(usable, i, item)), n))
    row("remove an object, 100x100", cpu_ms(
        lambda i: remove_object(scenes[i], scenes[i].listed_objects()[0].id), n))  # fmt: skip
    row("placebo patch, 100x100", cpu_ms(lambda i: placebo_patch(*usable[i % len(usable)], rng), n))
    row("free_places, 16 places", cpu_ms(lambda i: free_places(scenes[i], 8.0, 16, rng), n))

    fresh = list(load_catalogue("builtin", "test").items)
    for item in fresh:
        _ = item.mesh
    row(
        "sprite at 100x100, not kept",
        cpu_ms(lambda i: fresh[i].sprite(1.0, 77.7), min(n, len(fresh))),
    )
    row("table 100x100, not kept", _tables(n))
    report(rows, ["--quick"] if quick else [])


def _at(usable: list[tuple[Scene, np.ndarray]], i: int, item: object) -> tuple:  # type: ignore[type-arg]
    scene, place = usable[i % len(usable)]
    return scene, item, place


def _tables(n: int) -> float:
    rng = np.random.default_rng(5)
    light = draw_light(rng)
    tables = [draw_table(rng) for _ in range(n)]
    return cpu_ms(lambda i: compose_scene("t", [], table=tables[i], light=light), n)


def report(rows: list[dict[str, object]], arguments: list[str]) -> None:
    """Prints the table and records it with machine, versions and command."""
    print(f"{'work':45} {'CPU ms':>9} {'goal':>8}  note")
    for r in rows:
        goal = "" if r["goal_ms"] is None else f"{r['goal_ms']:g}"
        print(f"{r['work']:45} {r['cpu_ms']:9.2f} {goal:>8}  {r['note']}")
    document = {
        "command": " ".join(["python benchmarks/rendering.py", *arguments]),
        "machine": {
            "system": platform.system(),
            "processor": _processor(),
            "cores": os.cpu_count(),
        },
        "versions": {"python": sys.version.split()[0], "numpy": np.__version__},
        "seeds": {"sets": [0, 1, 2, 3], "scenes": 0},
        "rows": rows,
    }
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(document, indent=1) + "\n")


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if "model name" in line)
    except (OSError, StopIteration):
        return platform.processor()


if __name__ == "__main__":
    main()
