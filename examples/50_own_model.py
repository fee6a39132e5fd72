"""Your own model of validity in twenty lines: everything that takes a MODEL takes it.

python examples/50_own_model.py
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec import find_causes, simulate_set
from demospec.demonstrations import Paths
from demospec.scene import Scene
from demospec.specification import evaluate, validity_map


@dataclass
class KeepsFromGlasses:
    """Accepts paths that never come nearer than 6 px to the centre of any glass."""

    types: tuple[str, ...] = ("normal",)

    def see(self, scene: Scene) -> GlassView:
        return GlassView(scene)


@dataclass
class GlassView:
    scene: Scene

    def logits(self, paths: Paths, type: str) -> NDArray[np.float64]:
        glasses = [o.center for o in self.scene.listed_objects() if o.symbol == "glass"]
        if not glasses:
            return np.full(len(paths), 5.0)
        gaps = [
            np.linalg.norm(np.asarray(p)[:, None, :2] - np.array(glasses), axis=2).min()
            for p in paths
        ]
        return np.array(gaps) - 6.0

    def p_valid(self, paths: Paths, type: str) -> NDArray[np.float64]:
        return 1.0 / (1.0 + np.exp(-self.logits(paths, type)))


data, _ = simulate_set(train_scenes=8, test_scenes=1, demonstrations=8, seed=10)
train = data.of_split("train")
model = KeepsFromGlasses()
print(f"agrees with the labels: {evaluate(model, train).types['normal'].balanced_accuracy:.0%}")
share = (validity_map(model.see(train.scenes[0]), "normal").p_valid > 0.5).mean()
print(f"accepts {share:.0%} of the control points in scene {train.scenes[0].scene_id}")
print(find_causes(model, train.scenes).sentences[0])
