"""Rules of every user type from a demonstration set."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet, Paths
from demospec.errors import CannotJudgeError, InputError
from demospec.frames import FloatArray, describe_length
from demospec.parallel import run_tasks
from demospec.progress import Progress, silent
from demospec.rules._rule_set import ANYONE, RuleSet, TypeRules
from demospec.rules._sentences import clearance_words, listed, plural
from demospec.rules.clearance._encounters import Passes, passes
from demospec.rules.clearance._fit import ClearanceFit
from demospec.rules.clearance._measure import Distance, nearest_approach
from demospec.rules.clearance._multi_user import Shown, fit_people
from demospec.rules.clearance._posterior import Sharing
from demospec.rules.influence._rule import influence_answer, influence_words
from demospec.scene import Scene

F_MAX = 60
"""Bound on the summed penalty where nobody gives one, as in a problem file."""

Measure = Callable[..., FloatArray]
"""Called as `nearest_approach` is."""

Passing = Callable[..., Passes]
"""Called as `passes` is."""

Measured = TypeVar("Measured", FloatArray, Passes)


@dataclass(frozen=True)
class Approaches:
    """Nearest approaches of the demonstrations of a set that rules can learn from.

    Args:
        rows: (n,) rows of the set's demonstrations.
        nearest: (n, K) see `nearest_approach`; K symbols of the set.
        valid: (n,) accepted or rejected.
        type: (n,) user type.
        notes: What was left out and why.
    """

    rows: NDArray[np.int64]
    nearest: FloatArray
    valid: NDArray[np.bool_]
    type: NDArray[np.object_]
    notes: tuple[str, ...]


def approaches(
    data: DemonstrationSet,
    *,
    split: str | None = "train",
    distance: Distance = "footprint",
    measure: Measure = nearest_approach,
    workers: int = 1,
    cluster: str | None = None,
    progress: Progress = silent,
) -> Approaches:
    """Measures every labelled demonstration whose scene lists its objects.

    Args:
        split: Learn from these scenes only; where none is so marked, and for None, from all.
        measure: In place of `nearest_approach`, for who remembers what it gave before.
        workers, cluster: As of `run_tasks`; scenes are measured apart.

    Raises:
        CannotJudgeError: No labelled demonstration is in a scene that lists its objects.
        InputError: No demonstration is labelled.
    """
    d = data.demonstrations
    notes = []
    labelled = d.valid >= 0
    if not labelled.any():
        raise InputError(
            "demonstrations labelled valid or not", "labels that are all null", field="valid"
        )
    if not labelled.all():
        notes.append(f"{int((~labelled).sum())} demonstrations without a label are ignored")
    keep = labelled
    known = sorted({s.split for s in data.scenes})
    if split not in (None, "train", *known):
        raise InputError(f"a split of the set ({', '.join(known)})", split, field="split")
    if split is not None and any(s.split == split for s in data.scenes):
        inside = {s.scene_id for s in data.scenes if s.split == split}
        in_split = np.array([s in inside for s in d.scene_id], dtype=bool)
        if (keep & in_split).any():
            left_out = int((keep & ~in_split).sum())
            keep = keep & in_split
            if left_out:
                notes.append(f"{left_out} demonstrations of other splits than {split} are left out")
    typed = np.array([t is not None for t in d.type], dtype=bool)
    names = d.type
    if not (typed & keep).any():
        names = np.full(len(d), ANYONE, dtype=object)
        notes.append(f"no demonstration has a user type: all are taken for one, {ANYONE!r}")
    elif not typed[keep].all():
        notes.append(f"{int((keep & ~typed).sum())} demonstrations without a user type are ignored")
        keep = keep & typed
    blind = {s.scene_id for s in data.scenes if s.objects is None}
    rows, tasks = [], []
    skipped: set[str] = set()
    for scene_id, mine in data.rows_by_scene().items():
        mine = mine[keep[mine]]
        if not len(mine):
            continue
        if scene_id in blind:
            skipped.add(scene_id)
            continue
        rows.append(mine)
        tasks.append((data.scene(scene_id), d.paths_xy(mine)))
    parts = run_tasks(
        partial(_measured, measure, data.symbols, distance), tasks, workers=workers,
        cluster=cluster, progress=progress, what="distances",
    )  # fmt: skip
    if not parts:
        raise CannotJudgeError(
            "a list of objects in at least one scene (`demospec detect` makes the list)",
            f"objects not listed in all {len(skipped)} scenes",
            field="objects",
        )
    if skipped:
        notes.append(f"{len(skipped)} scenes do not list their objects and are skipped")
    order = np.argsort(np.concatenate(rows), kind="stable")
    chosen = np.concatenate(rows)[order]
    return Approaches(
        rows=chosen,
        nearest=np.concatenate(parts)[order],
        valid=d.valid[chosen] == 1,
        type=names[chosen],
        notes=tuple(notes),
    )


def _measured(
    measure: Callable[..., Measured],
    symbols: Sequence[str],
    distance: Distance,
    task: tuple[Scene, Paths],
) -> Measured:
    return measure(*task, symbols, distance=distance)


def learn_rules(
    data: DemonstrationSet,
    *,
    sharing: Sharing = "average",
    distance: Distance = "footprint",
    split: str | None = "train",
    influence: bool = True,
    settings: Mapping[str, Any] | None = None,
    measure: Measure = nearest_approach,
    passing: Passing = passes,
    workers: int = 1,
    cluster: str | None = None,
    progress: Progress = silent,
) -> RuleSet:
    """What every user type of a set keeps away from, and how far.

    Args:
        data: At least one labelled demonstration in a scene that lists its objects. Labels
            that are null are ignored with a note; types that are null too, unless no
            demonstration has one: then all are pooled under `ANYONE`.
        sharing: See `fit_clearance`.
        distance: Clearances to the ``footprint`` or to the ``center``.
        split: Learn from scenes of this split (all where none is so marked).
        influence: Answer with the influence family too: thresholds by class about the
            centres, scenes pooled, within five seconds a type. Null, with the reason under
            ``evidence``, where it does not apply.
        settings: Of the influence problem: ``F_max``, ``reading``, ``preset``, ….
        measure: See `approaches`.
        passing: In place of `passes`, likewise.
        workers, cluster: As of `run_tasks`: paths are measured there, scene by scene; the
            rules that follow are found in this process.

    Raises:
        CannotJudgeError: No scene lists its objects.
        InputError: No label.
    """
    seen = approaches(
        data, split=split, distance=distance, measure=measure, workers=workers, cluster=cluster,
        progress=progress,
    )  # fmt: skip
    unit = hundredth(data)
    present = [t for t in data.types if (seen.type == t).any()]
    if not present:
        present = [ANYONE]
    rules: dict[str, TypeRules] = {}
    notes = list(seen.notes)
    for name in data.types:
        if name not in present and present != [ANYONE]:
            notes.append(f"no demonstration to learn from for type {name}")
    of_type = {name: seen.type == name for name in present}
    every = cache(partial(passes_of, data, seen.rows, distance, unit, passing, workers, cluster))
    people = {
        name: Shown(seen.nearest[mine], seen.valid[mine], partial(_of_person, every, mine))
        for name, mine in of_type.items()
    }
    fits = fit_people(people, data.symbols, sharing=sharing, unit=unit, distance=distance)
    for i, (name, fit) in enumerate(fits.items()):
        mine = of_type[name]
        rules[name] = _type_rules(data, seen, mine, fit, settings or {}, influence)
        progress("rules", i + 1, len(present))
    return RuleSet(rules, data.units, data.metres_per_unit, tuple(notes))


def passes_of(
    data: DemonstrationSet,
    rows: NDArray[np.int64],
    distance: Distance,
    unit: float,
    passing: Passing = passes,
    workers: int = 1,
    cluster: str | None = None,
) -> Passes:
    """Which objects some demonstrations (rows, ascending) lead past; their scenes list theirs."""
    scenes = data.demonstrations.scene_id[rows]
    used = list(dict.fromkeys(scenes.tolist()))
    mine = [np.flatnonzero(scenes == scene_id) for scene_id in used]
    tasks = [
        (data.scene(scene_id), data.demonstrations.paths_xy(rows[some]))
        for scene_id, some in zip(used, mine, strict=True)
    ]
    measure = partial(passing, unit=unit)
    found = run_tasks(
        partial(_measured, measure, data.symbols, distance), tasks, workers=workers, cluster=cluster
    )
    return Passes.joined(list(zip(mine, found, strict=True)))


def _of_person(every: Callable[[], Passes], mine: NDArray[np.bool_]) -> Passes:
    return every().of_demonstrations(mine)


def hundredth(data: DemonstrationSet) -> float:
    """A hundredth of the table's width: 1 px of a 100 px picture."""
    widths = [s.size_px[0] for s in data.scenes if s.size_px is not None]
    if widths:
        return float(np.median(widths)) / 100
    points = data.demonstrations.flat[:, :2]
    return max(float(np.ptp(points, axis=0).max()) / 80, 1e-9)


