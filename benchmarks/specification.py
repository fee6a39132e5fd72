"""Specification models: speed on one core, and identification against ground-truth rules.

    python benchmarks/specification.py speed
    python benchmarks/specification.py identify
    python benchmarks/specification.py grid --seeds 2 --counts 1,3,9 --reading clustered

Each study writes its part of benchmarks/results/specification.json. CPU times are process
times on one thread. The grid appends finished fits to benchmarks/results/grid-READING.jsonl and
goes on where it stopped.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

from demospec.demonstrations import (  # noqa: E402
    Demonstration,
    Demonstrations,
    bezier_points,
    simulate_set,
)
from demospec.rules import rules_from_document  # noqa: E402
from demospec.specification import (  # noqa: E402
    ControlPlane,
    RepairSettings,
    fit_model,
    plane_bounds,
    repair,
    validity_map,
)
from demospec.specification.evaluation._identify import Acceptances, acceptances, type_posterior  # noqa: E402

RESULTS = Path(__file__).parent / "results"
KS = (1, 3, 5, 10, 20)


def cpu(work: Callable[[], Any], repeats: int = 5) -> float:
    """Least process time of some runs, seconds."""
    work()
    best = np.inf
    for _ in range(repeats):
        began = time.process_time()
        work()
        best = min(best, time.process_time() - began)
    return best


def speed(arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """Fit, look, map, logits and repairs."""
    data, document = simulate_set(demonstrations=9, test_scenes=4, seed=arguments.seed)
    truth, train = rules_from_document(document), data.of_split("train")
    scene = data.of_split("test").scenes[0]
    rng = np.random.default_rng(0)
    rows = []
    for kind in ("paper", "field", "irl"):
        began = time.process_time()
        model = fit_model(train, kind, seed=0)
        fit_s = time.process_time() - began
        blind = replace(scene, objects=None)
        view = model.see(blind)
        z = rng.uniform(0, 100, (20_000, 1, 2))
        ends = np.tile(np.asarray(scene.start), (len(z), 1))
        paths = bezier_points(ends, np.asarray(scene.goal), z, 100)
        rejected = z[np.flatnonzero(truth.see(scene).logits(paths[:4000], "careful") <= 0)[:256]]
        one = RepairSettings(particles=1)
        rows.append(
            {
                "model": kind,
                "fit_s": fit_s,
                "see_ms": 1e3 * cpu(lambda m=model, s=blind: m.see(s)),
                "map_51_ms": 1e3 * cpu(lambda v=view: validity_map(v, "careful")),
                "path_logits_per_s": len(z) / cpu(lambda v=view, p=paths: v.logits(p, "careful")),
                "repairs_256_ms": 1e3
                * cpu(lambda v=view, r=rejected, s=one: repair(v, r, "careful", settings=s)),
            }
        )
    print("model  fit s  see ms  map 51x51 ms  path logits/s  256 repairs ms (one particle)")
    for r in rows:
        print(
            f"{r['model']:<5} {r['fit_s']:>6.1f} {r['see_ms']:>7.2f} {r['map_51_ms']:>13.2f} "
            f"{r['path_logits_per_s']:>14,.0f} {r['repairs_256_ms']:>15.1f}"
        )
    return rows


def identify(arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """Share of demonstrators whose type is found from k accepted, unlabelled demonstrations."""
    data, document = simulate_set(
        demonstrations=9, test_scenes=30, seed=arguments.seed, catalogue=arguments.catalogue
    )
    truth = rules_from_document(document)
    test = data.of_split("test")
    rng = np.random.default_rng([arguments.seed, 5])
    items = []
    for type_ in data.types:
        for scene in test.scenes:
            plane = ControlPlane(truth.see(scene))
            x0, y0, x1, y1 = plane_bounds(scene)
            z = rng.uniform((x0, y0), (x1, y1), (300, 1, 2))
            z = z[plane.logits(z, type_) > 0][:12]
            items += [
                Demonstration(f"{type_}{scene.scene_id}-{k}", scene.scene_id, path, None, type_)
                for k, path in enumerate(plane.paths(z))
            ]
    shown = replace(test, demonstrations=Demonstrations.of(items))
    blind = replace(shown, scenes=tuple(replace(s, objects=None) for s in shown.scenes))
    rows = []
    for kind in ("truth", "field", "paper"):
        if kind == "truth":
            found, judged, _ = acceptances(truth, shown)
        else:
            model = fit_model(data.of_split("train"), kind, seed=arguments.seed)
            found, judged, _ = acceptances(model, blind)
        who = shown.demonstrations.demonstrator[judged]
        row: dict[str, Any] = {"model": kind}
        for k in KS:
            row[str(k)] = _found_share(found, who, k, np.random.default_rng([arguments.seed, k]))
        rows.append(row)
    print("types found from k demonstrations, 600 demonstrators a type")
    print("model " + "".join(f"{k:>8}" for k in KS))
    for row in rows:
        print(f"{row['model']:<6}" + "".join(f"{row[str(k)]:>8.1%}" for k in KS))
    return rows


def _found_share(found: Acceptances, who: Any, k: int, rng: np.random.Generator) -> float:
    right = total = 0
    for t, type_ in enumerate(found.types):
        mine = np.flatnonzero(who == type_)
        for _ in range(600):
            chosen = rng.choice(mine, size=k, replace=False)
            right += int(np.argmax(type_posterior(found.rows(chosen))) == t)
            total += 1
    return right / total


def grid(arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """A part of the paper's ablation grid, or all of it."""
    from demospec.experiments import GridSettings, grid_table, run_grid

    settings = GridSettings(
        models=tuple(arguments.models.split(",")),
        counts=tuple(int(n) for n in arguments.counts.split(",")),
        seeds=tuple(range(arguments.seeds)),
        reading=arguments.reading,
        catalogue=arguments.catalogue,
    )
    RESULTS.mkdir(exist_ok=True)
    file = RESULTS / f"grid-{arguments.reading}.jsonl"
    rows = grid_table(run_grid(file, settings, workers=arguments.workers))
    print("model        n  type        acc seen  bacc seen  far   | acc unseen  bacc unseen  far")
    for r in rows:
        numbers = [
            "   –" if r[key] is None else f"{r[key]:.2f}"
            for key in (
                "accuracy_seen", "bacc_seen", "bacc_seen_far",
                "accuracy_unseen", "bacc_unseen", "bacc_unseen_far",
            )
        ]  # fmt: skip
        print(f"{r['model']:<12} {r['n']}  {r['type']:<10}  " + "      ".join(numbers))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study", choices=("speed", "identify", "grid"))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--counts", default="1,3,9")
    parser.add_argument("--models", default="full,autoencoder,classifier,irl")
    parser.add_argument("--reading", default="uniform")
    parser.add_argument("--catalogue", default="builtin")
    parser.add_argument("--workers", type=int, default=1)
    arguments = parser.parse_args()
    rows = {"speed": speed, "identify": identify, "grid": grid}[arguments.study](arguments)
    name = arguments.study + (f"-{arguments.reading}" if arguments.study == "grid" else "")
    file = RESULTS / "specification.json"
    RESULTS.mkdir(exist_ok=True)
    report = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    report[name] = {
        "command": "python " + " ".join(sys.argv),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, one thread",
        "versions": {n: version(n) for n in ("demospec", "numpy", "torch")},
        "rows": rows,
    }
    file.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
