"""Real raters: how well a person's rule is learned from their own ratings, and how honest it is.

    python benchmarks/people.py --socnav FOLDER [--counts 20 60 150 300] [--draws 20]

FOLDER holds the ratings of SocNav1 (Manso et al., 2020; CC BY 4.0), one file of JSON lines for
each rater (``b.json`` or ``b.json.gz``). Each rating is one place where a robot stands among
people and things, with a score from 0 to 100; 50 and more counts as accepted. Without the folder
nothing is measured.

For each rater and number of labels: balanced accuracy on the rater's other ratings; whether the
95 % interval of the clearance to people holds the long-run answer (all ratings of that rater);
its width; the same learned from scores; beside it gradient boosting on the same distances (where
scikit-learn is installed) and how far two raters agree on places that both saw.
"""

from __future__ import annotations

import argparse
import gzip
import json
import platform
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet
from demospec.rules import ClearanceRule, learn_rules, nearest_approach
from demospec.scene import Scene, SceneObject

CUT = 50.0
SYMBOLS = ("human", "object")
PLACE = ("humans", "objects", "room", "links")


def ratings(folder: Path) -> dict[str, list[dict[str, Any]]]:
    """Rater → their ratings."""
    out = {}
    for file in sorted([*folder.glob("*.json"), *folder.glob("*.json.gz")]):
        opened = gzip.open if file.suffix == ".gz" else open
        with opened(file, "rt", encoding="utf-8") as stream:
            out[file.name.split(".")[0]] = [json.loads(line) for line in stream if line.strip()]
    return out


def as_set(rows: list[dict[str, Any]], rater: str, *, graded: bool = False) -> DemonstrationSet:
    """One scene a rating, in metres, y as it came; the robot stands at the origin.

    Args:
        graded: Whether the scores are given beside their cut.
    """
    scenes, items = [], []
    for i, row in enumerate(rows):
        things = [
            SceneObject(f"{kind}-{thing['id']}", kind, (thing["xPos"] / 100, thing["yPos"] / 100))
            for kind, found in (("human", row["humans"]), ("object", row["objects"]))
            for thing in found
        ]
        scenes.append(Scene(f"r{i:04}", (0.0, 0.0), (0.0, 0.0), objects=tuple(things)))
        items.append(
            Demonstration(
                f"r{i:04}", f"r{i:04}", np.zeros((1, 2)), type=rater,
                valid=bool(row["score"] >= CUT), score=row["score"] / 100 if graded else None,
            )
        )  # fmt: skip
    return DemonstrationSet(
        tuple(scenes),
        Demonstrations.of(items),
        name=f"SocNav1 {rater}",
        units="m",
        metres_per_unit=1.0,
        symbols=SYMBOLS,
        types=(rater,),
    )


def distances(data: DemonstrationSet) -> np.ndarray:
    """(n, 2) metres to the nearest person and thing."""
    paths = data.demonstrations.paths_xy()
    return np.concatenate(
        [
            nearest_approach(scene, [path], SYMBOLS, distance="center")
            for scene, path in zip(data.scenes, paths, strict=True)
        ]
    )


def balanced(said: np.ndarray, truth: np.ndarray) -> float:
    """Balanced accuracy."""
    return float((said[truth].mean() + (~said[~truth]).mean()) / 2)


def part(data: DemonstrationSet, rows: np.ndarray) -> DemonstrationSet:
    """Some ratings and their scenes only."""
    return replace(
        data,
        scenes=tuple(data.scenes[i] for i in rows),
        demonstrations=data.demonstrations.rows(rows),
    )


def boosted(x: np.ndarray, y: np.ndarray, new: np.ndarray) -> np.ndarray | None:
    """Verdicts of gradient boosting on the same distances; None without scikit-learn."""
    try:
        from sklearn.ensemble import HistGradientBoostingClassifier
    except ImportError:
        return None
    if y.all() or not y.any():
        return np.full(len(new), bool(y.all()))
    model = HistGradientBoostingClassifier(max_iter=60, min_samples_leaf=5, random_state=0)
    return np.asarray(model.fit(np.minimum(x, 9.0), y).predict(np.minimum(new, 9.0)))


