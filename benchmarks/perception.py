"""What the network sees on unseen items: distances, misses, false things, centres, symbols.

    python benchmarks/perception.py --seeds 11,12 --catalogues builtin,sweethome3d
    python benchmarks/perception.py --network other.safetensors --worst worst.png

Test scenes of simulated sets hold items that no training scene holds; the network has seen
neither. Symbols are named by a head fitted on the training scenes. Writes
benchmarks/results/perception.json (or --out).
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections import Counter
from importlib.metadata import version
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

from demospec.demonstrations import simulate_set  # noqa: E402
from demospec.perception import (  # noqa: E402  # noqa: E402
    SHIPPED,
    Observation,
    detect_objects,
    fit_symbol_head,
    load_network,
    observe,
    recipe_of,
)
from demospec.scene import Scene, SceneObject  # noqa: E402

NEAR_PX = 12.0
REPORTED = Path(__file__).parent / "results" / "perception.json"


def places(observation: Observation) -> tuple[np.ndarray, np.ndarray]:
    """(x, y) of the columns and rows of the maps, the picture's pixels."""
    width, height = observation.grid
    return (
        (np.arange(width) + 0.5) * (observation.size_px[0] / width),
        (np.arange(height) + 0.5) * (observation.size_px[1] / height),
    )


def true_distance(objects: tuple[SceneObject, ...], observation: Observation) -> np.ndarray:
    """(K, h, w) signed distance to every object's outline."""
    points = np.stack(np.meshgrid(*places(observation)), axis=-1)
    return np.stack([item.outline.signed_distance(points) for item in objects])


def matched(seen: list[SceneObject], truth: tuple[SceneObject, ...]) -> list[int]:
    """Seen → index of the listed object that holds its centre or overlaps its box most, or −1."""
    out = []
    for thing in seen:
        assert thing.footprint is not None
        inside = [
            float((item.outline.signed_distance(thing.footprint.vertices) < 1.0).mean())  # type: ignore[attr-defined]
            + float(item.outline.signed_distance(np.array([thing.center]))[0] < 0)
            for item in truth
        ]
        best = int(np.argmax(inside)) if inside else -1
        out.append(best if inside and inside[best] > 0.25 else -1)
    return out


def study(scenes: list[Scene], train: list[Scene], network: Any) -> dict[str, Any]:
    """All figures of one catalogue and seed."""
    head = fit_symbol_head(train, network=network)
    gaps: list[np.ndarray] = []
    bias: dict[str, list[float]] = {}
    total, missed, named = Counter(), Counter(), Counter()  # type: ignore[var-annotated]
    false, unnamed, centre, per_scene = 0, 0, [], []
    seconds = 0.0
    for scene in scenes:
        truth = scene.objects or ()
        began = time.process_time()
        observation: Observation = observe(scene.pixels(), network=network)
        seconds += time.process_time() - began
        exact = true_distance(truth, observation)
        nearest = exact.min(axis=0)
        near = np.abs(nearest) < NEAR_PX
        gap = (observation.distance - nearest)[near]
        gaps.append(gap)
        per_scene.append(float(np.abs(gap).mean()))
        rim = (nearest > 1) & (nearest < 5)
        for k, item in enumerate(truth):
            mine = rim & (exact[k] == nearest)
            if mine.any():
                bias.setdefault(item.symbol, []).append(
                    float(np.median((observation.distance - nearest)[mine]))
                )
            total[item.symbol] += 1
        seen = detect_objects(observation, head=head)
        who = matched(seen, truth)
        false += who.count(-1)
        unnamed += matched(detect_objects(observation), truth).count(-1)  # type: ignore[arg-type]
        for k, item in enumerate(truth):
            mine = [seen[i] for i, w in enumerate(who) if w == k]
            if not mine:
                missed[item.symbol] += 1
                named[(item.symbol, "missed")] += 1
                continue
            largest = max(mine, key=lambda o: o.bbox[2] * o.bbox[3])  # type: ignore[index]
            named[(item.symbol, largest.symbol)] += 1
            # Bounding boxes, not centres of the list: those are poses, not centres of area.
            a, b = np.array(largest.bbox), np.array(item.outline.bounds)
            centre.append(float(np.hypot(*(a[:2] + a[2:] / 2 - (b[:2] + b[2:]) / 2))))
    every = np.concatenate(gaps)
    return {
        "scenes": len(scenes),
        "objects": int(sum(total.values())),
        "mean_abs_error_px": float(np.abs(every).mean()),
        "bias_px": float(np.median(every)),
        "bias_by_symbol_px": {s: float(np.median(v)) for s, v in sorted(bias.items())},
        "recall": 1 - sum(missed.values()) / max(1, sum(total.values())),
        "miss_rate_by_symbol": {s: missed[s] / total[s] for s in sorted(total)},
        "false_per_scene": false / len(scenes),
        "false_per_scene_without_a_head": unnamed / len(scenes),
        "centre_error_px": float(np.median(centre)),
        "symbol_accuracy": sum(n for (a, b), n in named.items() if a == b)
        / max(1, sum(n for (_, b), n in named.items() if b != "missed")),
        "confusion": {f"{a} → {b}": n for (a, b), n in sorted(named.items())},
        "look_ms": 1e3 * seconds / len(scenes),
        "error_by_scene_px": per_scene,
    }


