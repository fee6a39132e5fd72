"""What the rules room hands over: rules per type, which are a `ValidityModel` too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from demospec.demonstrations import Paths, densify
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.scene import Disc, Scene


@dataclass(frozen=True)
class ClearanceRule:
    """A path is acceptable iff it keeps at least c_k from everything of class k that matters.

    Args:
        value: Relevant symbol → clearance, set units; the point answer.
        interval: Relevant symbol → [lower end, upper end] that the demonstrations allow.
        uninformed: Symbols about which no demonstration says anything.
        distance: Measured from the ``footprint`` (signed) or from the ``center``.
    """

    value: Mapping[str, float]
    interval: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    uninformed: tuple[str, ...] = ()
    distance: Literal["footprint", "center"] = "footprint"

    @property
    def relevant(self) -> tuple[str, ...]:
        """The symbols that matter."""
        return tuple(self.value)

    def margins(self, scene: Scene, paths: Paths) -> FloatArray:
        """(n,) smallest distance − clearance along each dense path; ≥ 0 where it is kept.

        +inf where nothing in the scene matters. Set units.

        Raises:
            CannotJudgeError: The scene does not list its objects.
        """
        objects = [o for o in scene.listed_objects() if o.symbol in self.value]
        margins = np.full(len(paths), np.inf)
        for i, path in enumerate(paths):
            dense = densify(np.asarray(path)[:, :2])
            for item in objects:
                shape = item.outline if self.distance == "footprint" else Disc(item.center, 0.0)
                gap = float(shape.signed_distance(dense).min()) - self.value[item.symbol]
                margins[i] = min(margins[i], gap)
        return margins


@dataclass(frozen=True)
class TypeRules:
    """What one user type follows: the clearance family, the influence family, in words."""

    clearance: ClearanceRule | None = None
    influence: Any | None = None
    sentence: str = ""


@dataclass(frozen=True)
class RuleSet:
    """Rules per user type; the answer of ``demospec rules SET`` and a `ValidityModel`."""

    rules: Mapping[str, TypeRules]
    units: str = "px"
    metres_per_unit: float | None = None

    @property
    def types(self) -> tuple[str, ...]:
        return tuple(self.rules)

    def see(self, scene: Scene) -> RuleView:
        """Look at a scene; CannotJudgeError where it does not list its objects."""
        scene.listed_objects()
        return RuleView(self, scene)

    def of_type(self, type: str) -> TypeRules:
        """The rules of one type; InputError lists the types there are."""
        if type not in self.rules:
            raise InputError(f"one of the types {', '.join(self.rules)}", type, field="type")
        return self.rules[type]


@dataclass(frozen=True)
class RuleView:
    """A rule set that looks at one scene. The verdict is certain: p is 0 or 1."""

    model: RuleSet
    scene: Scene

    def logits(self, paths: Paths, type: str) -> FloatArray:
        """The margin in set units (see `ClearanceRule.margins`), capped at 1e6."""
        rule = self.model.of_type(type).clearance
        if rule is None:
            raise InputError("a clearance rule", "none", field=f"types.{type}.clearance")
        margins = rule.margins(self.scene, paths)
        # A margin of exactly 0 keeps the rule; a logit of 0 would not count as valid.
        return np.minimum(np.where(margins >= 0, np.maximum(margins, 1e-9), margins), 1e6)

    def p_valid(self, paths: Paths, type: str) -> FloatArray:
        return (self.logits(paths, type) > 0).astype(np.float64)
