"""What an ensemble adds: accuracy against its first member, and whether its spread finds errors.

    python benchmarks/ensemble.py --seed 100        # about three minutes of one core

Pictures only. Held-out trajectories in the training scenes (seen) and in new scenes with new
items (unseen), types with two classes. ``auc``: chance that a wrong verdict has more of a score
than a right one, ½ for no use; the score is the spread of the members' p(valid), or minus |logit|
of the first member alone. Adds to benchmarks/results/ensemble.json.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402
from scipy.stats import mannwhitneyu  # noqa: E402

from demospec.demonstrations import DemonstrationSet, pictures_in_memory, simulate_set  # noqa: E402
from demospec.experiments import hold_out, without_objects  # noqa: E402
from demospec.specification import fit_ensemble  # noqa: E402

RESULTS = Path(__file__).parent / "results" / "ensemble.json"


def judged(model: Any, data: DemonstrationSet) -> dict[str, np.ndarray]:
    """Labels, logits (ensemble and first member) and spread of the types with two classes."""
    d = data.demonstrations
    found: dict[str, list[np.ndarray]] = {k: [] for k in ("label", "logit", "first", "spread", "p")}
    for scene_id, rows in data.rows_by_scene().items():
        view = model.see(without_objects([data.scene(scene_id)])[0])
        for type_ in ("careful", "normal"):
            mine = [int(i) for i in rows if d.type[i] == type_]
            if mine:
                paths = d.paths_xy(mine)
                logits = view.member_logits(paths, type_)
                found["label"].append(d.valid[mine] == 1)
                found["logit"].append(logits.mean(axis=0))
                found["first"].append(logits[0])
                found["spread"].append(view.p_valid_sd(paths, type_))
                # The other reading of "the mean": of probabilities.
                found["p"].append((1 / (1 + np.exp(-np.clip(logits, -60, 60)))).mean(axis=0))
    return {k: np.concatenate(v) for k, v in found.items()}


def balanced(said: np.ndarray, label: np.ndarray) -> float:
    return float((said[label].mean() + (~said[~label]).mean()) / 2)


def auc(score: np.ndarray, wrong: np.ndarray) -> float | None:
    if wrong.all() or not wrong.any():
        return None
    high = mannwhitneyu(score[wrong], score[~wrong]).statistic
    return float(high / (wrong.sum() * (~wrong).sum()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=100)
    parser.add_argument("--members", type=int, default=5)
    parser.add_argument("--kinds", default="paper,irl,field")
    given = parser.parse_args()
    whole, _ = simulate_set(demonstrations=12, seed=given.seed)
    whole = pictures_in_memory(whole)
    train, seen = hold_out(whole.of_split("train"), 0.25)
    rows = []
    for kind in given.kinds.split(","):
        began = time.process_time()
        model = fit_ensemble(train, kind, members=given.members, seed=0)
        fit_s = time.process_time() - began
        for where, data in (("train", train), ("seen", seen), ("unseen", whole.of_split("test"))):
            x = judged(model, data)
            one, many = x["first"] > 0, x["logit"] > 0
            row = {
                "model": kind,
                "where": where,
                "n": len(many),
                "first": balanced(one, x["label"]),
                "ensemble": balanced(many, x["label"]),
                "mean_of_p": balanced(x["p"] > 0.5, x["label"]),
                "spread": float(x["spread"].mean()),
                "auc_spread": auc(x["spread"], many != x["label"]),
                "auc_logit_of_first": auc(-np.abs(x["first"]), one != x["label"]),
                "fit_s": fit_s,
            }
            rows.append(row)
            print({k: round(v, 3) if isinstance(v, float) else v for k, v in row.items()})
    report = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    report[f"seed {given.seed}"] = {
        "command": "python " + " ".join(sys.argv),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, one thread",
        "versions": {n: version(n) for n in ("demospec", "numpy", "torch")},
        "rows": rows,
    }
    RESULTS.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
