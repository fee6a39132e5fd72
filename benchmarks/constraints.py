"""Does it find what people ask for besides distance? Simulated people with random thresholds.

    OMP_NUM_THREADS=1 python benchmarks/constraints.py [--people 40] [--features tilt] [--scenes 5]
    OMP_NUM_THREADS=1 python benchmarks/constraints.py --placebo [--people 40]
    OMP_NUM_THREADS=1 python benchmarks/constraints.py --socnav FOLDER [--draws 4]

A table of discs with headings, heights and a relation (benchmarks/worlds.py); nine
demonstrations a scene. For each feature: how often the right constraint is named (and nothing
else), how often its interval holds the true value, balanced accuracy on ten unseen scenes, and
CPU seconds. Where one distance contradicts no label (`one_distance_explains_all`), nothing else
is looked for: the labels do not tell the two apart. Pairs: how often both are named. Placebo:
people who keep a distance, exactly, with a soft threshold, with slips or with reasons that
nothing shows, and whose answers go with nothing else: how often a constraint is named all the
same.

FOLDER holds the ratings of SocNav1 (see people.py). Each rater's rule is learned from a part of
their ratings, with and without the relations that the scenes note (who interacts with whom or
what), and judged on the others; `everybody` is all raters as one.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import people
import worlds

from demospec.demonstrations import DemonstrationSet
from demospec.rules import Constraint, When, learn_rules, margins
from demospec.scene import Relation

EACH = 9
UNSEEN = 10

SINGLE: dict[str, Constraint] = {
    "near": Constraint("near", "glass", "at_most"),
    "between": Constraint("between", "interact"),
    "front": Constraint("distance", "glass", sector="front"),
    "left": Constraint("distance", "glass", sector="left"),
    "+y": Constraint("distance", "glass", sector="+y"),
    "height": Constraint("height"),
    "height_over": Constraint("height_over", "plate"),
    "tilt": Constraint("tilt", None, "at_most", unit="deg"),
    "speed": Constraint("speed", None, "at_most", unit="px/s"),
    "speed near": Constraint("speed", None, "at_most", unit="px/s", when=When(0.0, "glass")),
    "dwell": Constraint("dwell", "glass", "at_most", unit="s", when=When(0.0, "glass")),
    "length": Constraint("length", None, "at_most"),
    "duration": Constraint("duration", None, "at_most", unit="s"),
    "curvature": Constraint("curvature", None, "at_most", unit="deg"),
    "edge": Constraint("edge"),
}

PAIRS: dict[str, tuple[Constraint, Constraint]] = {
    "distance and speed": (Constraint("distance", "glass"), SINGLE["speed"]),
    "height and distance": (SINGLE["height"], Constraint("distance", "plate")),
    "side and between": (SINGLE["front"], SINGLE["between"]),
    "distance and tilt": (Constraint("distance", "bowl"), SINGLE["tilt"]),
}


def table(rng: np.random.Generator, scenes: int) -> DemonstrationSet:
    """Scenes with headings, heights, a relation and a table's edge; paths with z, tilt, times."""
    world = worlds.make_world(rng, scenes, EACH)
    data = worlds.as_set(world, np.ones(len(world.scene), dtype=bool), worlds.KINDS["one class"])
    out = []
    for scene in data.scenes:
        objects = [
            replace(o, heading_deg=float(rng.uniform(-180, 180)), height=(0.0, float(top)))
            for o, top in zip(scene.objects or (), rng.uniform(4, 14, 99), strict=False)
        ]
        one, other = rng.permutation(len(objects))[:2]
        (left, low), (right, high) = -rng.uniform(0, 20, 2), 100 + rng.uniform(0, 20, 2)
        out.append(replace(
            scene, objects=tuple(objects),
            relations=(Relation("interact", (objects[one].id, objects[other].id)),),
            extra=(("regions", {"table": [
                [left, low], [right, low], [right, high], [left, high]]}),),
        ))  # fmt: skip
    return replace(data, scenes=tuple(out))


def values(data: DemonstrationSet, asked: Sequence[Constraint]) -> np.ndarray:
    """(n, k) margins under constraints of value 0, turned so that more is safer."""
    motions = data.motions().motions
    ids = data.demonstrations.scene_id
    zero = [replace(c, value=0.0) for c in asked]
    return np.concatenate(
        [margins(zero, data.scene(s), [m]) for m, s in zip(motions, ids, strict=True)]
    )


def person(
    asked: Sequence[Constraint], seed: int, scenes: int
) -> tuple[DemonstrationSet, DemonstrationSet, list[Constraint]]:
    """A person with random thresholds: what they showed, unseen scenes, and what they ask for."""
    rng = np.random.default_rng([seed, scenes, *map(ord, "".join(c.name for c in asked))])
    data, unseen = table(rng, scenes), table(rng, UNSEEN)
    drawn = [
        c if c.when is None else replace(c, when=When(float(rng.uniform(6, 20)), c.when.of))
        for c in asked
    ]
    columns = values(unseen, drawn)
    truth = []
    share = (0.35, 0.65) if len(asked) == 1 else (0.2, 0.4)
    for c, column in zip(drawn, columns.T, strict=True):
        # Among different values: many paths cross a line, or never come near, alike; a
        # threshold at that value asks for nothing, or for a distance.
        finite = np.unique(np.round(column[np.isfinite(column)], 6))
        at = float(np.quantile(finite, rng.uniform(*share)))
        truth.append(replace(c, value=c.sign * at))
    return labelled(data, truth), labelled(unseen, truth), truth


