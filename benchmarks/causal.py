"""Causal analysis against the ground truth: tables right, effects near, placebo null, coverage.

    python benchmarks/causal.py field --repeats 40          # lists shown, training scenes
    python benchmarks/causal.py pictures --repeats 12       # pictures only, unseen scenes and items
    python benchmarks/causal.py rules --repeats 40          # learned rules (no network)
    python benchmarks/causal.py paper                       # the paper's model and its table
    python benchmarks/causal.py coverage                    # 95 % intervals under the truth
    python benchmarks/causal.py seen                        # what added things are taken for
    python benchmarks/causal.py show                        # print what is recorded

Every repeat draws fresh scenes and demonstrations (n = 9 per scene and type, 20 scenes) and
fits anew. The truth answers the same interventions with the same paths. Each study writes its
part of benchmarks/results/causal.json.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

from demospec.causal import (  # noqa: E402
    CausalFindings,
    Settings,
    estimate,
    mean_interval,
    trials_of_set,
)
from demospec.demonstrations import DemonstrationSet, ValidityModel, simulate_set  # noqa: E402
from demospec.parallel import iterate_tasks  # noqa: E402
from demospec.rules import learn_rules, rules_from_document  # noqa: E402

RESULTS = Path(__file__).parent / "results" / "causal.json"
FIRST_SEED = 5000
EXPECTED = {("careful", s) for s in ("utensil", "plate", "bowl", "glass")} | {("normal", "glass")}


def fitted(kind: str, data: DemonstrationSet, seed: int) -> ValidityModel:
    """A model of that kind, fitted on the training scenes."""
    if kind == "rules":
        return learn_rules(data)
    import torch

    from demospec.specification import fit_model

    torch.set_num_threads(1)
    return fit_model(data, model=kind, seed=seed)


def fresh(kind: str, seed: int, *, unseen: bool) -> tuple[Any, ...]:
    """(set, truth, fitted model, CPU seconds of the fit): freshly drawn, freshly trained."""
    data, truth = simulate_set(
        seed=seed, demonstrations=9, train_scenes=20, test_scenes=20 if unseen else 0
    )
    began = time.process_time()
    model = fitted(kind, data.of_split("train"), seed)
    return data, rules_from_document(truth), model, time.process_time() - began


def repeat(kind: str, seed: int, *, unseen: bool, hide_lists: bool) -> dict[str, Any]:
    """One fresh set, one fit, one analysis by the model and one by the truth."""
    data, truth, model, fit_s = fresh(kind, seed, unseen=unseen)
    part = analysed(data, truth, model, "test" if unseen else "train", seed, hide_lists)
    return part | {"fit_cpu_s": fit_s}


def analysed(
    data: DemonstrationSet,
    truth: ValidityModel,
    model: ValidityModel,
    split: Any,
    seed: int,
    hide_lists: bool,
) -> dict[str, Any]:
    """The model's findings beside the truth's, for the same interventions."""
    settings = Settings(seed=seed, hide_lists=hide_lists)
    began = time.process_time()
    trials = trials_of_set(model, data, split=split, settings=settings)
    found = estimate(trials, settings)
    run_s = time.process_time() - began
    hard = estimate(trials, replace(settings, outcome="verdict"))
    plain = replace(settings, hide_lists=False)
    true = estimate(trials_of_set(truth, data, split=split, settings=plain), plain)
    by_verdict = compared(hard, true)
    return compared(found, true) | {"seed": seed, "run_cpu_s": run_s, "by_verdict": by_verdict}


def compared(found: CausalFindings, true: CausalFindings) -> dict[str, Any]:
    """Cell by cell: claim, effect by the model, effect by the truth."""
    cells = []
    for cell in found.effects:
        other = true.effect(cell.type, cell.symbol)
        cells.append(
            {
                "type": cell.type,
                "symbol": cell.symbol,
                "effect": cell.effect,
                "true_effect": other.effect,
                "causal": cell.causal,
                "truth_causal": other.causal,
                "right": cell.causal == ((cell.type, cell.symbol) in EXPECTED),
                "interval": cell.interval,
            }
        )
    return {
        "cells": cells,
        "base": {t: [found.base[t].mean, true.base[t].mean] for t in found.types},
        "placebo": {p.type: p.effect for p in found.placebo},
        "placebo_null": found.placebo_is_null,
        "truth_table_right": all(
            (c.causal == ((c.type, c.symbol) in EXPECTED)) for c in true.effects
        ),
    }


def summary(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """The numbers that the issue asks for."""
    cells = [c for r in runs for c in r["cells"]]
    gaps = np.array([abs(c["effect"] - c["true_effect"]) for c in cells])
    placebo = np.array([abs(v) for r in runs for v in r["placebo"].values()])
    return {
        "repeats": len(runs),
        "tables_with_all_12_right": float(np.mean([all(c["right"] for c in r["cells"])
                                                   for r in runs])),
        "cells_right": float(np.mean([c["right"] for c in cells])),
        "truth_tables_right": float(np.mean([r["truth_table_right"] for r in runs])),
        "effect_error_mean": float(gaps.mean()),
        "effect_error_max": float(gaps.max()),
        "effects_within_0.02": float((gaps <= 0.02).mean()),
        "placebo_max": float(placebo.max()),
        "run_cpu_s_median": float(np.median([r["run_cpu_s"] for r in runs])),
        "fit_cpu_s_median": float(np.median([r["fit_cpu_s"] for r in runs])),
        "outcome_verdict": _verdict_summary(runs),
        "wrong_cells": [
            f"{r['seed']}: {c['type']}/{c['symbol']} {c['effect']:+.3f} (truth "
            f"{c['true_effect']:+.3f})" for r in runs for c in r["cells"] if not c["right"]
        ],
    }  # fmt: skip


def _verdict_summary(runs: list[dict[str, Any]]) -> dict[str, float]:
    """The same interventions, counted by p > ½ instead of by p."""
    parts = [r["by_verdict"] for r in runs if "by_verdict" in r]
    if not parts:
        return {}
    gaps = [abs(c["effect"] - c["true_effect"]) for p in parts for c in p["cells"]]
    right = [all(c["right"] for c in p["cells"]) for p in parts]
    return {
        "tables_with_all_12_right": float(np.mean(right)),
        "cells_right": float(np.mean([c["right"] for p in parts for c in p["cells"]])),
        "effect_error_mean": float(np.mean(gaps)),
        "effects_within_0.02": float(np.mean([g <= 0.02 for g in gaps])),
    }


def study(
    name: str,
    kind: str,
    repeats: int,
    *,
    unseen: bool,
    hide_lists: bool,
    workers: int = 1,
    cluster: str | None = None,
) -> None:
    """Repeats, saved one by one: an interrupted study goes on where it stopped.

    Runs with another pretrained body or another number of placements are dropped.
    """
    body, placements = body_hash(), Settings().placements
    runs = [r for r in recorded().get(name, {}).get("runs", [])
            if r.get("body") == body and r.get("placements") == placements]  # fmt: skip
    done = {r["seed"] for r in runs}
    seeds = [s for s in range(FIRST_SEED, FIRST_SEED + repeats) if s not in done]
    task = partial(repeat, kind, unseen=unseen, hide_lists=hide_lists)
    for run in iterate_tasks(task, seeds, workers=workers, cluster=cluster):
        runs.append(run | {"body": body, "placements": placements})
        record(name, {"summary": summary(runs), "runs": runs})
        line = {k: v for k, v in summary(runs).items() if k != "wrong_cells"}
        print(json.dumps(line), flush=True)


def body_hash() -> str:
    """Which pretrained body the field model sees with."""
    import hashlib

    import demospec.perception

    weights = Path(demospec.perception.__file__).parent / "weights" / "body.safetensors"
    return hashlib.sha256(weights.read_bytes()).hexdigest()[:12]


def coverage(scenes: int = 400, groups: int = 1000) -> None:
    """How often the 95 % intervals of groups of scenes hold the mean of all scenes."""
    data, truth = simulate_set(
        seed=FIRST_SEED - 1, demonstrations=1, train_scenes=scenes, test_scenes=0
    )
    settings = Settings(seed=1)
    bare = replace(
        data, scenes=tuple(s.with_changes(objects=s.objects, picture=None) for s in data.scenes)
    )
    model = rules_from_document(truth)
    table = trials_of_set(model, bare, settings=settings, types=["careful", "normal"])
    columns = {}
    for k, type_ in enumerate(table.types):
        columns[f"base {type_}"] = np.array([b[k].mean() for b in table.before])
        for symbol in table.symbols:
            columns[f"{type_} {symbol}"] = table.scene_differences("add", symbol)[0][k]
    out: dict[str, dict[str, float]] = {}
    rng = np.random.default_rng(0)
    for n in (10, 20, 40):
        for name, values in columns.items():
            if not values.any():
                continue
            hits = 0
            for g in range(groups):
                group = values[rng.integers(0, len(values), n)]
                low, high = mean_interval(group, seed=g) or (0.0, 0.0)
                hits += low <= values.mean() <= high
            out.setdefault(f"n = {n}", {})[name] = hits / groups
        print(n, out[f"n = {n}"], flush=True)
    for method in ("percentile", "BCa"):
        out[f"n = 20, {method} bootstrap (not ours)"] = {
            name: covered_by(values, method, groups // 3) for name, values in columns.items()
            if values.any()
        }  # fmt: skip
        print(method, out[f"n = 20, {method} bootstrap (not ours)"], flush=True)
    record(
        "coverage",
        {
            "scenes": scenes,
            "groups": groups,
            "placements": settings.placements,
            "share_covered": out,
        },
    )


def covered_by(values: np.ndarray, method: Any, groups: int, n: int = 20) -> float:
    """How often SciPy's bootstrap interval holds the mean of all scenes."""
    from scipy.stats import bootstrap

    rng = np.random.default_rng(0)
    hits = 0
    for _ in range(groups):
        group = values[rng.integers(0, len(values), n)]
        found = bootstrap((group,), np.mean, n_resamples=999, method=method, rng=rng)
        low, high = found.confidence_interval
        hits += low <= values.mean() <= high
    return hits / groups


