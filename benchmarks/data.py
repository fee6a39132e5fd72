"""Reading, checking, auditing: speed, memory at a million demonstrations, wrong labels found.

    python benchmarks/data.py [--quick] [--only read|audit|pictures|scale] [--folder FOLDER]

`read`: CPU seconds of one thread to read 100,000 demonstrations (bar: 2 s). `scale`: one million
demonstrations over ten thousand scenes (made anew in FOLDER, a gigabyte or two) through the
commands `check`, `rules` and `predict`, each in a process of its own: CPU seconds and peak
memory (bar: 2 GiB). `audit`: simulated sets with 5 % of the labels flipped; recall over the flips
that are *detectable* (no noise-free clearance rule agrees with the flipped label and with the
true labels of all others of its type; bar: 80 %), false reviews over the labels that are right
(bar: 3 %). `pictures`: the same where no scene lists its objects, so that the audit must see them.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

from demospec.demonstrations import (  # noqa: E402
    Demonstrations,
    DemonstrationSet,
    iterate_batches,
    read_set,
    simulate_set,
    write_set,
)
from demospec.rules import nearest_approach  # noqa: E402
from demospec.scene import Disc, Picture, Scene, SceneObject  # noqa: E402
from demospec.specification import audit_set  # noqa: E402

RESULTS = Path(__file__).parent / "results" / "data.json"
SYMBOLS = ("utensil", "plate", "bowl", "glass")
CLEARANCE = 3.0


def large_set(n: int, scenes: int, points: int = 30, seed: int = 0) -> DemonstrationSet:
    """n Bézier paths over scenes of four discs each; `careful` keeps 3 px from all."""
    rng = np.random.default_rng(seed)
    centres = rng.uniform(20, 80, (scenes, 4, 2))
    grey = Picture(array=np.full((100, 100, 3), 200, np.uint8))
    listed = tuple(
        Scene(
            f"s{i:05d}", (10.0, 90.0), (90.0, 10.0),
            tuple(
                SceneObject(f"{symbol}-0", symbol, (float(x), float(y)), None,
                            Disc((float(x), float(y)), 5.0))
                for symbol, (x, y) in zip(SYMBOLS, centres[i], strict=True)
            ),
            grey,
        )
        for i in range(scenes)
    )  # fmt: skip
    u = np.linspace(0, 1, points)[None, :, None]
    control = rng.uniform(-20, 120, (n, 1, 2))
    paths = (1 - u) ** 2 * [10.0, 90.0] + 2 * u * (1 - u) * control + u**2 * [90.0, 10.0]
    scene = np.sort(rng.integers(0, scenes, n))
    kind = rng.integers(0, 2, n)
    valid = np.ones(n, dtype=np.int8)  # `aggressive` avoids nothing
    edges = np.searchsorted(scene, np.arange(scenes + 1))
    for i, (low, high) in enumerate(itertools.pairwise(edges)):
        mine = low + np.flatnonzero(kind[low:high] == 0)
        if len(mine):
            near = nearest_approach(listed[i], paths[mine], SYMBOLS)
            valid[mine] = near.min(axis=1) >= CLEARANCE
    return DemonstrationSet(
        scenes=listed,
        demonstrations=Demonstrations(
            demo_id=_texts([f"d{i:07d}" for i in range(n)]),
            scene_id=_texts([f"s{i:05d}" for i in scene]),
            type=_texts([("careful", "aggressive")[k] for k in kind]),
            demonstrator=_texts([None] * n),
            valid=valid,
            flat=paths.reshape(-1, 2),
            offsets=np.arange(n + 1, dtype=np.int64) * points,
        ),
        symbols=SYMBOLS,
        types=("careful", "aggressive"),
    )


def _texts(values: list[Any]) -> np.ndarray:
    out = np.empty(len(values), dtype=object)
    out[:] = values
    return out


def bench_read(folder: Path, n: int) -> list[dict[str, Any]]:
    """CPU seconds to read and to stream n demonstrations, beside a plain Arrow read."""
    import pyarrow.parquet as pq

    root = write_set(large_set(n, max(1, n // 100)), folder / "read", replace_existing=True)
    rows = []
    for name, work in (
        ("read_set", lambda: read_set(root)),
        ("iterate_batches", lambda: sum(1 for _ in iterate_batches(root))),
        ("pyarrow alone", lambda: pq.read_table(root / "demonstrations.parquet")),
    ):
        times = []
        for _ in range(5):
            began = time.process_time()
            work()
            times.append(time.process_time() - began)
        rows.append({"what": name, "demonstrations": n, "cpu_s": round(float(np.median(times)), 3)})
    return rows


def bench_scale(folder: Path, n: int, scenes: int) -> list[dict[str, Any]]:
    """Each command on the large set in a process of its own."""
    root = folder / "large"
    if os.fork() == 0:  # the set itself shall not count against this process
        write_set(large_set(n, scenes), root, replace_existing=True)
        os._exit(0)
    os.wait()
    rules = folder / "rules.json"
    rows = []
    for name, arguments in (
        ("check", ["check", str(root), "--json"]),
        ("rules", ["rules", str(root), "--out", str(rules), "--json"]),
        ("predict", ["predict", str(rules), str(root), "--out", str(folder / "p.json")]),
    ):
        rows.append({"what": name, "demonstrations": n, "scenes": scenes, **_child(arguments)})
    predicted = json.loads((folder / "p.json").read_text())["predictions"]
    rows[-1]["predictions"] = len(predicted)
    p = np.array([e["p_valid"] for e in predicted])
    truth = np.concatenate([b.demonstrations.valid for b in iterate_batches(root)]) == 1
    rows[-1]["agree_with_labels"] = round(float(((p > 0.5) == truth).mean()), 6)
    return rows


def _child(arguments: list[str]) -> dict[str, Any]:
    code = (
        "import resource, sys\n"
        "from demospec.cli import main\n"
        "try:\n    main(sys.argv[1:])\n"
        "except SystemExit as stop:\n"
        "    used = resource.getrusage(resource.RUSAGE_SELF)\n"
        "    sys.stderr.write(f'\\nUSED {used.ru_maxrss} {used.ru_utime + used.ru_stime}"
        " {stop.code}\\n')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, text=True, check=False,
    )  # fmt: skip
    last = [line for line in done.stderr.splitlines() if line.startswith("USED ")][-1].split()
    return {
        "peak_MiB": round(int(last[1]) / 1024),
        "cpu_s": round(float(last[2]), 1),
        "exit": int(last[3] if last[3] != "None" else 0),
    }


def bench_audit(
    seeds: int, sizes: list[tuple[int, int]], *, listed: bool = True
) -> list[dict[str, Any]]:
    """Flipped labels found and right labels suspected, pooled over seeds."""
    rows = []
    for scenes, demonstrations in sizes:
        counts = np.zeros(5, dtype=np.int64)
        cpu = 0.0
        for seed in range(1000, 1000 + seeds):
            data, truth = simulate_set(
                train_scenes=scenes, test_scenes=0, demonstrations=demonstrations, seed=seed,
                label_noise=0.05,
            )  # fmt: skip
            began = time.process_time()
            bare = tuple(replace(scene, objects=None) for scene in data.scenes)
            result = audit_set(data if listed else replace(data, scenes=bare))
            cpu += time.process_time() - began
            flipped = np.isin(data.demonstrations.demo_id.astype(str), truth["flipped"])
            review = np.array([e.verdict == "review" for e in result.entries])
            able = flipped & detectable(data, flipped)
            counts += [
                flipped.sum(), able.sum(), (able & review).sum(), (~flipped).sum(),
                (review & ~flipped).sum(),
            ]  # fmt: skip
        n_flipped, n_able, found, right, wrong = counts.tolist()
        rows.append(
            {
                "what": f"audit{'' if listed else ' of pictures'}, {scenes} scenes × 3 types × "
                f"{demonstrations}",
                "seeds": seeds,
                "flips": n_flipped, "detectable": n_able,
                "recall": round(found / max(1, n_able), 4),
                "false_reviews": round(wrong / right, 4), "cpu_s_a_set": round(cpu / seeds, 2),
            }
        )  # fmt: skip
    return rows


def detectable(data: DemonstrationSet, flipped: np.ndarray) -> np.ndarray:
    """Flips whose label no noise-free clearance rule can bring together with the true others.

    Written from the definition, without the audit's code: an accepted path bounds every class's
    clearance by its own distance; a rejected path needs a class whose bound exceeds its distance.
    """
    d = data.demonstrations
    near = np.full((len(d), len(data.symbols)), np.inf)
    for scene_id, rows in data.rows_by_scene().items():
        near[rows] = nearest_approach(data.scene(scene_id), d.paths_xy(rows), data.symbols)
    truth = (d.valid == 1) ^ flipped
    out = np.zeros(len(d), dtype=bool)
    for name in data.types:
        mine = np.flatnonzero(d.type == name)
        for i in mine[flipped[mine]]:
            label = truth[mine].copy()
            label[mine == i] ^= True
            bound = near[mine][label].min(axis=0, initial=np.inf)
            bound = np.where(bound < 0, -np.inf, bound)  # a class overlapped cannot matter
            explained = (near[mine][~label] < bound).any(axis=1)
            out[i] = not explained.all()
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", choices=["read", "audit", "pictures", "scale"])
    parser.add_argument("--folder", type=Path)
    options = parser.parse_args()
    results: dict[str, Any] = {}
    if RESULTS.is_file():
        results = json.loads(RESULTS.read_text())["results"]
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        folder = Path(name)
        if options.only in (None, "read"):
            results["read"] = bench_read(folder, 5_000 if options.quick else 100_000)
        if options.only in (None, "audit"):
            sizes = [(6, 5)] if options.quick else [(6, 5), (12, 8), (20, 10)]
            results["audit"] = bench_audit(2 if options.quick else 20, sizes)
        if options.only in (None, "pictures"):
            size = [(6, 5)] if options.quick else [(16, 8)]
            results["pictures"] = bench_audit(1 if options.quick else 8, size, listed=False)
        if options.only in (None, "scale"):
            n, scenes = (120_000, 1_000) if options.quick else (1_000_000, 10_000)
            results["scale"] = bench_scale(folder, n, scenes)
    for rows in results.values():
        for row in rows:
            print("  ".join(f"{k} {v}" for k, v in row.items()))
    if options.quick:
        return
    document = {
        "command": "python benchmarks/data.py",
        "machine": f"{platform.machine()}, {os.cpu_count()} CPUs, one thread",
        "python": platform.python_version(),
        "numpy": np.__version__,
        "peak_MiB_of_this_process": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
        "results": results,
    }
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