def labelled(data: DemonstrationSet, truth: Sequence[Constraint]) -> DemonstrationSet:
    """The same paths, with the labels of who asks for these."""
    kept = np.all([values(data, [c])[:, 0] >= c.sign * c.value for c in truth], axis=0)
    return with_labels(data, kept)


def with_labels(data: DemonstrationSet, valid: np.ndarray) -> DemonstrationSet:
    d = data.demonstrations.rows(np.arange(len(data.demonstrations)))
    d.valid = valid.astype(np.int8)
    return replace(data, demonstrations=d)


def same(found: Constraint, true: Constraint) -> bool:
    """Whether two speak of one thing (a radius may differ)."""
    of = {frozenset(c.of) if isinstance(c.of, tuple) else c.of for c in (found, true)}
    when = {c.when and c.when.of for c in (found, true)}
    return (found.feature, found.sense, found.sector) == (true.feature, true.sense, true.sector) \
        and len(of) == 1 and len(when) == 1  # fmt: skip


def one(asked: Sequence[Constraint], seed: int, scenes: int) -> dict[str, Any]:
    """What is learned of one person."""
    data, unseen, truth = person(asked, seed, scenes)
    began = time.process_time()
    rules = learn_rules(data, influence=False)
    seconds = time.process_time() - began
    own = rules.of_type("someone")
    distances = [t for t in truth if t.feature == "distance" and t.sector is None]
    others = [t for t in truth if t not in distances]
    named = [next((c for c in own.constraints if same(c, t)), None) for t in others]
    value = own.clearance.value if own.clearance is not None else {}
    right = all(n is not None for n in named) and len(own.constraints) == len(others)
    right = right and all(t.of in value for t in distances)
    held = [
        n is not None and n.interval is not None and n.interval[0] <= t.value <= n.interval[1]
        for n, t in zip(named, others, strict=True)
    ]
    d = unseen.demonstrations
    said = np.zeros(len(d), dtype=bool)
    for scene_id, rows in unseen.rows_by_scene().items():
        view = rules.see(unseen.scene(scene_id))
        said[rows] = view.logits(unseen.motions(rows), "someone") > 0
    valid = d.valid == 1
    rates = [float((said == valid)[valid == label].mean()) for label in (True, False)
             if (valid == label).any()]  # fmt: skip
    return {
        "right": right, "held": held, "balanced": float(np.mean(rates)), "seconds": seconds,
        "named": [c.name for c in own.constraints],
        "learned": [[c.value, c.interval, c.when and c.when.within] for c in own.constraints],
        "distance": dict(value),
        "gain": own.evidence.get("constraints", {}).get("gain_nats"),
    }  # fmt: skip


def study(name: str, asked: Sequence[Constraint], people: int, scenes: int) -> dict[str, Any]:
    """Many people who ask for the same thing, each with thresholds of their own."""
    runs = [one(asked, seed, scenes) for seed in range(people)]
    held = [h for run in runs if run["right"] for h in run["held"]]
    return {
        "asked": name,
        "scenes": scenes,
        "people": people,
        "right": f"{sum(r['right'] for r in runs)} of {people}",
        "one_distance_explains_all": sum(not r["right"] and r["gain"] is None for r in runs),
        "interval_holds": f"{sum(held)} of {len(held)}",
        "balanced_accuracy": round(float(np.mean([r["balanced"] for r in runs])), 4),
        "seconds": round(float(np.mean([r["seconds"] for r in runs])), 2),
        "others_named": sorted({n for r in runs if not r["right"] for n in r["named"]}),
    }


def placebo(seed: int, scenes: int) -> tuple[list[str], float]:
    """A person who keeps a distance only: constraints that are named, CPU seconds."""
    rng = np.random.default_rng([seed, scenes, 77])
    data = table(rng, scenes)
    symbol = str(rng.choice(worlds.CLASSES))
    near = values(data, [Constraint("distance", symbol)])[:, 0]
    at = float(np.quantile(near[np.isfinite(near)], rng.uniform(0.25, 0.6)))
    kind = seed % 5
    sd = float(rng.uniform(0.5, 3.0)) if kind == 1 else 0.0
    valid = near + sd * rng.standard_normal(len(near)) >= at
    if kind == 2:
        valid ^= rng.random(len(valid)) < 0.1
    if kind == 3:  # nothing but chance
        valid = rng.random(len(valid)) < rng.uniform(0.3, 0.7)
    if kind == 4:  # rejects for a reason that nothing shows, too
        valid &= rng.random(len(valid)) > rng.uniform(0.1, 0.4)
    began = time.process_time()
    own = learn_rules(with_labels(data, valid), influence=False).of_type("someone")
    return [c.name for c in own.constraints], time.process_time() - began


