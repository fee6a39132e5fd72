"""The field model on unseen scenes with unseen items: how right, and which half loses.

    python benchmarks/field.py --seeds 100,101,102 --counts 1,3,9
    python benchmarks/field.py --seeds 100,101,102 --counts 9 --cross
    python benchmarks/field.py --seeds 100,101,102 --counts 9 --fine-tune

Every model is fitted to 20 listed training scenes and judges 20 test scenes, whose items have
other looks, from their pictures alone. Judged are `--curves` random Bézier curves a scene, by
the rule that made the labels. Rows are appended to benchmarks/results/field.json, one a fit;
what is there already for the same network and settings is not computed again. Seeds below 100
were used to develop the model; report others only.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

from demospec.demonstrations import bezier_points, simulate_set  # noqa: E402
from demospec.files import write_json  # noqa: E402
from demospec.perception import load_network, match_detections  # noqa: E402
from demospec.rules import nearest_approach, rules_from_document  # noqa: E402
from demospec.specification.models.perceived_rule._model import FieldModel  # noqa: E402
from demospec.specification.models.perceived_rule._observation import listed_objects  # noqa: E402
from demospec.specification.models.perceived_rule._view import FieldView, PerceivedObject  # noqa: E402

RESULTS = Path(__file__).parent / "results" / "field.json"
WAYS = ("seen", "true distance", "true class", "none missed", "all true", "listed")


def hashed(path: Path | None) -> str:
    """Eight letters of the network's hash."""
    import hashlib

    from demospec.perception import SHIPPED

    return hashlib.sha256(Path(path or SHIPPED).read_bytes()).hexdigest()[:8]


def views_of(model: FieldModel, scene: Any) -> tuple[dict[str, FieldView], dict[str, Any]]:
    """The scene in every way of `WAYS`, and what perception got wrong."""
    seen = model.see(replace(scene, objects=None))
    observation = model.look(scene)
    owner, largest = match_detections(observation, scene.objects)
    exact = listed_objects(scene, seen.size, seen.shape)
    bare = PerceivedObject(np.full(seen.shape, 1e3, np.float32), {}, 1.0, (0.0, 0.0), False)

    def built(distance: bool, symbol: bool, missed: bool) -> FieldView:
        parts = []
        for i, part in enumerate(seen.perceived):
            mine = exact[owner[i]] if owner[i] >= 0 else None
            if symbol:
                part = replace(part, classes={} if mine is None else mine.classes)
            if distance and mine is not None:
                part = replace(part, distance=mine.distance, error=mine.error)
            elif distance and symbol:
                part = bare
            parts.append(part)
        if missed:
            parts += [exact[k] for k in np.flatnonzero(largest < 0)]
        return replace(seen, parts=tuple(parts), _maps={})

    views = {
        "seen": seen,
        "true distance": built(True, False, False),
        "true class": built(False, True, False),
        "none missed": built(False, False, True),
        "all true": built(True, True, True),
        "listed": model.see(scene, use_lists=True),
    }
    guess = [max(p.classes, key=lambda n: p.classes[n], default="") if
             sum(p.classes.values()) > 0.5 else "" for p in seen.perceived]  # fmt: skip
    errors: dict[str, Any] = {
        "confusion": [(scene.objects[k].symbol, guess[largest[k]] if largest[k] >= 0 else "missed")
                      for k in range(len(scene.objects))],
        "false": int(sum(owner[i] < 0 and guess[i] != "" for i in range(len(guess)))),
        "bias": [],
    }  # fmt: skip
    rng = np.random.default_rng(5)
    size = np.array(scene.size_px)
    control = rng.uniform(-0.2, 1.2, (100, 1, 2)) * size
    curves = bezier_points(scene.start[:2], scene.goal[:2], control, 60)
    from demospec.perception import read_map

    for k, item in enumerate(scene.objects):
        if largest[k] < 0:
            continue
        alone = scene.with_changes(objects=(item,), picture=None)
        true = nearest_approach(alone, curves, (item.symbol,))[:, 0]
        close = (true > 1.0) & (true < 7.0)
        part = seen.perceived[largest[k]]
        near = read_map(part.distance, curves[close], seen.size).min(axis=1)
        errors["bias"] += [(item.symbol, float(g)) for g in near - true[close]]
    return views, errors


def balanced(said: np.ndarray, true: np.ndarray) -> float | None:
    """Mean of the two rates, per cent."""
    if true.all() or not true.any():
        return None
    return 50.0 * float(said[true].mean() + (~said[~true]).mean())


