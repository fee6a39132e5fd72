"""Small worlds with a known clearance rule, for the tests of this folder."""

from __future__ import annotations

import numpy as np

from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet, bezier_points
from demospec.scene import Capsule, Disc, Polygon, Scene, SceneObject

SYMBOLS = ("utensil", "plate", "bowl", "glass")


def scene(rng: np.random.Generator, name: str = "s", symbols: tuple[str, ...] = SYMBOLS) -> Scene:
    """Two to four objects on a 100 × 100 table, none near the ends of the paths."""
    ends = np.array([[10.0, 90.0], [90.0, 10.0]])
    while True:
        items = []
        for j in range(int(rng.integers(2, 5))):
            symbol = str(rng.choice(symbols)) if j else symbols[-1]
            c = rng.uniform(15, 85, 2)
            shape: Capsule | Disc | Polygon
            if symbol == "utensil":
                a = rng.uniform(0, np.pi)
                h = 12 * np.array([np.cos(a), np.sin(a)])
                shape = Capsule(tuple(c - h), tuple(c + h), 1.5)
            elif symbol == "plate":
                turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
                shape = Polygon(c + 12 * np.column_stack([np.cos(turn), np.sin(turn)]))
            else:
                shape = Disc(tuple(c), 8.0 if symbol == "bowl" else 4.5)
            items.append(SceneObject(f"{symbol}-{j}", symbol, tuple(c), None, shape))
        if all(o.outline.signed_distance(ends).min() > 6 for o in items):
            return Scene(name, (10.0, 90.0), (90.0, 10.0), tuple(items))


def curves(rng: np.random.Generator, count: int) -> np.ndarray:
    """(count, 60, 2) order-2 curves from corner to corner."""
    control = rng.uniform(-10, 110, (count, 1, 2))
    return bezier_points((10.0, 90.0), (90.0, 10.0), control, 60)


def accepts(nearest: np.ndarray, rule: dict[str, float]) -> np.ndarray:
    """(n,) the definition of a clearance rule, from nearest approaches (n, 4)."""
    ok = np.ones(len(nearest), dtype=bool)
    for k, symbol in enumerate(SYMBOLS):
        if symbol in rule:
            ok &= nearest[:, k] >= rule[symbol]
    return ok


def demonstration_set(
    rng: np.random.Generator, rules: dict[str, dict[str, float]], scenes: int, each: int
) -> DemonstrationSet:
    """A set without pictures whose types follow `rules`."""
    from demospec.rules import nearest_approach

    places, items = [], []
    for s in range(scenes):
        place = scene(rng, f"{s:02d}")
        places.append(place)
        for name, rule in rules.items():
            paths = curves(rng, each)
            ok = accepts(nearest_approach(place, paths, SYMBOLS), rule)
            for i, (path, valid) in enumerate(zip(paths, ok, strict=True)):
                items.append(
                    Demonstration(f"{s}-{name}-{i}", place.scene_id, path, name, None, bool(valid))
                )
    return DemonstrationSet(
        scenes=tuple(places),
        demonstrations=Demonstrations.of(items),
        symbols=SYMBOLS,
        types=tuple(rules),
        metres_per_unit=0.0082,
    )
