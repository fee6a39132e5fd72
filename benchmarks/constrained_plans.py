"""Plans for rules with mixed constraints, against a dense search that shares no code with them.

    OMP_NUM_THREADS=1 python benchmarks/constrained_plans.py [--scenes 60] [--out FILE]

Random tables of people (discs with headings, some of whom talk) of 100 x 100 units. The rule: a
distance from people, more in front of them, off the line between two who talk, off the edge, and
slowly near people. The dense search: Dijkstra over every whole unit with 32 directions, each step
checked by samples. Printed: how often a plan keeps the rule by samples of its own, length over that
of the dense search, and seconds.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from demospec.planning import plan_path
from demospec.rules import RuleSet, rules_from_document
from demospec.scene import Disc, Picture, Relation, Scene, SceneObject

SIZE = 100
PICTURE = Picture(array=np.zeros((SIZE, SIZE, 3), dtype=np.uint8))
STEPS = [
    (i, j)
    for i in range(-5, 6)
    for j in range(-5, 6)
    if (np.gcd(i, j) == 1 and max(abs(i), abs(j)) <= 3) or (abs(i), abs(j)) in ((4, 1), (1, 4))
]


def table(rng: np.random.Generator) -> tuple[Scene, dict[str, float]]:
    n = int(rng.integers(3, 7))
    people = [
        SceneObject(
            f"p{i}", "person", (x, y), None, Disc((x, y), r), heading_deg=float(rng.uniform(0, 360))
        )
        for i, (x, y, r) in enumerate(
            zip(*rng.uniform(18, 82, (2, n)), rng.uniform(1, 4, n), strict=True)
        )
    ]
    talk = (Relation("talk", ("p0", "p1")),) if rng.random() < 0.6 else ()
    asked = {
        "keep": float(rng.uniform(1, 7)), "front": float(rng.uniform(5, 14)),
        "line": float(rng.uniform(1, 4)), "edge": float(rng.uniform(1, 6)),
        "slow": float(rng.uniform(2, 8)), "within": float(rng.uniform(4, 15)),
    }  # fmt: skip
    return Scene("s", (8.0, 8.0), (92.0, 92.0), tuple(people), PICTURE, relations=talk), asked


def rule(asked: dict[str, float]) -> RuleSet:
    constraints: list[dict[str, Any]] = [
        {"feature": "distance", "of": "person", "value": asked["keep"]},
        {"feature": "distance", "of": "person", "value": asked["front"], "sector": "front"},
        {"feature": "between", "of": "talk", "value": asked["line"]},
        {"feature": "edge", "value": asked["edge"]},
        {"feature": "speed", "value": asked["slow"],
         "when": {"within": asked["within"], "of": "person"}},
    ]  # fmt: skip
    return rules_from_document({"types": {"anyone": {"constraints": constraints}}})


def free(points: np.ndarray, scene: Scene, asked: dict[str, float], slack: float) -> np.ndarray:
    """(n,) whether a place keeps everything but the speed; `slack` less is asked."""
    e = asked["edge"] - slack
    ok = ((points >= e) & (points <= SIZE - e)).all(axis=1)
    for person in scene.objects or ():
        away = points - person.center
        gap = np.hypot(*away.T) - person.outline.radius
        angle = np.radians(person.heading_deg)
        front = away @ [np.cos(angle), np.sin(angle)] >= slack
        ok &= gap >= asked["keep"] - slack
        ok &= ~front | (gap >= asked["front"] - slack)
    for relation in scene.relations:
        a, b = (np.array(o.center) for o in scene.objects or () if o.id in relation.between)
        share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        ok &= np.hypot(*(points - a - share[:, None] * (b - a)).T) >= asked["line"] - slack
    return ok


def dense(scene: Scene, asked: dict[str, float]) -> float:
    """Length of the shortest way on the lattice of whole units; +inf without one."""
    n = SIZE + 1
    nodes = np.stack(np.meshgrid(np.arange(n), np.arange(n), indexing="ij"), axis=-1)
    nodes = nodes.reshape(-1, 2)
    ok = free(nodes.astype(float), scene, asked, 0.0)
    rows, columns, costs = [], [], []
    for step in STEPS:
        to = nodes + step
        inside = ok & ((to >= 0) & (to < n)).all(axis=1)
        first = np.flatnonzero(inside)
        last = to[first] @ [n, 1]
        first, last = first[ok[last]], last[ok[last]]
        clear = np.ones(len(first), dtype=bool)
        for share in np.linspace(0, 1, 14)[1:-1]:
            left = np.flatnonzero(clear)
            clear[left] = free(nodes[first[left]] + share * np.array(step), scene, asked, 0.0)
        rows.append(first[clear])
        columns.append(last[clear])
        costs.append(np.full(int(clear.sum()), np.hypot(*step)))
    graph = csr_matrix(
        (np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns))), shape=(n * n,) * 2
    )
    start, goal = (int(np.array(p) @ [n, 1]) for p in (scene.start, scene.goal))
    return float(dijkstra(graph, indices=start)[goal])


def keeps(plan: Any, scene: Scene, asked: dict[str, float]) -> bool:
    """The plan by samples 0.02 apart, and its speed on each piece."""
    for i, (a, b) in enumerate(zip(plan.points[:-1], plan.points[1:], strict=True)):
        n = max(2, int(np.hypot(*(b - a)) / 0.02))
        points = a + np.linspace(0, 1, n)[:, None] * (b - a)
        if not free(points, scene, asked, 1e-6).all():
            return False
        speed = np.hypot(*(b - a)) / (plan.t[i + 1] - plan.t[i])
        near = [
            np.hypot(*(points - p.center).T) - p.outline.radius <= asked["within"]
            for p in scene.objects or ()
        ]
        if np.any(near) and speed > asked["slow"]:
            return False
    return True


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=60)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    rng = np.random.default_rng(0)
    there, kept, ratios, seconds, none = 0, 0, [], [], 0
    while there < arguments.scenes:
        scene, asked = table(rng)
        ends = np.array([scene.start, scene.goal])
        if not free(ends, scene, asked, 0.0).all():
            continue
        best = dense(scene, asked)
        began = time.process_time()
        plan = plan_path(rule(asked), scene)
        seconds.append(time.process_time() - began)
        if not np.isfinite(best):
            none += not plan.found
            continue
        there += 1
        good = plan.found and plan.obeys and keeps(plan, scene, asked)
        kept += good
        if good:
            ratios.append(plan.length / best)
        else:
            print(f"not kept: scene {there}: {plan.status} {plan.reason}", flush=True)
    row = {
        "scenes": there, "kept": kept / there, "ratio_mean": float(np.mean(ratios)),
        "ratio_max": float(np.max(ratios)), "cpu_s_median": float(np.median(seconds)),
        "cpu_s_max": float(np.max(seconds)),
    }  # fmt: skip
    print(json.dumps(row, indent=1))
    if arguments.out is not None:
        arguments.out.write_text(json.dumps(row, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
