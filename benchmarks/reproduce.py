"""What the full `demospec reproduce` would take, from the processor time of a quick one.

    demospec reproduce --quick --out runs/quick
    python benchmarks/reproduce.py runs/quick

Fits of the grid are counted by their own processor time, other stages by the wall time that they
took. It is an estimate: a fit on more demonstrations than the quick run has tried is taken to
cost the mean of those that it has.
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from pathlib import Path

from demospec.experiments.paper import ReproduceSettings
from demospec.files import read_json

SIMULATION_S = 0.6
"""Of the set of one seed, in each process: `demospec simulate` with 18 demonstrations a type."""


def grid(run: Path, reading: str, workers: int) -> float:
    """Prints the arithmetic of one reading; seconds on `workers` idle cores."""
    full = ReproduceSettings()
    models = full.models if reading == "uniform" else full.models[:1]
    cells = full.seeds * len(full.counts if reading == "uniform" else full.clustered_counts)
    seconds: dict[str, list[float]] = defaultdict(list)
    for line in (run / f"grid-{reading}.jsonl").read_text().splitlines()[1:]:
        fit = json.loads(line)
        seconds[fit["model"]].append(fit["fit_seconds"] + fit["score_seconds"])
    total = 0.0
    for model in models:
        each = sum(seconds[model]) / len(seconds[model])
        total += cells * each
        print(f"{reading:10s} {model:12s} {cells:3d} × {each:5.2f} s = {cells * each:6.0f} s")
    total += full.seeds * workers * SIMULATION_S
    return total / workers


def main() -> None:
    """Prints each part and the sum."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    stages = read_json(given.run / "run.json")["stages"]
    full, quick = ReproduceSettings(), ReproduceSettings.quick()
    together = sum(grid(given.run, r, given.workers) for r in ("uniform", "clustered"))
    print(f"grid on {given.workers} cores: {together:.0f} s")
    # Repairs grow with the starts and with the particles of the second column.
    times = {
        "repairs.json": full.starts / quick.starts * (1 + full.particles) / (1 + quick.particles),
        "parameters.json": full.demonstrations / quick.demonstrations,
    }
    for name, stage in stages.items():
        if not name.startswith("accuracy"):
            factor = times.get(name, 1.0)
            together += factor * stage["seconds"]
            print(f"{name:18s} {stage['seconds']:6.1f} s × {factor:.1f}")
    print(f"together: {together / 60:.0f} minutes")


if __name__ == "__main__":
    main()
