"""Repair of a set's rejected demonstrations, judged by the rule that made the labels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet, ValidityModel, View
from demospec.errors import CannotJudgeError, InputError
from demospec.frames import FloatArray, describe_length
from demospec.progress import Progress, silent
from demospec.rules import RuleView, constraint_words
from demospec.specification.evaluation._predict import Views, check_type
from demospec.specification.latent._repair import RepairSettings, repair
from demospec.specification.models.beta_vae._training_data import bezier_controls


@dataclass(frozen=True)
class Repaired:
    """One repaired demonstration.

    Args:
        demo_id, scene_id: Which.
        points: (100, 2), set units.
        control: (order − 1, 2), set units.
        moved: Distance from the first to the last z_θ, set units.
        steps: Gradient steps until the kept point.
        p_valid: The model's own opinion.
        rule_valid: The rule's verdict; None without a rule, or where it cannot judge.
        trace: (steps + 1, order − 1, 2), from the rejected to the repaired z_θ.
    """

    demo_id: str
    scene_id: str
    points: FloatArray
    control: FloatArray
    moved: float
    steps: int
    p_valid: float
    rule_valid: bool | None
    trace: FloatArray

    def to_json(self) -> dict[str, Any]:
        """One item of the document of ``demospec repair``."""
        return {
            "demo_id": self.demo_id,
            "scene_id": self.scene_id,
            "points": self.points.tolist(),
            "control": self.control.tolist(),
            "moved": self.moved,
            "steps": self.steps,
            "p_valid": self.p_valid,
            "rule_valid": self.rule_valid,
            "trace": self.trace.tolist(),
        }


@dataclass(frozen=True)
class RepairedSet:
    """Repairs of a type's rejected demonstrations.

    Args:
        type: The user type.
        items: In the order of the set.
        unjudged: Scene id → why the model cannot judge it.
        units, metres_per_unit: Of the set.
    """

    type: str
    items: tuple[Repaired, ...]
    unjudged: dict[str, str]
    units: str = "px"
    metres_per_unit: float | None = None

    def length(self, value: float) -> str:
        """A length of the set in words."""
        return describe_length(value, self.metres_per_unit, self.units)

    @property
    def success(self) -> float | None:
        """Share of repairs that the rule accepts; None where it judged none (vacuous)."""
        judged = [r.rule_valid for r in self.items if r.rule_valid is not None]
        return float(np.mean(judged)) if judged else None

    def summary(self) -> str:
        """One line: how many, how far, how many hold."""
        if not self.items:
            return f"vacuous: no demonstration of {self.type} is rejected"
        moved = float(np.median([r.moved for r in self.items]))
        own = np.mean([r.p_valid > 0.5 for r in self.items])
        line = f"{len(self.items)} repaired, control point moved {self.length(moved)} (median); "
        line += f"the model itself accepts {own:.0%}"
        if self.success is not None:
            line += f"; the rule accepts {self.success:.0%}"
        return line

    def to_json(self) -> dict[str, Any]:
        """The document of ``demospec repair``."""
        return {
            "type": self.type,
            "repairs": [r.to_json() for r in self.items],
            "success": self.success,
            "summary": self.summary(),
        }


def repair_set(
    model: ValidityModel,
    data: DemonstrationSet,
    type: str,
    *,
    rules: ValidityModel | None = None,
    settings: RepairSettings | None = None,
    order: int = 2,
    progress: Progress = silent,
) -> RepairedSet:
    """Repairs the demonstrations of one type that are not valid.

    Those are the ones labelled invalid; where nobody said, those that the model rejects.

    Args:
        rules: Truth or learned rules that judge the outcome; they have no part in the repair.
        order: Order of the Bézier curves.

    Raises:
        InputError: The model does not know the type, or its rule asks for heights, tilts or times.
        CannotJudgeError: The model can judge no scene of the set.
    """
    check_type(model, type)
    d = data.demonstrations
    views = Views(model, data, progress)
    found: dict[int, Repaired] = {}
    for scene_id, rows, view in views:
        mine = np.array([i for i in rows if d.type[i] == type], dtype=np.int64)
        unsaid = mine[d.valid[mine] < 0]
        rejected = list(mine[d.valid[mine] == 0])
        if len(unsaid):
            rejected += list(unsaid[view.logits(d.paths_xy(unsaid), type) <= 0])
        if not rejected:
            continue
        chosen = np.sort(np.array(rejected, dtype=np.int64))
        paths = d.paths_xy(chosen)
        _refuse_beyond_places(view, paths[0], type)
        done = repair(
            view,
            bezier_controls(paths, order),
            type,
            start=np.array([p[0] for p in paths]),
            goal=np.array([p[-1] for p in paths]),
            known_invalid=d.valid[chosen] == 0,
            settings=settings,
        )
        verdict = _judged(rules, data, scene_id, done.points, type)
        for k, i in enumerate(chosen):
            found[int(i)] = Repaired(
                demo_id=d.demo_id[i],
                scene_id=scene_id,
                points=done.points[k],
                control=done.control[k],
                moved=float(done.moved[k]),
                steps=int(done.steps[k]),
                p_valid=float(done.p_valid[k]),
                rule_valid=None if verdict is None else bool(verdict[k]),
                trace=done.trace[k],
            )
    views.refuse_if_none()
    items = tuple(found[i] for i in sorted(found))
    return RepairedSet(type, items, views.unjudged, data.units, data.metres_per_unit)


def _refuse_beyond_places(view: View, path: FloatArray, type: str) -> None:
    """Curves of the plane hold no heights, tilts or times: they cannot be repaired in these."""
    if not isinstance(view, RuleView):
        return
    asked = view.model.of_type(type).constraints
    for c, margin in zip(asked, view.margins([path], type)[0], strict=True):
        if np.isnan(margin):
            expected = "a rule about places (a repair knows no heights, tilts or times)"
            words = constraint_words(c, view.model.units, view.model.metres_per_unit)
            raise InputError(expected, words, field=f"types.{type}")


def _judged(
    rules: ValidityModel | None, data: DemonstrationSet, scene_id: str, paths: FloatArray, type: str
) -> NDArray[np.bool_] | None:
    if rules is None or type not in rules.types:
        return None
    try:
        return np.asarray(rules.see(data.scene(scene_id)).p_valid(paths, type) > 0.5)
    except CannotJudgeError:
        return None