def paper(seeds: int = 2) -> None:
    """The paper's model, its table; seen and unseen scenes apart."""
    out: list[dict[str, Any]] = []
    for seed in range(FIRST_SEED, FIRST_SEED + seeds):
        data, truth, model, fit_s = fresh("paper", seed, unseen=True)
        for split in ("train", "test"):
            part = analysed(data, truth, model, split, seed, False)
            out.append({"split": split, **part, "fit_cpu_s": fit_s})
            print(seed, split, part["base"], part["placebo"], flush=True)
            for cell in part["cells"]:
                print("   ", cell, flush=True)
            record("paper", {"runs": out})


def seen(seed: int = FIRST_SEED + 3) -> None:
    """What the field model takes added things of unseen items for: why effects are off."""
    from demospec.causal import editor_for
    from demospec.demonstrations import pictures_in_memory
    from demospec.scene import free_places

    data, _, model, _ = fresh("field", seed, unseen=True)
    scenes = pictures_in_memory(data.of_split("test")).scenes
    editor, rng = editor_for(scenes), np.random.default_rng(0)
    out: dict[str, dict[str, float]] = {}
    for symbol in data.symbols:
        found: list[dict[str, float] | None] = []
        for scene in scenes:
            things = editor.things(symbol, scene)
            thing = things[int(rng.integers(len(things)))]
            for x, y in free_places(scene, thing.radius_px(scene), 2, rng):
                after = thing.put(scene, (float(x), float(y)), float(rng.uniform(0, 2 * np.pi)))
                outline = after.listed_objects()[-1].outline
                parts = model.see(after.seen()).perceived
                on_it = [p for p in parts if outline.signed_distance(np.array(p.center)) < 2]
                found.append(dict(on_it[0].classes) if on_it else None)
        classes = [c for c in found if c is not None]
        out[symbol] = {
            "added": len(found),
            "missed": len(found) - len(classes),
            **{f"p({s})": float(np.mean([c.get(s, 0.0) for c in classes])) for s in data.symbols},
        }
        print(symbol, out[symbol], flush=True)
    record("seen", {"seed": seed, "body": body_hash(), "summary": out})


