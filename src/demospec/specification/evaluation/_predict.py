"""A model's verdict on every demonstration of a set. Never reads the labels."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from demospec.demonstrations import (
    DemonstrationSet,
    JudgingView,
    Motions,
    Paths,
    ValidityModel,
    Verdict,
    View,
    count_rows,
    iterate_batches,
)
from demospec.errors import CannotJudgeError, InputError
from demospec.progress import Progress, silent
from demospec.rules import RuleView, broken_words
from demospec.specification.models._ensemble import UncertainView


@dataclass(frozen=True)
class Prediction:
    """p(valid) of one demonstration for one user type; None where the model cannot judge.

    An ensemble adds the standard deviation of its members' p(valid); None from other models.
    `verdict` is ``unknown`` where the model cannot judge, or knows that nothing decides. `why`
    names the constraint of a rule that a rejected path breaks, and the place.
    """

    demo_id: str
    scene_id: str
    type: str
    p_valid: float | None
    p_valid_sd: float | None = None
    verdict: Verdict = "unknown"
    why: str | None = None

    def to_json(self) -> dict[str, Any]:
        """One entry of the document of ``demospec predict``."""
        entry = {
            "demo_id": self.demo_id,
            "scene_id": self.scene_id,
            "type": self.type,
            "p_valid": self.p_valid,
            "verdict": self.verdict,
        }
        if self.p_valid_sd is not None:
            entry["p_valid_sd"] = self.p_valid_sd
        if self.why is not None:
            entry["why"] = self.why
        return entry


@dataclass(frozen=True)
class Predictions:
    """Verdicts on the demonstrations of a set.

    Args:
        items: In the order of the set; a demonstration without type has one entry per type.
        unjudged: Scene id → why the model cannot judge it.
        unknown_types: Types of the set that the model does not know: their p is None.
    """

    items: tuple[Prediction, ...]
    unjudged: dict[str, str]
    unknown_types: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The document of ``demospec predict``."""
        return {"predictions": [item.to_json() for item in self.items]}


def predict(
    model: ValidityModel, data: DemonstrationSet, *, progress: Progress = silent
) -> Predictions:
    """p(valid) of every demonstration for its type (for every type, where it has none).

    Raises:
        CannotJudgeError: No scene of the set can be judged.
    """
    d = data.demonstrations
    found: dict[tuple[int, str], tuple[float, float | None, Verdict, str | None]] = {}
    views = Views(model, data, progress)
    for _, rows, view in views:
        for type_ in model.types:
            mine = [int(i) for i in rows if d.type[i] is None or d.type[i] == type_]
            if mine:
                paths = data.motions(mine)
                p = view.p_valid(paths, type_).tolist()
                sd: list[float | None] = [None] * len(mine)
                if isinstance(view, UncertainView):
                    sd = view.p_valid_sd(paths, type_).tolist()
                said = verdicts_of(view, paths, type_, p)
                why = reasons(view, paths, type_, said)
                found.update(
                    {(i, type_): (p[k], sd[k], said[k], why[k]) for k, i in enumerate(mine)}
                )
    views.refuse_if_none()
    items = []
    unknown: dict[str, None] = {}
    for i in range(len(d)):
        for type_ in model.types if d.type[i] is None else (d.type[i],):
            if type_ not in model.types:
                unknown[type_] = None
            judged = found.get((i, type_), (None, None, "unknown", None))
            items.append(Prediction(d.demo_id[i], d.scene_id[i], type_, *judged))
    return Predictions(tuple(items), views.unjudged, tuple(unknown))


def verdicts_of(view: View, paths: Paths, type_: str, p_valid: list[float]) -> list[Verdict]:
    """A view's own verdicts where it knows what is unknown, else those of its probabilities."""
    if isinstance(view, JudgingView):
        return view.verdicts(paths, type_)
    return ["accept" if p > 0.5 else "reject" for p in p_valid]


def reasons(view: View, paths: Motions, type_: str, said: list[Verdict]) -> list[str | None]:
    """Of rejected paths, the constraint that they break most: ``rejected at 63 % of the way: …``.

    None where nothing is rejected, or for another reason than a constraint.
    """
    out: list[str | None] = [None] * len(said)
    if not isinstance(view, RuleView) or not view.model.of_type(type_).constraints:
        return out
    for i, (motion, verdict) in enumerate(zip(paths.motions, said, strict=True)):
        broken = view.broken(motion, type_) if verdict == "reject" else []
        if broken:
            words = broken_words(broken[0], view.model.units, view.model.metres_per_unit)
            out[i] = f"rejected {words}"
    return out


def predict_part(model: ValidityModel, data: DemonstrationSet) -> Predictions:
    """As `predict`; where no scene can be judged, every entry has p None instead."""
    try:
        return predict(model, data)
    except CannotJudgeError as error:
        why = f"expected {error.expected}, found {error.found}"
        d = data.demonstrations
        items = [
            Prediction(d.demo_id[i], d.scene_id[i], type_, None)
            for i in range(len(d))
            for type_ in (model.types if d.type[i] is None else (d.type[i],))
        ]
        return Predictions(tuple(items), {scene.scene_id: why for scene in data.scenes})


def predict_batches(
    model: ValidityModel,
    folder: str | os.PathLike[str],
    *,
    rows: int = 100_000,
    progress: Progress = silent,
) -> Iterator[Predictions]:
    """As `predict`, for a set on disk of any size: one `Predictions` for each batch of rows.

    A batch whose scenes cannot be judged has entries with p None; `predict` refuses a set
    where that is so for every scene, which a batch cannot know.
    """
    done, total = 0, count_rows(folder)
    for batch in iterate_batches(folder, rows=rows):
        yield predict_part(model, batch)
        done += len(batch.demonstrations)
        progress("judging demonstrations", done, total)


class Views:
    """Goes through the scenes of a set that have demonstrations, seeing each once.

    Yields (scene id, rows of its demonstrations, view); scenes that the model cannot judge are
    left out and kept in `unjudged` with the reason.
    """

    def __init__(
        self, model: ValidityModel, data: DemonstrationSet, progress: Progress = silent
    ) -> None:
        self.model = model
        self.data = data
        self.progress = progress
        self.unjudged: dict[str, str] = {}
        self._first: CannotJudgeError | None = None
        self._judged = 0

    def __iter__(self) -> Iterator[tuple[str, np.ndarray, View]]:
        groups = self.data.rows_by_scene()
        for done, (scene_id, rows) in enumerate(groups.items()):
            try:
                view = self.model.see(self.data.scene(scene_id))
            except CannotJudgeError as error:
                self.unjudged[scene_id] = f"expected {error.expected}, found {error.found}"
                self._first = self._first or error
                continue
            self._judged += 1
            yield scene_id, rows, view
            self.progress("judging scenes", done + 1, len(groups))

    def refuse_if_none(self) -> None:
        """Raises the first reason where not a single scene could be judged."""
        if self._first is not None and self._judged == 0:
            raise self._first


def check_type(model: ValidityModel, type_: str) -> None:
    """InputError, listing the types there are, where the model does not know this one."""
    if type_ not in model.types:
        raise InputError(f"one of the types {', '.join(model.types)}", type_, field="type")