def one(arguments: argparse.Namespace, catalogue: str, count: int, seed: int) -> list[dict]:
    """Fits once; a row for every test catalogue."""
    made = {c: simulate_set(catalogue=c, train_scenes=20, test_scenes=20, demonstrations=count,
                            seed=seed) for c in {catalogue, *arguments.test_on}}  # fmt: skip
    train = made[catalogue][0].of_split("train")
    network = load_network() if arguments.network is None else load_network(arguments.network)
    began = time.process_time()
    model = FieldModel.fit(train, network=network, seed=0, fine_tune=arguments.fine_tune)
    fit_s = time.process_time() - began
    rows = []
    for other in [catalogue, *arguments.test_on]:
        data, document = made[other]
        truth = rules_from_document(document)
        said: dict[tuple[str, str], list] = {}
        margins: dict[str, list] = {}
        confusion: dict[str, dict[str, int]] = {}
        bias: dict[str, list] = {}
        false = 0
        scenes = data.of_split("test").scenes
        for number, scene in enumerate(scenes):
            rng = np.random.default_rng([seed, number])
            control = rng.uniform(0, 1, (arguments.curves, 1, 2)) * np.array(scene.size_px)
            paths = bezier_points(scene.start[:2], scene.goal[:2], control, 100)
            views, errors = views_of(model, scene)
            exact = truth.see(scene)
            for type_ in model.types:
                margins.setdefault(type_, []).append(exact.logits(paths, type_))
                for way in WAYS:
                    found = views[way].logits(paths, type_) > 0
                    said.setdefault((type_, way), []).append(found)
            for true, guess in errors["confusion"]:
                line = confusion.setdefault(true, {})
                line[guess] = line.get(guess, 0) + 1
            for name, gap in errors["bias"]:
                bias.setdefault(name, []).append(gap)
            false += errors["false"]
        scores: dict[str, Any] = {}
        for type_ in model.types:
            margin = np.concatenate(margins[type_])
            true = margin > 0
            far = np.abs(margin) > 2.0
            scores[type_] = {
                way: [
                    balanced(np.concatenate(said[type_, way]), true),
                    balanced(np.concatenate(said[type_, way])[far], true[far]),
                ]
                for way in WAYS
            }
        rows.append({
            "train": catalogue, "test": other, "n": count, "seed": seed,
            "fine_tune": arguments.fine_tune, "network": hashed(arguments.network),
            "note": arguments.note, "fit_cpu_s": round(fit_s, 2), "scores": scores,
            "rules": {t: {n: round(c, 2) for n, c in r.clearance.value.items()}
                      for t, r in model.rules.rules.items()},
            "confusion": confusion, "false_per_scene": false / len(scenes),
            "bias_px": {k: [round(float(np.median(v)), 3), round(float(np.std(v)), 3)]
                        for k, v in bias.items()},
        })  # fmt: skip
    return rows


def show(rows: list[dict]) -> None:
    """Means over seeds, a line for each setting, type and way."""
    keys = sorted({(r["train"], r["test"], r["n"], r["fine_tune"], r["network"], r["note"])
                   for r in rows}, key=str)  # fmt: skip
    for key in keys:
        mine = [r for r in rows if key == (r["train"], r["test"], r["n"], r["fine_tune"],
                                           r["network"], r["note"])]  # fmt: skip
        fit = np.mean([r["fit_cpu_s"] for r in mine])
        print(f"{key[0]}→{key[1]} n={key[2]} tuned={key[3]} network={key[4]} {key[5]}  "
              f"seeds={[r['seed'] for r in mine]} fit {fit:.1f} s "
              f"false {np.mean([r['false_per_scene'] for r in mine]):.2f}")  # fmt: skip
        for type_ in mine[0]["scores"]:
            cells = []
            for way in WAYS:
                pairs = [r["scores"][type_][way] for r in mine if type_ in r["scores"]]
                pairs = [p for p in pairs if p[0] is not None and p[1] is not None]
                if pairs:
                    a, b = np.mean(pairs, axis=0)
                    cells.append(f"{way} {a:.1f}/{b:.1f}")
            print(f"   {type_:10s} " + "  ".join(cells) if cells else f"   {type_}: one class")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--catalogues", default="builtin,sweethome3d")
    parser.add_argument("--counts", default="9")
    parser.add_argument("--seeds", default="100,101,102")
    parser.add_argument("--curves", type=int, default=200)
    parser.add_argument("--cross", action="store_true", help="also test on the other catalogues")
    parser.add_argument("--fine-tune", action="store_true")
    parser.add_argument("--network", type=Path, default=None)
    parser.add_argument("--note", default="")
    parser.add_argument("--out", type=Path, default=RESULTS)
    parser.add_argument("--show", action="store_true", help="only print what was recorded")
    arguments = parser.parse_args()
    import torch

    torch.set_num_threads(1)
    old = json.loads(arguments.out.read_text())["rows"] if arguments.out.exists() else []
    if arguments.show:
        show(old)
        return
    catalogues = arguments.catalogues.split(",")
    new = []
    for seed in map(int, arguments.seeds.split(",")):
        for count in map(int, arguments.counts.split(",")):
            for catalogue in catalogues:
                arguments.test_on = [c for c in catalogues if c != catalogue and arguments.cross]
                want = {
                    "train": catalogue,
                    "n": count,
                    "seed": seed,
                    "note": arguments.note,
                    "fine_tune": arguments.fine_tune,
                    "network": hashed(arguments.network),
                }
                done = {r["test"] for r in old if all(r[k] == v for k, v in want.items())}
                if done >= {catalogue, *arguments.test_on}:
                    continue
                rows = one(arguments, catalogue, count, seed)
                new += rows
                old = [r for r in old if not (all(r[k] == v for k, v in want.items())
                       and r["test"] in {x["test"] for x in rows})] + rows  # fmt: skip
                show(rows)
                sys.stdout.flush()
                versions = {n: version(n) for n in ("demospec", "numpy", "scipy", "torch")}
                write_json(arguments.out, {
                    "command": "python benchmarks/field.py " + " ".join(sys.argv[1:]),
                    "machine": f"{platform.machine()}, one thread", "versions": versions,
                    "curves_per_scene": arguments.curves, "rows": old,
                })  # fmt: skip
    if new:
        print("\nmeans over seeds")
        show(new)


if __name__ == "__main__":
    main()
