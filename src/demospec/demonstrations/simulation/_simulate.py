"""Simulated demonstration sets with known truth.

Source: Angelov et al. 2020, simulated tabletop and workbench experiments. Differs: objects
have footprints, and validity is decided on the dense path against them, not on the picture.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from demospec.demonstrations._motion import Motion, Motions
from demospec.demonstrations._protocol import ValidityModel
from demospec.demonstrations._set import DemonstrationSet
from demospec.demonstrations._trajectory import Demonstration, Demonstrations
from demospec.demonstrations.simulation._details import Details
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
    rule: ValidityModel | None
    details: Details

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
    rule: ValidityModel | None = None,
    details: Details | None = None,
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
        rule: Labels by this rule, one demonstrator for each of its types, in the place of the
            three built-in ones; lengths in pixels. See `demospec.rules.simulate_by_rule`.
        details: What scenes and paths hold beside outlines and places.

    Returns:
        (set, truth): the truth is a rule file; `write_set` puts it into the set as
        ``truth.json``. With `rule` it is what there is to say beside the rule.

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
    details = details or Details()
    clearances = true_clearances(task, keep, symbols)
    job = _Job(task, size_px, demonstrations, balanced, clearances, rule, details)
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
        beside = np.random.default_rng([seed, 3, i])
        scene = details.of_scene(scene, beside, size_px)
        items += _demonstrate(rng, beside, scene, job)
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
        demonstrations=Demonstrations.of(items, columns=len(details.names)),
        name=name or f"{task}-{catalogue}-{seed}",
        metres_per_unit=metres,
        symbols=symbols,
        types=TYPES if rule is None else tuple(rule.types),
        columns=details.names,
        extra=extra,
    )
    if rule is not None:
        return data, {"label_noise": label_noise, "flipped": flipped, "seed": seed}
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


def _demonstrate(
    rng: np.random.Generator, beside: np.random.Generator, scene: Scene, job: _Job
) -> list[Demonstration]:
    out = []
    types = tuple(job.clearances) if job.rule is None else tuple(job.rule.types)
    short = [t[0] for t in types] if len({t[0] for t in types}) == len(types) else list(types)
    for letter, type_ in zip(short, types, strict=True):
        paths, valid = _judged_paths(rng, beside, scene, job, type_)
        for k, (path, ok) in enumerate(zip(paths, valid, strict=True)):
            out.append(
                Demonstration(
                    demo_id=f"{scene.scene_id}-{letter}{k:02d}",
                    scene_id=scene.scene_id,
                    points=path.points,
                    type=type_,
                    demonstrator=f"{type_}-1",
                    valid=bool(ok),
                    t=path.t,
                )
            )
    return out


def _judge(scene: Scene, job: _Job, type_: str) -> Callable[[Motions], FloatArray]:
    """By how much paths of one scene keep the rule of one type."""
    if job.rule is None:
        return lambda paths: margins(scene, paths, job.clearances[type_])
    view = job.rule.see(scene)
    return lambda paths: view.logits(paths, type_)


def _judged_paths(
    rng: np.random.Generator, beside: np.random.Generator, scene: Scene, job: _Job, type_: str
) -> tuple[list[Motion], list[bool]]:
    """As many paths as wanted, with their verdicts; balanced where that is asked for."""
    judge = _judge(scene, job, type_)
    wanted = job.demonstrations
    room = {True: wanted, False: wanted}
    if job.balanced:
        room = {True: wanted - wanted // 2, False: wanted // 2}
    paths: list[Motion] = []
    valid: list[bool] = []
    spare: list[tuple[Motion, bool]] = []
    for _ in range(max(1, 300 // wanted) if job.balanced else 100):
        batch = random_paths(rng, scene, wanted, task=job.task, size_px=job.size_px)
        moved = Motions(job.details.of_path(p, beside, job.size_px, RATE_HZ) for p in batch)
        for path, gap in zip(moved.motions, judge(moved), strict=True):
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