@dataclass
class Tally:
    """What the draws of one number of labels gave, learned in one way."""

    accuracy: list[float] = field(default_factory=list)
    held: list[bool] = field(default_factory=list)
    width: list[float] = field(default_factory=list)

    def add(self, rule: ClearanceRule, near: np.ndarray, label: np.ndarray, kept: float) -> None:
        """A rule, judged by other ratings of the rater and by all of them (`kept`)."""
        limit = np.array([rule.value.get(s, -np.inf) for s in SYMBOLS])
        self.accuracy.append(balanced((near >= limit).all(axis=1), label))
        low, high = rule.interval.get("human", (np.inf, -np.inf))
        self.held.append(low <= kept <= high)
        if low <= high:
            self.width.append(high - low)

    def to_json(self) -> dict[str, Any]:
        return {
            "balanced_accuracy": round(float(np.mean(self.accuracy)), 4),
            "holds": f"{sum(self.held)} of {len(self.held)}",
            "width_m": round(float(np.median(self.width)), 3) if self.width else None,
        }


def clearance_of(data: DemonstrationSet) -> ClearanceRule:
    """The clearances of the only person of a set."""
    (rules,) = learn_rules(data, distance="center", influence=False).rules.values()
    assert rules.clearance is not None
    return rules.clearance


def rows_of(rater: str, rows: list[dict[str, Any]], counts: list[int], draws: int
            ) -> Iterator[dict[str, Any]]:  # fmt: skip
    """One line for each number of labels."""
    cut, graded = as_set(rows, rater), as_set(rows, rater, graded=True)
    near, label = distances(cut), cut.demonstrations.valid == 1
    kept = clearance_of(cut).value.get("human", float("nan"))
    for count in counts:
        if count > len(rows) - 100:
            continue
        of_cut, of_grades, boost = Tally(), Tally(), []
        for draw in range(draws):
            chosen = np.random.default_rng([draw, count]).permutation(len(rows))
            mine, rest = np.sort(chosen[:count]), chosen[count:]
            for tally, data in ((of_cut, cut), (of_grades, graded)):
                tally.add(clearance_of(part(data, mine)), near[rest], label[rest], kept)
            other = boosted(near[mine], label[mine], near[rest])
            if other is not None:
                boost.append(balanced(other, label[rest]))
        yield {
            "rater": rater,
            "labels": count,
            **of_cut.to_json(),
            "graded": of_grades.to_json(),
            "boosting": round(float(np.mean(boost)), 4) if boost else None,
            "long_run_m": round(float(kept), 3),
        }


def agreement(every: dict[str, list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """Balanced agreement of every two raters on places that both saw."""
    seen = {
        name: {json.dumps([r[k] for k in PLACE]): r["score"] >= CUT for r in rows}
        for name, rows in every.items()
    }
    out = []
    for a in seen:
        for b in seen:
            both = sorted(set(seen[a]) & set(seen[b]))
            if a < b and len(both) >= 50:
                one, other = (np.array([seen[n][k] for k in both]) for n in (a, b))
                out.append({"raters": f"{a}, {b}", "places": len(both),
                            "balanced_agreement": round(balanced(one, other), 4)})  # fmt: skip
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--socnav", type=Path)
    parser.add_argument("--counts", type=int, nargs="+", default=[20, 60, 150, 300])
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--raters", nargs="+")
    args = parser.parse_args()
    if args.socnav is None or not args.socnav.is_dir():
        print("no folder of ratings (--socnav FOLDER): nothing measured")
        return
    every = ratings(args.socnav)
    table = []
    for name, rows in every.items():
        if args.raters and name not in args.raters:
            continue
        for line in rows_of(name, rows, args.counts, args.draws):
            print(json.dumps(line), flush=True)
            table.append(line)
    pairs = agreement(every)
    for line in pairs:
        print(json.dumps(line))
    out = Path(__file__).parent / "results" / "people.json"
    document = {"machine": platform.processor(), "raters": table, "agreement": pairs}
    out.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