def recorded() -> dict[str, Any]:
    """What the results file holds."""
    return json.loads(RESULTS.read_text()) if RESULTS.exists() else {}


def record(name: str, part: dict[str, Any]) -> None:
    """Replaces one study in the results file."""
    machine = {
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, one thread",
        "python": platform.python_version(),
        "versions": {p: version(p) for p in ("numpy", "torch", "scipy")},
    }
    command = f"python benchmarks/causal.py {' '.join(sys.argv[1:])}"
    document = {**recorded(), name: {"command": command, **machine, **part}}
    RESULTS.parent.mkdir(exist_ok=True)
    temporary = RESULTS.with_suffix(f".{os.getpid()}.tmp")
    temporary.write_text(json.dumps(document, indent=1) + "\n")
    temporary.replace(RESULTS)


def show() -> None:
    """Prints the recorded summaries."""
    for name, part in recorded().items():
        print(f"{name}  ({part['command']})")
        for key, value in part.get("summary", part.get("share_covered", {})).items():
            print(f"    {key}: {value}")
        for run in part.get("runs", [])[:4] if name == "paper" else []:
            print(
                f"  seed {run['seed']}, {run['split']} scenes: as is, + utensil, plate, bowl, glass"
            )
            show_table(run)


PAPERS_TABLE = {
    "careful": (0.43, 0.27, 0.28, 0.31, 0.30),
    "normal": (0.62, 0.62, 0.63, 0.62, 0.48),
    "aggressive": (1.00, 1.00, 1.00, 1.00, 1.00),
}
"""E[p(v)] as is, then with a utensil, plate, bowl, glass added: Angelov et al. 2020."""


