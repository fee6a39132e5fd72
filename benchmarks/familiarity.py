"""Which pictures are called unfamiliar: photographs, blurred and spoilt ones, drawn scenes.

    python benchmarks/familiarity.py [--pictures 700] [--write]

Photographs (those that come with scikit-image, whole and in four parts each) and pictures as in
training are judged by heads fitted without them, in eight folds: no part of a photograph is in the
training of the head that judges it. The other kinds are judged by the head that comes with the
package. --write fits that head anew, with all pictures, and stores it in the package's weights.
Writes benchmarks/results/familiarity.json.
"""

from __future__ import annotations

import argparse
import json
import os
from io import BytesIO
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402
from PIL import Image, ImageFilter  # noqa: E402

from demospec.demonstrations import simulate_set  # noqa: E402
from demospec.perception import SHIPPED, load_network, observe, recipe_of  # noqa: E402
from demospec.perception.network._weights import save_network  # noqa: E402
from demospec.perception.training import HeadPictures  # noqa: E402
from demospec.perception.training._familiarity import (  # noqa: E402
    fit_familiarity,
    left_out,
    scenes_as_drawn,
    shown_statistics,
    unlike_pictures,
)
from demospec.perception.training._heads import keep  # noqa: E402

RESULTS = Path(__file__).parent / "results" / "familiarity.json"
SEED = 0


def spoilt(pixels: np.ndarray, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """The same picture blurred, noisy, compressed, dark, and as if seen at a slant."""
    picture = Image.fromarray(pixels)
    width, height = picture.size
    packed = BytesIO()
    picture.save(packed, "JPEG", quality=30)
    out = {"as it is": picture, "JPEG, quality 30": Image.open(packed)}
    for radius in (1, 2, 4):
        out[f"blurred by {radius} px"] = picture.filter(ImageFilter.GaussianBlur(radius))
    for slant in (0.3, 0.6):
        inset = int(width * slant / 2)
        corners = (inset, 0, 0, height, width, height, width - inset, 0)
        out[f"slanted by {slant:g}"] = picture.transform(
            (width, height), Image.Transform.QUAD, corners, Image.Resampling.BILINEAR
        )
    made = {name: np.asarray(p.convert("RGB")) for name, p in out.items()}
    noisy = pixels + rng.normal(0, 40, pixels.shape)
    made["noise of 40 of 255"] = np.clip(noisy, 0, 255).astype(np.uint8)
    made["a sixth of the light"] = (pixels * 0.15).astype(np.uint8)
    return made


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--pictures", type=int, default=700)
    parser.add_argument("--write", action="store_true")
    args = parser.parse_args()
    network, recipe = load_network(), recipe_of()
    given = HeadPictures(SEED, args.pictures, recipe["settings"]["rendered"])
    drawn = [picture for picture, _ in given.drawn(5_000_000, "training the familiarity head")]
    drawn += scenes_as_drawn(SEED, max(1, args.pictures // 10))
    known = np.stack([shown_statistics(network, picture) for picture in drawn])
    other, names = unlike_pictures(network, SEED)
    score, strange = left_out(known, other, names, SEED)
    limit = float(np.quantile(score, 0.05))
    whole = np.array([i == 0 or names[i] != names[i - 1] for i in range(len(names))])
    missed = sorted({n for n, s in zip(names, strange, strict=True) if s >= limit})
    document = {
        "command": f"python benchmarks/familiarity.py --pictures {args.pictures}",
        "as in training, called familiar": float((score >= limit).mean()),
        "photographs": len(set(names)),
        "whole photographs called unfamiliar": float((strange[whole] < limit).mean()),
        "parts of photographs called unfamiliar": float((strange[~whole] < limit).mean()),
        "of these some part is called familiar": missed,
    }
    if args.write:
        keep(network, "familiarity", fit_familiarity(known, other, names, SEED))
        recipe["settings"]["familiarity_pictures"] = args.pictures
        save_network(SHIPPED, network, recipe)
        network = load_network()
    rng = np.random.default_rng(1)
    kinds: dict[str, list[bool]] = {}
    for catalogue, size in (("builtin", 100), ("builtin", 160), ("sweethome3d", 100)):
        data, _ = simulate_set(
            catalogue=catalogue, train_scenes=0, test_scenes=15, demonstrations=1, seed=901,
            size_px=size,
        )  # fmt: skip
        for scene in data.scenes:
            for name, pixels in spoilt(scene.pixels(), rng).items():
                said = observe(pixels, network=network, turns=(0,)).familiarity
                assert said is not None
                kinds.setdefault(name, []).append(said.familiar)
    document["drawn scenes called familiar"] = {k: float(np.mean(v)) for k, v in kinds.items()}
    print(json.dumps(document, indent=1))
    RESULTS.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
