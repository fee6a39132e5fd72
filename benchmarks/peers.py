"""Peers side by side: other people's software on the same inputs, time and accuracy, one table.

    pip install shapely scikit-learn imitation
    OMP_NUM_THREADS=1 python benchmarks/peers.py [--seeds 0 1 2] [--counts 9 3 1]

Verdicts are those on new paths in unseen scenes, judged by the rule that made the labels; every
learner gets the same distances to the listed classes (the grid of MaxEnt IRL: the same outlines).
A peer that is not installed is left out. CPU seconds of one process on one thread.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import platform
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet, simulate_set
from demospec.geometry import Polygon, Polylines, nearest_on_paths
from demospec.planning import plan_path
from demospec.rules import RuleSet, learn_rules, nearest_approach, rules_from_document

RESULTS = Path(__file__).parent / "results" / "peers.json"
Floats = np.ndarray
FAR = 40.0  # px: farther, or no such object there, is alike; helps lines and kernels


def timed(work: Callable[..., Any], *arguments: Any, **options: Any) -> tuple[Any, float]:
    began = time.process_time()
    out = work(*arguments, **options)
    return out, time.process_time() - began


def installed(name: str) -> bool:
    return importlib.util.find_spec(name) is not None


# --- distances ---------------------------------------------------------------------------------


def distances(rng: np.random.Generator) -> list[dict[str, Any]]:
    """Signed distance of whole paths to a footprint: 400 paths of 100 points, some corners."""
    if not installed("shapely"):
        return []
    import shapely

    rows = []
    for corners in (4, 20, 200):
        angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
        ring = 50 + np.stack([np.cos(angle), np.sin(angle)], 1) * rng.uniform(5, 9, (corners, 1))
        paths = rng.uniform(0, 100, (400, 1, 2)) + np.cumsum(
            rng.normal(0, 1, (400, 100, 2)), axis=1
        )
        flat = Polylines(paths.reshape(-1, 2), np.arange(401) * 100)
        (ours, _, _), seconds = timed(nearest_on_paths, flat, Polygon(ring))
        area = shapely.Polygon(ring)
        lines = shapely.linestrings(paths)
        theirs, peer = timed(shapely.distance, lines, area)
        rim, with_rim = timed(shapely.distance, lines, area.exterior)
        outside = ours > 0
        rows.append(
            {
                "corners": corners,
                "ours_ms": 1e3 * seconds,
                "shapely_ms": 1e3 * peer,
                "largest_difference_outside": float(np.abs(ours - theirs)[outside].max()),
                "inside_where_shapely_says_0": int((~outside).sum()),
                "rim_ms": 1e3 * with_rim,
                "rim_agrees": bool(np.allclose(rim[outside], ours[outside])),
            }
        )
    return rows


# --- verdicts ----------------------------------------------------------------------------------


def table(data: DemonstrationSet, name: str) -> tuple[Floats, np.ndarray, list[Any], list[Any]]:
    """Distances (n, K), labels, paths and scenes of one person."""
    d = data.demonstrations
    rows = np.flatnonzero(np.array([t == name for t in d.type]) & (d.valid >= 0))
    paths = [d.paths_xy(np.array([i]))[0] for i in rows]
    scenes = [data.scene(d.scene_id[i]) for i in rows]
    near = np.concatenate(
        [nearest_approach(s, [p], data.symbols) for s, p in zip(scenes, paths, strict=True)]
    )
    return near, d.valid[rows] == 1, paths, scenes


def scored(p: Floats, truth: np.ndarray) -> dict[str, float]:
    said = p >= 0.5
    return {
        "balanced_accuracy": float((said[truth].mean() + (~said[~truth]).mean()) / 2),
        "brier": float(((p - truth) ** 2).mean()),
    }


def classifiers() -> dict[str, Callable[[], Any]]:
    if not installed("sklearn"):
        return {}
    from sklearn.calibration import CalibratedClassifierCV
    from sklearn.ensemble import HistGradientBoostingClassifier, RandomForestClassifier
    from sklearn.linear_model import LogisticRegression
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler
    from sklearn.svm import SVC

    def calibrated(model: Any) -> Any:
        return CalibratedClassifierCV(model, method="sigmoid", cv=3)

    return {
        "logistic regression": lambda: make_pipeline(StandardScaler(), LogisticRegression()),
        "support vectors (RBF), calibrated": lambda: calibrated(
            make_pipeline(StandardScaler(), SVC(random_state=0))
        ),
        "random forest, calibrated": lambda: calibrated(
            RandomForestClassifier(200, random_state=0, n_jobs=1)
        ),
        "boosted trees, calibrated": lambda: calibrated(
            HistGradientBoostingClassifier(min_samples_leaf=5, random_state=0)
        ),
    }


# --- MaxEnt IRL on a grid ----------------------------------------------------------------------

CELLS = 26
BANDS = (1.0, 3.0, 6.0, 10.0)  # px: a state's features are "a K is nearer than this"
MOVES = np.array([(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)])


class Moves:
    """Transitions of a grid as `imitation`'s recurrences read them, without S × A × S numbers."""

    def __init__(self) -> None:
        from scipy import sparse

        at = np.stack(np.unravel_index(np.arange(CELLS * CELLS), (CELLS, CELLS)), axis=1)
        self.after = np.stack(
            [np.ravel_multi_index(np.clip(at + m, 0, CELLS - 1).T, (CELLS, CELLS)) for m in MOVES],
            axis=1,
        )
        one = np.ones(len(at))
        self.each = [
            sparse.csr_matrix((one, (np.arange(len(at)), self.after[:, a])), (len(at),) * 2)
            for a in range(len(MOVES))
        ]

    def __matmul__(self, value: Floats) -> Floats:
        return np.asarray(value[self.after])

    def __getitem__(self, key: tuple[Any, int, Any]) -> Any:
        return self.each[key[1]]