def draw_worst(scenes: list[Scene], errors: list[float], network: Any, out: Path) -> None:
    """The twelve worst scenes: seen rims (orange) over listed ones (blue)."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(16, 12), layout="constrained")
    axes = figure.subplots(3, 4)
    for axis, i in zip(axes.flat, np.argsort(errors)[::-1][:12], strict=False):
        observation = observe(scenes[i].pixels(), network=network)
        width, height = observation.size_px
        axis.imshow(scenes[i].pixels(), extent=(0, width, height, 0))
        x, y = places(observation)
        exact = true_distance(scenes[i].objects or (), observation).min(axis=0)
        axis.contour(x, y, exact, [0.0], colors="#56B4E9", linewidths=1.0)
        axis.contour(x, y, observation.distance, [0.0], colors="#D55E00", linewidths=1.0)
        axis.set_title(f"scene {scenes[i].scene_id}: {errors[i]:.2f} px", fontsize=9)
        axis.set_axis_off()
    figure.savefig(out, dpi=70)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--catalogues", default="builtin,sweethome3d")
    parser.add_argument("--seeds", default="11,12")
    parser.add_argument("--train", type=int, default=20)
    parser.add_argument("--scenes", type=int, default=30)
    parser.add_argument("--network", type=Path, default=None)
    parser.add_argument("--worst", type=Path, default=None)
    parser.add_argument("--out", type=Path, default=REPORTED)
    arguments = parser.parse_args()
    import torch

    torch.set_num_threads(1)
    network = load_network(arguments.network)
    rows: list[dict[str, Any]] = []
    shown: list[Scene] = []
    errors: list[float] = []
    print("catalogue    seed  |error|  bias   recall  false/scene   centre  symbols  ms/look")
    for catalogue in arguments.catalogues.split(","):
        for seed in (int(s) for s in arguments.seeds.split(",")):
            data, _ = simulate_set(
                catalogue=catalogue, train_scenes=arguments.train, test_scenes=arguments.scenes,
                demonstrations=1, seed=seed,
            )  # fmt: skip
            test = list(data.of_split("test").scenes)
            row = study(test, list(data.of_split("train").scenes), network)
            shown += test
            errors += row.pop("error_by_scene_px")
            rows.append({"catalogue": catalogue, "seed": seed, **row})
            print(
                f"{catalogue:<12} {seed:>4}  {row['mean_abs_error_px']:>6.2f}  "
                f"{row['bias_px']:>5.2f}  {row['recall']:>6.1%}  {row['false_per_scene']:>5.2f} / "
                f"{row['false_per_scene_without_a_head']:>4.2f}  "
                f"{row['centre_error_px']:>6.2f}  {row['symbol_accuracy']:>7.1%}  "
                f"{row['look_ms']:>7.0f}",
                flush=True,
            )
            print(
                "   bias by symbol:", {k: round(v, 2) for k, v in row["bias_by_symbol_px"].items()}
            )
            print("   confusion:", row["confusion"])
    if arguments.worst is not None:
        draw_worst(shown, errors, network, arguments.worst)
    arguments.out.parent.mkdir(exist_ok=True)
    report = {
        "command": "python " + " ".join(sys.argv),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, one thread",
        "versions": {n: version(n) for n in ("demospec", "numpy", "torch")},
        "network": recipe_of(arguments.network or SHIPPED),
        "rows": rows,
    }
    arguments.out.write_text(json.dumps(report, indent=1, ensure_ascii=False) + "\n", "utf-8")


if __name__ == "__main__":
    main()
