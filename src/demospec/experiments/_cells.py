"""Cells of the ablation grid: which fits there are, on which sets, and how each is scored."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    ValidityModel,
    bezier_points,
    fit_bezier,
    simulate_set,
)
from demospec.errors import InputError

ABLATIONS = ("full", "autoencoder", "classifier")
MODELS = (*ABLATIONS, "irl", "field")
MOST = 9
"""Most demonstrations per scene and type that a fit sees (paper: 9)."""

HELD_OUT = 9
"""Further demonstrations per scene and type, kept for measuring seen scenes."""


@dataclass(frozen=True)
class GridSettings:
    """Which fits.

    Args:
        models: Of `MODELS`; the first three are ablations of the paper's model.
        counts: Demonstrations per scene and type.
        seeds: Each draws its own set and its own initial weights.
        catalogue: Items of the scenes.
        train_scenes, test_scenes: Per seed.
        reading: ``uniform``: held-out demonstrations are drawn as the training ones, and both
            are what random paths are. ``clustered``: demonstrators repeat themselves. A
            scene's demonstrations of a type are near copies of few paths, as people's are; the
            held-out ones are near copies of the same paths.
        steps: Of the paper's model.
    """

    models: tuple[str, ...] = ("full", "autoencoder", "classifier", "irl")
    counts: tuple[int, ...] = tuple(range(1, MOST + 1))
    seeds: tuple[int, ...] = tuple(range(10))
    catalogue: str = "builtin"
    train_scenes: int = 20
    test_scenes: int = 20
    reading: Literal["uniform", "clustered"] = "uniform"
    steps: int = 300

    def __post_init__(self) -> None:
        for name in self.models:
            if name not in MODELS:
                raise InputError(", ".join(MODELS), name, field="models")
        if not all(1 <= n <= MOST for n in self.counts):
            raise InputError(f"counts from 1 to {MOST}", list(self.counts), field="counts")
        if self.reading not in ("uniform", "clustered"):
            raise InputError("uniform or clustered", self.reading, field="reading")

    def cells(self) -> Iterator[Cell]:
        """Every fit; sets change slowest, so that each is simulated once."""
        for seed in self.seeds:
            for model in self.models:
                for n in self.counts:
                    yield Cell(seed, model, n)


@dataclass(frozen=True)
class Cell:
    """One fit of the grid."""

    seed: int
    model: str
    n: int


def scored(
    cell: Cell,
    model: ValidityModel,
    held_out: DemonstrationSet,
    test: DemonstrationSet,
    truth: Any,
    about: dict[str, Any],
) -> dict[str, Any]:
    """The line of a fit: what is said about it, and its scores on seen and unseen scenes."""
    from demospec.specification import evaluate

    began = time.process_time()
    seen = evaluate(model, held_out, truth=truth).to_json()["types"]
    unseen = evaluate(model, test, truth=truth).to_json()["types"]
    line: dict[str, Any] = {
        **asdict(cell),
        **about,
        "score_seconds": round(time.process_time() - began, 3),
        "types": {},
    }
    for type_ in seen:
        line["types"][type_] = {"seen": seen[type_], "unseen": unseen.get(type_)}
    return line


# Jobs of one seed follow each other: the set that a process has just simulated is the next one's.
@lru_cache(maxsize=1)
def grid_set(settings: GridSettings, seed: int) -> tuple[DemonstrationSet, Any]:
    """The set of one seed, and its truth as a model. `MOST + HELD_OUT` demonstrations each."""
    from demospec.rules import rules_from_document

    data, document = simulate_set(
        catalogue=settings.catalogue,
        train_scenes=settings.train_scenes,
        test_scenes=settings.test_scenes,
        demonstrations=MOST + HELD_OUT,
        seed=seed,
    )
    truth = rules_from_document(document)
    if settings.reading == "clustered":
        data = clustered(data, truth, np.random.default_rng([seed, 11]))
    return data, truth


def clustered(
    data: DemonstrationSet,
    truth: Any,
    rng: np.random.Generator,
    *,
    habits: int = 3,
    spread_px: float = 6.0,
) -> DemonstrationSet:
    """The same scenes with demonstrators of few habits: near copies of `habits` paths a scene.

    Each demonstration of a scene and type is one of its first `habits` paths, the control point
    moved by a normal step of `spread_px` (at 100 px pictures); labels are the truth's.
    """
    d = data.demonstrations
    items: list[Demonstration] = []
    for scene_id, rows in data.rows_by_scene().items():
        scene = data.scene(scene_id)
        width = scene.size_px[0] if scene.size_px is not None else 100
        view = truth.see(scene)
        for type_ in data.types:
            mine = [int(i) for i in rows if d.type[i] == type_]
            if not mine:
                continue
            centres = [fit_bezier(p)[0] for p in d.paths_xy(mine[:habits])]
            pick = rng.integers(len(centres), size=len(mine))
            step = rng.normal(0.0, spread_px * width / 100, (len(mine), 2))
            control = (np.array(centres)[pick] + step)[:, None]
            start = np.tile(np.asarray(scene.start[:2]), (len(mine), 1))
            paths = bezier_points(start, np.asarray(scene.goal[:2]), control, 100)
            valid = view.p_valid(paths, type_) > 0.5
            items += [
                Demonstration(d.demo_id[i], scene_id, path, type_, d.demonstrator[i], bool(v))
                for i, path, v in zip(mine, paths, valid, strict=True)
            ]
    return replace(data, demonstrations=Demonstrations.of(items))


def rank_in_scene(data: DemonstrationSet) -> np.ndarray:
    """(n,) how many demonstrations of the same scene and type come before each."""
    seen: dict[tuple[str, str | None], int] = {}
    out = np.empty(len(data.demonstrations), dtype=np.int64)
    pairs = zip(data.demonstrations.scene_id, data.demonstrations.type, strict=True)
    for i, key in enumerate(pairs):
        out[i] = seen.get(key, 0)
        seen[key] = int(out[i]) + 1
    return out
