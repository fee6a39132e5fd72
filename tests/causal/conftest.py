"""Scenes of discs without pictures, and models that are formulas: nothing here needs a network."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Disc, Scene, SceneObject
from demospec.testing import SYMBOLS, FormulaModel

RADIUS = {"utensil": 5.0, "plate": 8.0, "bowl": 7.0, "glass": 4.0}
CLEARANCE = 3.0


def disc_scene(seed: int, scene_id: str | None = None, count: int = 4) -> Scene:
    """A table of 100 × 100 with discs that stand apart, every symbol once or less."""
    rng = np.random.default_rng(seed)
    items: list[SceneObject] = []
    for k in range(count):
        symbol = SYMBOLS[(seed + k) % 4]
        radius = RADIUS[symbol]
        for _ in range(200):
            x, y = rng.uniform(radius, 100 - radius, 2)
            center = (float(x), float(y))
            ends = min(np.hypot(x - 10, y - 90), np.hypot(x - 90, y - 10))
            gaps = [o.outline.signed_distance(center) - radius for o in items]
            if ends > radius + 8 and min(gaps, default=9.0) > 3:
                items.append(
                    SceneObject(f"{symbol}-{k}", symbol, center, None, Disc(center, radius))
                )
                break
    name = scene_id or f"{seed:04d}"
    return Scene(name, (10.0, 90.0), (90.0, 10.0), tuple(items))


@pytest.fixture(scope="session")
def scenes() -> tuple[Scene, ...]:
    """Twenty disc scenes."""
    return tuple(disc_scene(i) for i in range(20))


@pytest.fixture(scope="session")
def make_scene() -> Callable[..., Scene]:
    return disc_scene


@pytest.fixture(scope="session")
def truth() -> RuleSet:
    """careful avoids everything, normal avoids glasses, aggressive avoids nothing."""
    return RuleSet(
        {
            "careful": TypeRules(ClearanceRule(dict.fromkeys(SYMBOLS, CLEARANCE))),
            "normal": TypeRules(ClearanceRule({"glass": CLEARANCE})),
            "aggressive": TypeRules(ClearanceRule({})),
        }
    )


@pytest.fixture(scope="session")
def formula_model() -> type[FormulaModel]:
    return FormulaModel