def _type_rules(
    data: DemonstrationSet,
    seen: Approaches,
    mine: NDArray[np.bool_],
    fit: ClearanceFit,
    settings: Mapping[str, Any],
    influence: bool,
) -> TypeRules:
    valid = seen.valid[mine]
    wrong = [str(data.demonstrations.demo_id[r]) for r in seen.rows[mine][list(fit.contradicted)]]
    evidence: dict[str, Any] = {
        "n": len(valid),
        "accepted": int(valid.sum()),
        "rejected": int((~valid).sum()),
        "probability": {s: round(p, 4) for s, p in fit.probability.items()},
        "undecided": list(fit.undecided),
        "contradicted": wrong,
        "at_most": {s: (v if np.isfinite(v) else None) for s, v in fit.at_most.items()},
        "shared_clearance": round(fit.shared, 4),
        "interval": fit.interval_kind,
        "position_noise": round(fit.position_noise, 3),
        "exact": fit.exact,
    }
    answer = None
    if influence:
        chosen = {"F_max": F_MAX, **settings}
        answer, reason = influence_answer(data, seen.rows[mine], valid, chosen)
        words = "" if answer is None else influence_words(answer, data.metres_per_unit)
        evidence["influence"] = words or reason
    return TypeRules(fit.rule, answer, type_sentence(data, fit, valid), evidence)


