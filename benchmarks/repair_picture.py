"""The paper's repair picture: z_θ's curve through the steps, dark to light blue.

    python benchmarks/repair_picture.py        # writes docs/images/repair.png

Rows: two unseen scenes. Columns: one particle (the paper's way), 16 particles. Model and judge
are the rule that made the labels, type careful.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from demospec.demonstrations import simulate_set
from demospec.rules import rules_from_document
from demospec.specification import ControlPlane, RepairSettings, repair

TARGET = Path(__file__).parents[1] / "docs" / "images" / "repair.png"


def main() -> None:
    data, document = simulate_set(train_scenes=1, test_scenes=4, demonstrations=1, seed=0)
    truth = rules_from_document(document)
    figure, axes = plt.subplots(2, 2, figsize=(8, 8.4), constrained_layout=True)
    rng = np.random.default_rng(3)
    for row, scene in zip(axes, data.of_split("test").scenes[1:3], strict=True):
        view = truth.see(scene)
        plane = ControlPlane(view)
        z = rng.uniform(10, 90, (400, 1, 2))
        z = z[plane.logits(z, "careful") < -4][:1]
        for axis, particles in zip(row, (1, 16), strict=True):
            done = repair(view, z, "careful", settings=RepairSettings(particles=particles))
            way = plane.paths(done.trace[0])
            axis.imshow(scene.pixels(), extent=(0, 100, 100, 0))
            shades = plt.get_cmap("Blues_r")(np.linspace(0.0, 0.75, len(way)))
            for k, (path, shade) in enumerate(zip(way, shades, strict=True)):
                last = k == len(way) - 1
                axis.plot(*path.T, color=shade, linewidth=2.6 if last else 1.3)
            axis.plot(*way[0].T, color="#D55E00", linewidth=1.8, linestyle="--")
            verdict = "holds" if done.holds[0] else "does not hold"
            name = "1 particle" if particles == 1 else f"{particles} particles"
            axis.set_title(f"{name}: moved {done.moved[0]:.0f} px, {verdict}", fontsize=10)
            axis.set(xlim=(0, 100), ylim=(100, 0), xlabel="x, px", ylabel="y, px")
    figure.suptitle("Repair for careful: rejected path dashed, steps dark to light", fontsize=11)
    TARGET.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(TARGET, dpi=80)


if __name__ == "__main__":
    main()
