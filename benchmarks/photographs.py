"""Photographs that nobody here has drawn: old coins and a cup of coffee.

    python benchmarks/photographs.py
    python benchmarks/photographs.py --network other.safetensors --picture seen.png

Both come with scikit-image (`skimage.data.coins`, `skimage.data.coffee`). The coins, worn reliefs
on a dark cloth, are cut into six parts of two dozen in all, and found by a watershed as
scikit-image's own tutorial does; a coin counts as seen where a thing of the network covers half of
the two together. The coffee is an oblique view with a cup on a saucer: there is no truth beside
the picture. Writes benchmarks/results/photographs.json.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path
from typing import Any

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

from demospec.perception import SHIPPED, load_network, observe  # noqa: E402

REPORTED = Path(__file__).parent / "results" / "photographs.json"
SURE = 0.5
"""Things that the network is less sure of are not counted."""


def coins_and_labels() -> tuple[np.ndarray, np.ndarray]:
    """(h, w, 3) uint8, and (h, w) the number of the coin at every pixel, 0 on the cloth."""
    from scipy import ndimage
    from skimage import data, filters, segmentation

    grey = data.coins()
    seeds = np.zeros(grey.shape, int)
    seeds[grey < 30], seeds[grey > 150] = 1, 2
    ground = segmentation.watershed(filters.sobel(grey), seeds)
    labels, _ = ndimage.label(ndimage.binary_fill_holes(ground - 1))
    small = np.flatnonzero(np.bincount(labels.ravel()) < 500)
    labels[np.isin(labels, small)] = 0
    return np.repeat(grey[..., None], 3, axis=2), labels


def parts(shape: tuple[int, int]) -> list[tuple[slice, slice]]:
    """Two rows of three parts."""
    rows = np.linspace(0, shape[0], 3).astype(int)
    columns = np.linspace(0, shape[1], 4).astype(int)
    return [np.s_[a:b, c:d] for a, b in pairwise(rows) for c, d in pairwise(columns)]


def seen_in(picture: np.ndarray, truth: np.ndarray, sizes: np.ndarray, network: Any) -> Any:
    """Coins, those seen, and the sure things; `sizes`: pixels of every coin when whole."""
    from skimage.draw import polygon2mask

    sure = [
        detection
        for detection in observe(picture, network=network).detections
        if detection.confidence > SURE
    ]
    masks = [polygon2mask(truth.shape, detection.polygon[:, ::-1]) for detection in sure]
    coins = [truth == n for n in np.unique(truth[truth > 0]) if (truth == n).sum() > sizes[n] / 2]
    hits = [any((c & m).sum() > 0.5 * (c | m).sum() for m in masks) for c in coins]
    return len(coins), sum(hits), sure


def study(network: Any) -> tuple[dict[str, Any], list[tuple[np.ndarray, Any]]]:
    """Coins seen and all things; the pictures with what was seen."""
    from skimage import data

    photograph, labels = coins_and_labels()
    sizes = np.bincount(labels.ravel())
    shown, total, hit, things = [], 0, 0, 0
    for part in parts(labels.shape):
        coins, seen, sure = seen_in(photograph[part], labels[part], sizes, network)
        total, hit, things = total + coins, hit + seen, things + len(sure)
        shown.append((photograph[part], sure))
    _, at_once, sure = seen_in(photograph, labels, sizes, network)
    shown.append((photograph, sure))
    coffee = data.coffee()[::3, ::3]
    sure = [
        detection
        for detection in observe(coffee, network=network).detections
        if detection.confidence > SURE
    ]
    shown.append((coffee, sure))
    found = {"coins": total, "seen": hit, "things": things, "seen_at_once": at_once}
    return found | {"things_in_coffee": len(sure)}, shown


def draw(shown: list[tuple[np.ndarray, Any]], out: Path) -> None:
    """Outlines of what was seen."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 4, figsize=(16, 8), layout="constrained")
    for axis in axes.flat:
        axis.axis("off")
    for axis, (picture, detections) in zip(axes.flat, shown, strict=False):
        axis.imshow(picture)
        for detection in detections:
            axis.fill(*detection.polygon.T, fill=False, edgecolor="#E69F00", linewidth=2)
            axis.text(*detection.center, detection.kind, color="white", ha="center", fontsize=11)
    figure.savefig(out, dpi=60)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--network", type=Path, default=None)
    parser.add_argument("--picture", type=Path, default=None)
    parser.add_argument("--out", type=Path, default=REPORTED)
    arguments = parser.parse_args()
    import hashlib

    import torch

    torch.set_num_threads(1)
    path = Path(arguments.network or SHIPPED)
    found, shown = study(load_network(path))
    report = {
        "command": "python " + " ".join(sys.argv),
        "versions": {name: version(name) for name in ("demospec", "torch", "scikit-image")},
        "network": hashlib.sha256(path.read_bytes()).hexdigest()[:8],
        **found,
    }
    arguments.out.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    print(f"coins: {found['seen']} of {found['coins']} seen, {found['things']} things in all")
    print(f"the photograph at once: {found['seen_at_once']} of {found['coins']}")
    print(f"coffee: {found['things_in_coffee']} things")
    if arguments.picture is not None:
        draw(shown, arguments.picture)


if __name__ == "__main__":
    main()
