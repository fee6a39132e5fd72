"""Simulated demonstration sets with known truth.

Source: Angelov et al. 2020, simulated tabletop and workbench experiments. Differs: objects
have footprints, and validity is decided on the dense path against them, not on the picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._trajectory import Demonstration, Demonstrations
from demospec.demonstrations.simulation._paths import RATE_HZ, bezier_stroke, free_stroke
from demospec.demonstrations.simulation._truth import (
    CLEARANCE_PX,
    margins,
    true_clearances,
    truth_document,
)
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.progress import Progress, silent
from demospec.scene import TASK_SYMBOLS, Scene, draw_scene, load_catalogue

TYPES = ("careful", "normal", "aggressive")

SURE_PX = 0.02
"""No demonstration comes this near to the boundary of its rule (at 100 px): the verdict then
does not hang on rounding."""

_STROKES = {"tabletop": bezier_stroke, "workbench": free_stroke}


@dataclass(frozen=True)
class _Job:
    """What the simulation of one scene's demonstrations needs to know."""

    task: str
    size_px: int
    demonstrations: int
    balanced: bool
    clearances: Any

    @property
    def scale(self) -> float:
        return self.size_px / 100.0


def simulate_set(
    task: str = "tabletop",
    catalogue: str = "builtin",
    train_scenes: int = 20,
    test_scenes: int = 20,
    demonstrations: int = 10,
    seed: int = 0,
    size_px: int = 100,
    *,
    clearance_px: float | None = None,
    label_noise: float = 0.0,
    test_objects: bool = True,
    balanced: bool = False,
    name: str | None = None,
    progress: Progress = silent,
) -> tuple[DemonstrationSet, dict[str, Any]]:
    """A set with three demonstrators whose rules are known, and the document of those rules.

    The same arguments give the same set, byte for byte.

    Args:
        task: ``tabletop`` (bottom left to top right, order-2 Bézier curves with control points
            uniform in [-0.2, 1.2]² picture widths) or ``workbench`` (left to right, free strokes).
        catalogue: ``builtin`` or ``sweethome3d``.
        train_scenes, test_scenes: How many; test scenes hold items that no training scene holds.
        demonstrations: Per scene and type.
        seed: Of everything.
        size_px: Side of the pictures; the table is 0.82 m wide at every size.
        clearance_px: What ``careful`` and ``normal`` keep; by default 3 px at 100 px (2.5 cm).
        label_noise: Share of labels flipped, in [0, 0.5]; the truth document lists them
            under ``flipped``.
        test_objects: False leaves the objects of test scenes unlisted.
        balanced: Draw until half of each scene's and type's demonstrations are valid, where
            300 tries suffice. Off: demonstrations are what random paths are.
        name: Of the set.

    Returns:
        (set, truth): the truth is a rule file; `write_set` puts it into the set as
        ``truth.json``.

    Raises:
        InputError: A count below its minimum, an unknown task or catalogue.
    """
    if task not in TASK_SYMBOLS:
        raise InputError(f"one of the tasks {', '.join(TASK_SYMBOLS)}", task, field="task")
    _check_counts(train_scenes, test_scenes, demonstrations, size_px)
    if not 0.0 <= label_noise <= 0.5:
        raise InputError("a share in [0, 0.5]", label_noise, field="label_noise")
    keep = CLEARANCE_PX * size_px / 100.0 if clearance_px is None else clearance_px
    if not 0.0 <= keep <= 0.3 * size_px:
        raise InputError(f"pixels in [0, {0.3 * size_px:g}]", keep, field="clearance_px")
    parts = {"train": load_catalogue(catalogue, "train"), "test": load_catalogue(catalogue, "test")}
    symbols = tuple(s for s in TASK_SYMBOLS[task] if s in parts["train"].symbols)
    job = _Job(task, size_px, demonstrations, balanced, true_clearances(task, keep, symbols))
    splits = ["train"] * train_scenes + ["test"] * test_scenes
    # One stream per scene: a set with more scenes begins with the scenes of the smaller one.
    streams = [
        np.random.default_rng([seed, 0 if split == "train" else 1, i])
        for i, split in enumerate(splits)
    ]
    scenes: list[Scene] = []
    items: list[Demonstration] = []
    for i, (split, rng) in enumerate(zip(splits, streams, strict=True)):
        scene = draw_scene(
            rng, parts[split], task=task, scene_id=f"{i:04d}", split=split, size_px=size_px
        )
        items += _demonstrate(rng, scene, job)
        scenes.append(scene if split == "train" or test_objects else scene.seen())
        progress("simulating scenes", i + 1, len(splits))
    items, flipped = _with_noise(items, label_noise, np.random.default_rng([seed, 2]))
    metres = 0.82 / size_px
    extra: tuple[tuple[str, Any], ...] = (
        ("simulated", {"task": task, "catalogue": catalogue, "seed": seed}),
    )
    credit = [c for part in parts.values() for c in part.attribution()]
    if credit:
        extra += (("attribution", credit),)
    data = DemonstrationSet(
        scenes=tuple(scenes),
        demonstrations=Demonstrations.of(items),
        name=name or f"{task}-{catalogue}-{seed}",
        metres_per_unit=metres,
        symbols=symbols,
        types=TYPES,
        extra=extra,
    )
    return data, truth_document(
        job.clearances, metres, label_noise=label_noise, flipped=flipped, seed=seed
    )