def related(rows: list[dict[str, Any]], rater: str, *, relations: bool) -> DemonstrationSet:
    """Ratings as a set, with the relations of each scene where asked."""
    data = people.as_set(rows, rater)
    if not relations:
        return data
    scenes = []
    for scene, row in zip(data.scenes, rows, strict=True):
        ids = {o.id.split("-")[1]: o.id for o in scene.objects or ()}
        pairs = {frozenset((ids[str(a)], ids[str(b)])) for a, b, _ in row["links"]
                 if a != b and {str(a), str(b)} <= set(ids)}  # fmt: skip
        noted = (sorted(pair) for pair in pairs)
        found = tuple(Relation("interact", (one, other)) for one, other in sorted(noted))
        scenes.append(replace(scene, relations=found))
    return replace(data, scenes=tuple(scenes))


def raters(folder: Path, draws: int, counts: Sequence[int]) -> Iterator[dict[str, Any]]:
    """One line for each rater, number of ratings learned from, with and without relations."""
    every = people.ratings(folder)
    everybody = [row for rows in every.values() for row in rows]
    for name, rows in {**every, "everybody": everybody}.items():
        for count in [*(c for c in counts if c < len(rows) // 2), min(len(rows) // 2, 1250)]:
            for relations in (False, True):
                data = related(rows, name, relations=relations)
                place = [json.dumps([row[k] for k in people.PLACE]) for row in rows]
                accuracy, named = [], []
                for draw in range(draws):
                    order = np.random.default_rng([draw, count]).permutation(len(rows))
                    mine = np.sort(order[:count])
                    seen = {place[i] for i in mine}
                    rest = np.array([i for i in order[count:] if place[i] not in seen])
                    rules = learn_rules(people.part(data, mine), distance="center", influence=False)
                    said = np.array([
                        rules.see(data.scenes[i]).logits(data.motions(np.array([i])), name)[0] > 0
                        for i in rest
                    ])  # fmt: skip
                    truth = data.demonstrations.valid[rest] == 1
                    accuracy.append(people.balanced(said, truth))
                    named.append([c.name for c in rules.of_type(name).constraints])
                yield {
                    "rater": name, "ratings": count, "relations": relations, "draws": draws,
                    "balanced_accuracy": round(float(np.mean(accuracy)), 4),
                    "between_named": sum(any("between" in n for n in own) for own in named),
                    "others_named": sorted({n for own in named for n in own if "between" not in n}),
                }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--people", type=int, default=40)
    parser.add_argument("--scenes", type=int, nargs="+", default=[20, 5])
    parser.add_argument("--features", nargs="+", default=[*SINGLE, *PAIRS])
    parser.add_argument("--placebo", action="store_true")
    parser.add_argument("--socnav", type=Path)
    parser.add_argument("--draws", type=int, default=4)
    parser.add_argument("--counts", type=int, nargs="*", default=[150])
    args = parser.parse_args()
    if args.socnav is not None:
        lines = []
        for line in raters(args.socnav, args.draws, args.counts):
            print(json.dumps(line), flush=True)
            lines.append(line)
        out = Path(__file__).parent / "results" / "constraints_socnav.json"
        out.write_text(json.dumps({"raters": lines}, indent=1) + "\n")
        return
    rows: list[dict[str, Any]] = []
    for scenes in args.scenes:
        if args.placebo:
            runs = [placebo(seed, scenes) for seed in range(args.people)]
            wrong = [named for named, _ in runs if named]
            rows.append({
                "asked": "distance only", "scenes": scenes, "people": args.people,
                "named_all_the_same": f"{len(wrong)} of {args.people}", "which": wrong,
                "seconds": round(float(np.mean([s for _, s in runs])), 2),
            })  # fmt: skip
            print(json.dumps(rows[-1]), flush=True)
            continue
        for name in args.features:
            asked = (SINGLE[name],) if name in SINGLE else PAIRS[name]
            rows.append(study(name, asked, args.people, scenes))
            print(json.dumps(rows[-1]), flush=True)
    if args.people >= 40:
        keep(rows)


def keep(rows: list[dict[str, Any]]) -> None:
    """Rows in place of those of the same people in the results: features may be run in parts."""
    out = Path(__file__).parent / "results" / "constraints.json"
    old = json.loads(out.read_text())["rows"] if out.exists() else []
    known = {(row["asked"], row["scenes"]): row for row in (*old, *rows)}
    order = ["distance only", *SINGLE, *PAIRS]
    chosen = sorted(known.values(), key=lambda row: (-row["scenes"], order.index(row["asked"])))
    out.write_text(json.dumps({"rows": chosen}, indent=1) + "\n")


if __name__ == "__main__":
    main()
