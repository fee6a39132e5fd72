"""How well scenes come back from the latent code, beside the paper's VAE and the mean picture.

    python benchmarks/latent.py [--picture docs/images/latent.png]

20 training scenes, 20 unseen scenes with unseen items, both catalogues. Errors are root mean
squared over all pixels of a scene (1 = white), averaged over scenes. Writes
benchmarks/results/latent.json (or --out).
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

from demospec.demonstrations import simulate_set  # noqa: E402
from demospec.perception import (  # noqa: E402
    CodeLength,
    SceneCode,
    SceneSampler,
    draw_scene_code,
    observe,
    read_scene_code,
)
from demospec.specification import PaperModel  # noqa: E402

REPORTED = Path(__file__).parent / "results" / "latent.json"
SHORT = CodeLength(outline=8, luma=8, chroma=3, low=3, waves=12)


def errors(drawn: list[np.ndarray], true: list[np.ndarray]) -> dict[str, float]:
    """Mean RMSE and mean PSNR over scenes."""
    gaps = [
        np.sqrt(((a / 255.0 - b / 255.0) ** 2).mean()) for a, b in zip(drawn, true, strict=True)
    ]
    return {"rmse": float(np.mean(gaps)), "psnr_db": float(np.mean(-20 * np.log10(gaps)))}


def fifteen(code: SceneCode) -> np.ndarray:
    """15 numbers: the table's colour, and two largest things as discs (x, y, radius, colour)."""
    bare = draw_scene_code(code.with_objects(())).reshape(-1, 3).mean(axis=0)
    whole = draw_scene_code(code).astype(float)
    out = np.broadcast_to(bare, whole.shape).copy()
    y, x = np.mgrid[0 : whole.shape[0], 0 : whole.shape[1]] + 0.5
    for slot in sorted(code.objects, key=lambda s: -float(s.half.prod()))[:2]:
        radius = max(float(np.sqrt(((slot.half - 1.5) * code.per_pixel).prod())), 0.5)
        center = slot.center * code.per_pixel
        cover = np.clip(0.5 + radius - np.hypot(x - center[0], y - center[1]), 0, 1)
        inside = cover > 0.5
        if inside.any():
            colour = whole[inside].mean(axis=0)
            out = out * (1 - cover[..., None]) + colour * cover[..., None]
    return (np.clip(out, 0, 255) + 0.5).astype(np.uint8)


def round_trip(sampler: SceneSampler, n: int) -> dict[str, float]:
    """A second look at sampled scenes: are the things found that were put in?"""
    total, false, gaps = 0, 0, []
    for scene, _ in sampler.sample(n, np.random.default_rng(0)):
        boxes = [s.bbox for s in observe(scene.pixels()).detections if s.confidence >= 0.5]
        middles = np.array([(b[0] + b[2] / 2, b[1] + b[3] / 2) for b in boxes]).reshape(-1, 2)
        used = set()
        for item in scene.objects or ():
            total += 1
            gap = np.hypot(*(middles - item.center).T)
            if len(gap) and gap.min() < 4:
                gaps.append(float(gap.min()))
                used.add(int(gap.argmin()))
        false += len(boxes) - len(used)
    return {
        "things": total, "recall": len(gaps) / max(1, total), "false_per_scene": false / n,
        "centre_median_px": float(np.median(gaps)), "centre_worst_px": float(np.max(gaps)),
    }  # fmt: skip


def study(catalogue: str, seed: int, sampled: int) -> tuple[dict[str, Any], list[list[np.ndarray]]]:
    """All figures of one catalogue, and pictures: true, code, VAE, sampled."""
    data, _ = simulate_set(
        catalogue=catalogue, train_scenes=20, test_scenes=20, demonstrations=9, seed=seed
    )
    train, test = data.of_split("train"), data.of_split("test")
    true = [scene.pixels() for scene in test.scenes]
    codes = [read_scene_code(scene) for scene in test.scenes]
    short = [read_scene_code(scene, length=SHORT) for scene in test.scenes]
    paper = PaperModel.fit(train)
    mean = np.mean([scene.pixels() for scene in train.scenes], axis=0)
    drawn = [draw_scene_code(code) for code in codes]
    vae = [paper.reconstruct(scene) for scene in test.scenes]
    rows = {
        "code": {"numbers": float(np.mean([c.numbers for c in codes])), **errors(drawn, true)},
        "short code": {
            "numbers": float(np.mean([c.numbers for c in short])),
            **errors([draw_scene_code(c) for c in short], true),
        },
        "table and two discs": {"numbers": 15, **errors([fifteen(c) for c in codes], true)},
        "paper's VAE": {"numbers": 15, **errors(vae, true)},
        "mean training picture": {"numbers": 0, **errors([mean] * len(true), true)},
    }
    known = tuple(read_scene_code(scene) for scene in train.scenes)
    sampler = SceneSampler(known, tuple((s.start, s.goal) for s in train.scenes))
    rows_trip = round_trip(sampler, sampled)
    new = [scene.pixels() for scene, _ in sampler.sample(8, np.random.default_rng(0))]
    return {"catalogue": catalogue, "rows": rows, "round_trip": rows_trip}, [true, drawn, vae, new]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=21)
    parser.add_argument("--catalogues", default="builtin,sweethome3d")
    parser.add_argument("--sampled", type=int, default=30)
    parser.add_argument("--picture", type=Path, default=None)
    parser.add_argument("--out", type=Path, default=REPORTED)
    arguments = parser.parse_args()
    import torch

    torch.set_num_threads(1)
    found, sheets = [], []
    for catalogue in arguments.catalogues.split(","):
        row, pictures = study(catalogue, arguments.seed, arguments.sampled)
        found.append(row)
        sheets += [np.concatenate(line[:8], axis=1) for line in pictures]
        for name, r in row["rows"].items():
            print(f"{catalogue:<12} {name:<22} {r['numbers']:>6.0f}  {r['rmse']:.4f}  "
                  f"{r['psnr_db']:.1f} dB", flush=True)  # fmt: skip
        print(catalogue, row["round_trip"], flush=True)
    if arguments.picture is not None:
        import PIL.Image

        sheet = PIL.Image.fromarray(np.concatenate(sheets[:4], axis=0))
        sheet.quantize(128).save(arguments.picture, optimize=True)
    report = {
        "command": "python " + " ".join(sys.argv),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, one thread",
        "versions": {n: version(n) for n in ("demospec", "numpy", "torch")},
        "seed": arguments.seed,
        "catalogues": found,
    }
    arguments.out.parent.mkdir(exist_ok=True)
    arguments.out.write_text(json.dumps(report, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    sys.exit(main())
