"""Fit a model that looks at pictures, and judge paths in scenes and among things it never saw.

python examples/20_judge_pictures.py [OUT]        (needs the extra `vision`)
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from demospec import fit_model, load_model, simulate_set
from demospec.specification import evaluate

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/20_judge_pictures")
data, _ = simulate_set(test_scenes=8, demonstrations=9, seed=4)
model = fit_model(data.of_split("train"))  # the field model: seconds on a laptop
model.save(out / "model", replace=True)

test = data.of_split("test")
unlisted = replace(test, scenes=tuple(replace(scene, objects=None) for scene in test.scenes))
for user_type, score in evaluate(load_model(out / "model"), unlisted).types.items():
    share = score.balanced_accuracy
    print(user_type, "undefined: one class" if share is None else f"{share:.0%} of {score.n} paths")
