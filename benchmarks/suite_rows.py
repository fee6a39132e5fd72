"""The topics of the suite: each returns rows of work, figure, bound, peer and goal.

CPU seconds of one process on one thread, the least of a few runs unless a row says otherwise.
The `bound` of a row says what the work cannot do without: bytes, operations or samples.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Row:
    """One line of the table; `goal` is a largest value, or a least one where `more` is True."""

    work: str
    value: float
    unit: str
    bound: str
    goal: float | None = None
    more: bool = False
    peer: str = ""
    ratio: float | None = None

    @property
    def met(self) -> bool | None:
        """None where there is no goal."""
        if self.goal is None:
            return None
        return self.value >= self.goal if self.more else self.value <= self.goal


def cpu(work: Callable[[], Any], repeats: int = 5) -> float:
    """Least process time of some runs after a first one, seconds."""
    work()
    best = float("inf")
    for _ in range(repeats):
        began = time.process_time()
        work()
        best = min(best, time.process_time() - began)
    return best


def child(arguments: list[str], repeats: int, bytecode: str) -> float:
    """Least CPU seconds, user and system, of a whole process after a first one.

    The first run leaves its bytecode in the folder `bytecode`: pip compiles what it installs,
    so that a user's process never does, whatever this checkout or its environment says.
    """
    kept = {**os.environ, "PYTHONPYCACHEPREFIX": bytecode}
    kept.pop("PYTHONDONTWRITEBYTECODE", None)
    best = float("inf")
    for i in range(repeats + 1):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, *arguments], check=True, capture_output=True, env=kept)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        used = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
        best = min(best, used) if i else best
    return best


def startup(quick: bool) -> list[Row]:
    """Whole processes, beside a Python that does nothing."""
    from demospec.demonstrations import simulate_set, write_set

    n = 3 if quick else 7
    with tempfile.TemporaryDirectory() as folder:
        bytecode = str(Path(folder) / "bytecode")
        nothing = child(["-c", "pass"], n, bytecode)
        data, _ = simulate_set(train_scenes=4, test_scenes=1, demonstrations=2, seed=0)
        twenty = replace(data, demonstrations=data.demonstrations.rows(np.arange(20)))
        root = str(write_set(twenty, Path(folder) / "set"))
        rows = (
            ("demospec --help", ["-m", "demospec", "--help"], 0.4),
            ("import demospec", ["-c", "import demospec"], 0.3),
            ("rules on 20 demonstrations", ["-m", "demospec", "rules", root, "--json"], 0.5),
        )
        found = [(work, child(args, n, bytecode), goal) for work, args, goal in rows]
    return [
        Row(f"{work}, whole process", used, "s CPU", "starting Python", goal,
            peer="python -c pass", ratio=used / nothing)
        for work, used, goal in found
    ]  # fmt: skip


def reading(quick: bool) -> list[Row]:
    """A set of 30-point paths from disk, beside Arrow reading the same file."""
    from data import bench_read

    n = 20_000 if quick else 100_000
    with tempfile.TemporaryDirectory() as folder:
        found = {row["what"]: row["cpu_s"] for row in bench_read(Path(folder), n)}
    alone = found["pyarrow alone"]
    bound = f"{n * 30 * 2 * 8 / 1e6:.0f} MB of coordinates decoded and checked once"
    return [
        Row(f"{name}, {n:,} demonstrations", found[name], "s CPU", bound, 2.0,
            peer="pyarrow alone", ratio=found[name] / alone)
        for name in ("read_set", "iterate_batches")
    ]  # fmt: skip


def rendering(quick: bool) -> list[Row]:
    """A 100x100 scene from kept sprites on a new table."""
    from rendering import again, bytes_of, draw_scene

    from demospec.scene import load_catalogue

    n = 10 if quick else 40
    rng = np.random.default_rng(0)
    scenes = [draw_scene(rng, load_catalogue("builtin", "train"), size_px=100) for _ in range(n)]
    began = time.process_time()
    for i, scene in enumerate(scenes):
        again(scene, 10**6 + i)
    each = (time.process_time() - began) / n
    blocks = [np.ones(bytes_of(scene) // 8) for scene in scenes]
    began = time.process_time()
    for block in blocks:
        block.copy()
    copied = (time.process_time() - began) / n
    size = np.median([block.nbytes for block in blocks]) / 1e6
    return [
        Row("render a scene 100x100, sprites kept", 1e3 * each, "ms CPU",
            f"{size:.2f} MB of sprites and table touched", 10.0,
            peer="copying those bytes", ratio=each / copied)
    ]  # fmt: skip


def rules(quick: bool) -> list[Row]:
    """The influence engine beside the per-point CP-SAT encoding and a MILP; clearance rules."""
    from milp import against as against_milp
    from rules_speed import against, best
    from rules_worlds import world

    from demospec.demonstrations import simulate_set
    from demospec.rules import learn_rules, solve

    solve(world(0, 20, 8, 2).problem)
    rows = []
    direct = against(200, 20, 2, 1000, 500, seeds=1 if quick else 3)
    for name, key, found in (
        ("direct (CP-SAT, a Boolean a point)", "ratio", direct),
        ("MILP (HiGHS, a binary a level)", "ratio",
         [against_milp((200, 20, 2, 1000), seed) for seed in range(1 if quick else 3)]),
    ):  # fmt: skip
        ours = float(np.median([row["exact_s"] for row in found]))
        rows.append(
            Row("both ends, ties, hull: 20 paths x 200 points x 2 objects", 1e3 * ours, "ms CPU",
                "8,000 distances, two cumulative sums a path", peer=name,
                ratio=float(np.median([row[key] for row in found])))
        )  # fmt: skip
    for points, paths, objects, goal in ((500, 5000, 2, 1.0), (500, 2000, 5, 1.0)):
        problem = world(0, points, paths, objects).problem
        used = best(lambda problem=problem: solve(problem), 1 if quick else 3)
        bound = f"{points * paths * objects / 1e6:.0f} M distances"
        rows.append(Row(f"influence: {paths} paths x {points} points x {objects} objects", used,
                        "s CPU", bound, goal))  # fmt: skip
    data, _ = simulate_set(demonstrations=10, seed=0)
    used = cpu(lambda: learn_rules(data), 2)
    rows.append(Row("clearance rules of 3 types from 600 demonstrations", used, "s CPU",
                    "16 subsets of 4 classes a type"))  # fmt: skip
    return rows


def models(quick: bool) -> list[Row]:
    """Fit, look, map, logits and repair of each model family."""
    from specification import speed

    rows = []
    for r in speed(argparse.Namespace(seed=0)):
        name = r["model"]
        ours = name == "field"
        rows += [
            Row(f"{name}: fit, 20 scenes x 9 x 3", r["fit_s"], "s CPU",
                "passes over 540 demonstrations"),
            Row(f"{name}: see one picture", r["see_ms"], "ms CPU", "one pass of the network"),
            Row(f"{name}: map 51x51", r["map_51_ms"], "ms CPU", "2,601 logits",
                5.0 if ours else None),
            Row(f"{name}: path logits (100 points)", r["path_logits_per_s"], "/s",
                "100 look-ups a path (paper: one classifier pass)",
                500_000.0 if ours else None, more=True),
            Row(f"{name}: 256 repairs, one particle each", r["repairs_256_ms"], "ms CPU",
                "30 steps x 256 gradients", 50.0 if ours else None),
        ]  # fmt: skip
    return rows


def causal(quick: bool) -> list[Row]:
    """Every symbol added to every scene, judged by the true rule."""
    from demospec.causal import find_causes
    from demospec.demonstrations import simulate_set
    from demospec.rules import rules_from_document

    n = 5 if quick else 20
    data, document = simulate_set(train_scenes=1, test_scenes=n, demonstrations=1, seed=4)
    truth, scenes = rules_from_document(document), data.of_split("test").scenes
    used = cpu(lambda: find_causes(truth, scenes), 1)
    return [Row(f"causes: true rule, {n} scenes, 4 symbols", used, "s CPU",
                f"{n} scenes x 4 symbols x placements, rendered")]  # fmt: skip


def planning(quick: bool) -> list[Row]:
    """A plan on 100x100, beside the time after which OMPL's is within 5 % of its length."""
    from demospec.demonstrations import simulate_set
    from demospec.planning import plan_path
    from demospec.rules import rules_from_document

    n = 3 if quick else 10
    data, document = simulate_set(train_scenes=1, test_scenes=n, demonstrations=1, seed=3)
    truth, scenes = rules_from_document(document), data.of_split("test").scenes
    plan_path(truth, scenes[0], "careful")
    ours, theirs, longer = [], [], []
    for scene in scenes:
        began = time.process_time()
        plan = plan_path(truth, scene, "careful")
        ours.append(time.process_time() - began)
        began = time.process_time()
        try:
            other = plan_path(truth, scene, "careful", planner="rrtstar", seed=1, time_limit_s=0.25)
        except Exception as error:
            print(f"OMPL: {error}", file=sys.stderr)
            continue
        theirs.append(time.process_time() - began)
        if plan.length and other.length:
            longer.append(other.length / plan.length)
    peer = "OMPL RRT*, at most 0.25 s" if theirs else ""
    if longer:
        peer += f" (paths {float(np.median(longer)):.3f}x as long)"
    ratio = float(np.median(theirs) / np.median(ours)) if theirs else None
    return [Row(f"plan on 100x100, median of {n} scenes", 1e3 * float(np.median(ours)), "ms CPU",
                "10,000 cells through a heap, 8 or 16 neighbours", peer=peer,
                ratio=ratio)]  # fmt: skip


