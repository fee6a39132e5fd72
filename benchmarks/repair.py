"""Repair judged by the rule that made the labels, on unseen scenes with unseen items.

    python benchmarks/repair.py                   # truth, field and paper as models; about 5 min
    python benchmarks/repair.py --models truth --scenes 20

Starts are invalid control points, uniform over the z_θ plane, in scenes in which a valid
solution exists; the model sees the picture only (objects not listed), except the truth. The
least possible displacement is that to the nearest valid point of a 2 px grid over the plane,
or to the nearest repair by any model that the truth accepts, whichever is smaller.
Writes benchmarks/results/repair.json.
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

from demospec.demonstrations import simulate_set  # noqa: E402
from demospec.rules import rules_from_document  # noqa: E402
from demospec.specification import (  # noqa: E402
    ControlPlane,
    RepairSettings,
    fit_model,
    plane_bounds,
    repair,
)

RESULTS = Path(__file__).parent / "results" / "repair.json"
GRID_PX = 2.0


def starts_of(truth: Any, scene: Any, type_: str, each: int, rng: np.random.Generator) -> Any:
    """Invalid control points, and the valid ones of a grid; None where nothing is valid."""
    plane = ControlPlane(truth.see(scene))
    x0, y0, x1, y1 = plane_bounds(scene)
    axes = [np.arange(low, high + 1e-9, GRID_PX) for low, high in ((x0, x1), (y0, y1))]
    grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 1, 2)
    valid = grid[plane.logits(grid, type_) > 0]
    if not len(valid):
        return None
    z = rng.uniform((x0, y0), (x1, y1), (40 * each, 1, 2))
    return z[plane.logits(z, type_) <= 0][:each], valid


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", default="truth,field,paper")
    parser.add_argument("--catalogue", default="builtin")
    parser.add_argument("--scenes", type=int, default=50)
    parser.add_argument("--each", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--particles", default="1,8,16,32")
    parser.add_argument("--confidence", type=float, default=RepairSettings().confidence)
    parser.add_argument("--step", type=float, default=RepairSettings().step)
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    data, document = simulate_set(
        catalogue=arguments.catalogue,
        train_scenes=20,
        test_scenes=arguments.scenes,
        demonstrations=9,
        seed=arguments.seed,
    )
    truth = rules_from_document(document)
    train, test = data.of_split("train"), data.of_split("test")
    rng = np.random.default_rng([arguments.seed, 77])
    problems: dict[str, list[Any]] = {}
    for type_ in data.types:
        for scene in test.scenes:
            found = starts_of(truth, scene, type_, arguments.each, rng)
            if found is not None and len(found[0]):
                problems.setdefault(type_, []).append((scene, *found))
    runs: dict[tuple[str, int, str], list[Any]] = {}
    seconds: dict[tuple[str, int, str], float] = {}
    for kind in arguments.models.split(","):
        model = truth if kind == "truth" else fit_model(train, kind, seed=arguments.seed)
        for type_, items in problems.items():
            views = [
                model.see(scene if kind == "truth" else replace(scene, objects=None))
                for scene, _, _ in items
            ]
            for particles in (int(k) for k in arguments.particles.split(",")):
                settings = RepairSettings(
                    particles=particles, confidence=arguments.confidence, step=arguments.step
                )
                began = time.process_time()
                done = [
                    repair(
                        view, z, type_, settings=settings, known_invalid=np.ones(len(z), dtype=bool)
                    )
                    for view, (_, z, _) in zip(views, items, strict=True)
                ]
                seconds[kind, particles, type_] = time.process_time() - began
                runs[kind, particles, type_] = done
    rows = []
    for type_ in data.types:
        if type_ not in problems:
            rows.append({"type": type_, "vacuous": True})
            continue
        items = problems[type_]
        keys = [key for key in runs if key[2] == type_]
        least = [np.linalg.norm(z - valid[None, :, 0], axis=2).min(axis=1) for _, z, valid in items]
        held = {}
        for key in keys:
            held[key] = [
                truth.see(scene).p_valid(done.points, type_) > 0.5
                for done, (scene, _, _) in zip(runs[key], items, strict=True)
            ]
            least = [
                np.where(h, np.minimum(done.moved, one), one)
                for h, done, one in zip(held[key], runs[key], least, strict=True)
            ]
        for key in keys:
            ok = np.concatenate(held[key])
            moved = np.concatenate([done.moved for done in runs[key]])
            ratio = (moved / np.maximum(np.concatenate(least), 0.5))[ok]
            rows.append(
                {
                    "type": type_,
                    "model": key[0],
                    "particles": key[1],
                    "starts": len(ok),
                    "scenes": len(items),
                    "truth_accepts": float(ok.mean()),
                    "model_accepts": float(
                        np.concatenate([d.p_valid > 0.5 for d in runs[key]]).mean()
                    ),
                    "ratio_median": float(np.median(ratio)),
                    "ratio_mean": float(ratio.mean()),
                    "ratio_p90": float(np.quantile(ratio, 0.9)),
                    "ms_per_repair": 1e3 * seconds[key] / len(ok),
                }
            )
    report = {
        "command": "python " + " ".join(sys.argv),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, one thread",
        "versions": {name: version(name) for name in ("demospec", "numpy", "torch")},
        "seed": arguments.seed,
        "rows": rows,
    }
    arguments.out.parent.mkdir(exist_ok=True)
    arguments.out.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    print("type        model  K  starts  truth accepts  moved / least (median, mean)  ms a repair")
    for row in rows:
        if row.get("vacuous"):
            print(f"{row['type']:<11} vacuous: no invalid start exists")
            continue
        print(
            f"{row['type']:<11} {row['model']:<5} {row['particles']:>2}  {row['starts']:>6}  "
            f"{row['truth_accepts']:>13.1%}  {row['ratio_median']:>8.2f} {row['ratio_mean']:>6.2f}"
            f"  {row['ms_per_repair']:>22.2f}"
        )


if __name__ == "__main__":
    main()