def type_sentence(data: DemonstrationSet, fit: ClearanceFit, valid: NDArray[np.bool_]) -> str:
    """The clearance rule of one type in plain words."""
    scale, units = data.metres_per_unit, data.units
    if valid.all():
        return _positive_only(fit, scale, units)
    text = clearance_words(
        fit.rule.value,
        fit.symbols,
        fit.rule.uninformed,
        metres_per_unit=scale,
        units=units,
        distance=fit.rule.distance,
    )
    if not valid.any():
        text += "; no demonstration was accepted, so that larger distances are not ruled out"
    if fit.contradicted:
        text += f"; {len(fit.contradicted)} of {len(valid)} demonstrations contradict this"
    return text


def _positive_only(fit: ClearanceFit, scale: float | None, units: str) -> str:
    """What accepted demonstrations alone say: nothing matters for all that is known."""
    text = "no demonstration was rejected: nothing is known to matter"
    kept = {s: c for s, c in fit.at_most.items() if 0.05 < c < np.inf}
    if kept:
        parts = [
            f"{describe_length(c, scale, units)} to {plural(s)}" for s, c in sorted(kept.items())
        ]
        text += (
            f" (the nearest that any came is {listed(parts)}: "
            "a larger distance is not needed, a smaller one may do)"
        )
    return text