def states(path: Floats, size: float) -> np.ndarray:
    """Cells along a path, each a move of at most one cell after the other."""
    cell = np.clip((np.asarray(path) / size * CELLS).astype(int), 0, CELLS - 1)
    way = [cell[0]]
    for goal in cell[1:]:
        while (goal != way[-1]).any():
            way.append(way[-1] + np.sign(goal - way[-1]))
    return np.ravel_multi_index(np.array(way).T, (CELLS, CELLS))


def features(scene: Any, symbols: tuple[str, ...], size: float) -> Floats:
    """(S, F) of a scene's cells."""
    at = np.stack(np.unravel_index(np.arange(CELLS * CELLS), (CELLS, CELLS)), axis=1)
    near = nearest_approach(scene, ((at + 0.5) / CELLS * size)[:, None], symbols)
    return np.concatenate([near < band for band in BANDS], axis=1).astype(float)


def maxent(
    train: tuple[Any, ...], test: tuple[Any, ...], symbols: tuple[str, ...], rounds: int = 60
) -> tuple[Floats, Floats]:
    """Scores of training and test paths under the reward that explains the accepted ones."""
    from imitation.algorithms.mce_irl import mce_occupancy_measures

    size = 100.0
    known: dict[str, Floats] = {}

    def seen(scene: Any) -> Floats:
        if scene.scene_id not in known:
            known[scene.scene_id] = features(scene, symbols, size)
        return known[scene.scene_id]

    _, label, paths, scenes = train
    walks = [states(p, size) for p in paths]
    moves, wanted, worlds = Moves(), 0.0, []
    for scene in {s.scene_id: s for s in scenes}.values():
        own = [
            w
            for w, s, ok in zip(walks, scenes, label, strict=True)
            if ok and s.scene_id == scene.scene_id
        ]
        if not own:
            continue
        f = seen(scene)
        wanted = wanted + np.mean([f[w].sum(axis=0) for w in own], axis=0)
        begin = np.bincount([w[0] for w in own], minlength=len(f)) / len(own)
        goal = np.zeros(len(f))
        goal[own[0][-1]] = 1.0
        env = SimpleNamespace(
            horizon=int(np.median([len(w) for w in own])) + 6, state_dim=len(f),
            action_dim=len(MOVES), transition_matrix=moves, initial_state_dist=begin,
            reward_matrix=None,
        )  # fmt: skip
        worlds.append((env, f, goal))
    theta = np.zeros(len(BANDS) * len(symbols))
    for k in range(rounds):
        slope = -wanted
        for env, f, goal in worlds:
            reward = -f @ theta + 2.0 * goal - 0.3  # to be there is good, to be on the way costs
            slope = slope + mce_occupancy_measures(env, reward=reward)[1] @ f
        theta = np.maximum(theta + 0.3 / (1 + k / 10) * slope / len(worlds), 0.0)
    return tuple(
        np.array(
            [
                -(seen(s)[states(p, size)] @ theta).sum()
                for p, s in zip(some[2], some[3], strict=True)
            ]
        )
        for some in (train, test)
    )


def best_cut(score: Floats, label: np.ndarray) -> float:
    """The threshold with the best balanced accuracy on the training labels."""
    every = np.unique(score)
    every = np.concatenate([every, [np.inf]])
    right = [(score >= c)[label].mean() + (score < c)[~label].mean() for c in every]
    return float(every[int(np.argmax(right))])