def studio(quick: bool) -> list[Row]:
    """What stands between a stroke and the new picture, without server and browser."""
    from demospec.demonstrations import simulate_set
    from demospec.rules import learn_rules
    from demospec.specification import validity_map
    from demospec.studio.explore._map import explore_map

    data, _ = simulate_set(train_scenes=4, test_scenes=1, demonstrations=5, seed=0)
    scene, type_ = data.scenes[0], data.types[0]
    learned = cpu(lambda: learn_rules(data, influence=False), 3)
    model = learn_rules(data, influence=False)
    mapped = cpu(lambda: validity_map(model.see(scene), type_), 5)
    explored = cpu(lambda: explore_map(model.see(scene), type_), 5)
    return [
        Row("studio: rules anew after a stroke (75 demonstrations)", 1e3 * learned, "ms CPU",
            "16 subsets of 4 classes a type", 200.0),
        Row("learned rule: map 51x51", 1e3 * mapped, "ms CPU", "2,601 logits", 5.0),
        Row("studio: the map that follows a slider", 1e3 * explored, "ms CPU",
            "a point a place and a path", 50.0),
    ]  # fmt: skip


TOPICS: dict[str, Callable[[bool], list[Row]]] = {
    "start-up": startup,
    "reading": reading,
    "rendering": rendering,
    "rules": rules,
    "models": models,
    "causal": causal,
    "planning": planning,
    "studio": studio,
}