def show_table(run: dict[str, Any]) -> None:
    """One run as the paper prints it (* = causal), beside the truth and the paper."""
    for type_, (base, true_base) in run["base"].items():
        cells = [c for c in run["cells"] if c["type"] == type_]
        ours = [base, *(base + c["effect"] for c in cells)]
        true = [true_base, *(true_base + c["true_effect"] for c in cells)]
        marks = ["", *("*" if c["causal"] else "" for c in cells)]
        shown = " ".join(f"{v:.2f}{m:1}" for v, m in zip(ours, marks, strict=True))
        print(f"    {type_:10} {shown} | truth {' '.join(f'{v:.2f}' for v in true)} | "
              f"paper {' '.join(f'{v:.2f}' for v in PAPERS_TABLE[type_])}")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "study", nargs="?", default="show",
        choices=["field", "pictures", "rules", "paper", "coverage", "seen", "show"],
    )  # fmt: skip
    parser.add_argument("--repeats", type=int, default=40)
    parser.add_argument("--workers", type=int, default=1, help="processes for the repeats")
    parser.add_argument("--cluster", help="a Dask scheduler for the repeats")
    arguments = parser.parse_args()
    if arguments.study == "coverage":
        coverage()
    elif arguments.study == "seen":
        seen()
    elif arguments.study == "paper":
        paper()
    elif arguments.study == "show":
        show()
    else:
        hidden = arguments.study == "pictures"
        kind = "field" if hidden else arguments.study
        study(
            arguments.study, kind, arguments.repeats, unseen=hidden, hide_lists=hidden,
            workers=arguments.workers, cluster=arguments.cluster,
        )  # fmt: skip


if __name__ == "__main__":
    main()