def verdicts(seed: int, count: int) -> list[dict[str, Any]]:
    """Every learner on 20 scenes with `count` demonstrations each, two people."""
    data, document = simulate_set(
        train_scenes=20, test_scenes=20, demonstrations=max(count, 9), seed=seed
    )
    truth = rules_from_document(document)
    d = data.demonstrations
    keep = np.zeros(len(d), dtype=bool)
    taken: dict[tuple[str, str], int] = {}
    for i in range(len(d)):
        key = (str(d.scene_id[i]), str(d.type[i]))
        taken[key] = taken.get(key, 0) + 1
        keep[i] = taken[key] <= count
    part = DemonstrationSet(
        data.scenes, d.rows(np.flatnonzero(keep)), units=data.units, symbols=data.symbols,
        types=data.types, name=data.name,
    ).of_split("train")  # fmt: skip
    out = []
    for name in ("careful", "normal"):
        train, test = table(part, name), table(data.of_split("test"), name)
        right = np.concatenate(
            [truth.see(s).logits([p], name) >= 0 for s, p in zip(test[3], test[2], strict=True)]
        )

        def row(who: str, seconds: float, scores: dict[str, Any], name: str = name) -> None:
            out.append({"learner": who, "type": name, "count": count, "cpu_s": seconds, **scores})

        rules, seconds = timed(learn_rules, part, influence=False)
        row("demospec rules", seconds / len(part.types), scored(ours(rules, test, name), right))
        if not train[1].any() or train[1].all():
            continue
        x, new = np.minimum(train[0], FAR), np.minimum(test[0], FAR)
        for who, make in classifiers().items():
            least = min(train[1].sum(), (~train[1]).sum())
            if "calibrated" in who and least < 3:
                continue
            model, seconds = timed(make().fit, x, train[1])
            row(who, seconds, scored(model.predict_proba(new)[:, 1], right))
        if installed("imitation"):
            (fitted, score), seconds = timed(maxent, train, test, data.symbols)
            cut = best_cut(fitted, train[1])
            row("MaxEnt IRL (imitation), cut by the labels", seconds,
                {**scored((score >= cut).astype(float), right), "brier": None})  # fmt: skip
    return out


def ours(rules: RuleSet, some: tuple[Any, ...], name: str) -> Floats:
    return np.concatenate(
        [rules.see(s).p_valid([p], name) for s, p in zip(some[3], some[2], strict=True)]
    )


# --- plans -------------------------------------------------------------------------------------


def plans(scenes: int) -> list[dict[str, Any]]:
    """A plan by the true rule: grid and smoothing here, sampling planners of OMPL."""
    if not installed("ompl"):
        return []
    data, document = simulate_set(train_scenes=1, test_scenes=scenes, demonstrations=1, seed=3)
    truth, places = rules_from_document(document), data.of_split("test").scenes
    shortest = [plan_path(truth, s, "careful") for s in places]
    rows = []
    for planner in ("grid", "rrtstar", "bitstar", "informed-rrtstar"):
        times, longer, kept = [], [], 0
        for scene, best in zip(places, shortest, strict=True):
            options = {} if planner == "grid" else {"seed": 1, "time_limit_s": 0.25}
            plan, seconds = timed(plan_path, truth, scene, "careful", planner=planner, **options)
            times.append(seconds)
            if plan.length and best.length:
                longer.append(plan.length / best.length)
                kept += bool(truth.see(scene).logits([plan.points], "careful")[0] >= 0)
        kept_of = f"{kept} of {len(longer)}"
        ms, length = 1e3 * float(np.median(times)), float(np.mean(longer))
        rows.append({"planner": planner, "ms": ms, "length": length, "keep": kept_of})
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--counts", type=int, nargs="+", default=[9, 3, 1])
    parser.add_argument("--scenes", type=int, default=10, help="of the plans")
    args = parser.parse_args()
    near = distances(np.random.default_rng(0))
    for line in near:
        print(json.dumps(line), flush=True)
    every = [r for s in args.seeds for c in args.counts for r in verdicts(s, c)]
    learned = []
    for who, count in sorted({(r["learner"], r["count"]) for r in every}, key=lambda k: (-k[1], k)):
        mine = [r for r in every if (r["learner"], r["count"]) == (who, count)]
        learned.append(
            {
                "learner": who, "count": count, "fits": len(mine),
                "cpu_s": float(np.median([r["cpu_s"] for r in mine])),
                "balanced_accuracy": float(np.mean([r["balanced_accuracy"] for r in mine])),
                "brier": None if mine[0]["brier"] is None
                else float(np.mean([r["brier"] for r in mine])),
            }
        )  # fmt: skip
        print(json.dumps(learned[-1]), flush=True)
    planned = plans(args.scenes)
    for line in planned:
        print(json.dumps(line), flush=True)
    peers = {"shapely": "shapely", "sklearn": "scikit-learn", "imitation": "imitation",
             "ompl": "ompl"}  # fmt: skip
    document = {
        "command": f"python benchmarks/peers.py --seeds {' '.join(map(str, args.seeds))} "
        f"--counts {' '.join(map(str, args.counts))}",
        "machine": platform.processor() or platform.machine(),
        "versions": {name: version(name) for p, name in peers.items() if installed(p)},
        "distances": near, "verdicts": learned, "plans": planned,
    }  # fmt: skip
    RESULTS.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