def _check_counts(train: int, test: int, demonstrations: int, size_px: int) -> None:
    for field, value, least, most in (
        ("train_scenes", train, 0, 1_000_000),
        ("test_scenes", test, 0, 1_000_000),
        ("train_scenes + test_scenes", train + test, 1, 1_000_000),
        ("demonstrations", demonstrations, 1, 1_000_000),
        ("size_px", size_px, 32, 4096),
    ):
        if not least <= value <= most:
            raise InputError(f"a whole number in [{least}, {most}]", value, field=field)


def random_paths(
    rng: np.random.Generator, scene: Scene, n: int, *, task: str = "tabletop", size_px: float = 100
) -> list[FloatArray]:
    """n paths as the task's demonstrators draw them, whatever their verdict."""
    return [_STROKES[task](rng, scene, size_px) for _ in range(n)]


def _demonstrate(rng: np.random.Generator, scene: Scene, job: _Job) -> list[Demonstration]:
    out = []
    for type_, clearance in job.clearances.items():
        paths, valid = _judged_paths(rng, scene, job, clearance)
        for k, (path, ok) in enumerate(zip(paths, valid, strict=True)):
            out.append(
                Demonstration(
                    demo_id=f"{scene.scene_id}-{type_[0]}{k:02d}",
                    scene_id=scene.scene_id,
                    points=path,
                    type=type_,
                    demonstrator=f"{type_}-1",
                    valid=bool(ok),
                    t=np.round(np.arange(len(path)) / RATE_HZ, 6),
                )
            )
    return out


def _judged_paths(
    rng: np.random.Generator, scene: Scene, job: _Job, clearance: dict[str, float]
) -> tuple[list[FloatArray], list[bool]]:
    """As many paths as wanted, with their verdicts; balanced where that is asked for."""
    wanted = job.demonstrations
    room = {True: wanted, False: wanted}
    if job.balanced:
        room = {True: wanted - wanted // 2, False: wanted // 2}
    paths: list[FloatArray] = []
    valid: list[bool] = []
    spare: list[tuple[FloatArray, bool]] = []
    for _ in range(max(1, 300 // wanted) if job.balanced else 100):
        batch = random_paths(rng, scene, wanted, task=job.task, size_px=job.size_px)
        margin = margins(scene, batch, clearance)
        for path, gap in zip(batch, margin, strict=True):
            ok = bool(gap >= 0)
            if abs(gap) < SURE_PX * job.scale or len(paths) >= wanted:
                continue
            if room[ok] > 0:
                room[ok] -= 1
                paths.append(path)
                valid.append(ok)
            else:
                spare.append((path, ok))
        if len(paths) >= wanted:
            break
    for path, ok in spare[: wanted - len(paths)]:  # one class does not occur in this scene
        paths.append(path)
        valid.append(ok)
    return paths, valid


def _with_noise(
    items: list[Demonstration], share: float, rng: np.random.Generator
) -> tuple[list[Demonstration], list[str]]:
    """The demonstrations with a share of the labels flipped, and the ids of those."""
    from dataclasses import replace

    count = round(share * len(items))
    chosen = set(rng.permutation(len(items))[:count].tolist())
    noisy = [replace(d, valid=not d.valid) if i in chosen else d for i, d in enumerate(items)]
    return noisy, [items[i].demo_id for i in sorted(chosen)]
