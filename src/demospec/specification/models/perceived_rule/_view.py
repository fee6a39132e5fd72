"""A scene as the perceived-rule model observes it: objects, their classes and distances, logits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import Paths
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules import TypeRules
from demospec.scene import Scene
from demospec.specification.models._stored_model import LogisticView
from demospec.specification.models.perceived_rule._paths import LogitMap
from demospec.specification.models.perceived_rule._rule import is_nested_in, of_classes

if TYPE_CHECKING:
    from demospec.specification.models.perceived_rule._model import FieldModel

_SLOPE = 1.702  # logistic ≈ normal distribution function
_LEAK = 0.05
_FAR = -25.0  # log-odds: less changes no digit of `_WRONG`
_WRONG = 1e-5  # a label may be wrong even where nothing is near


@dataclass(frozen=True)
class PerceivedObject:
    """One object in the view, detected or listed.

    Args:
        distance: (h, w) signed distance to it alone on the view's grid, set units.
        classes: Class → probability; what is missing to 1: it is no object.
        error: Standard deviation of the distance near the clearance, set units.
        uncertainty: (h, w) factor of that, place by place; None: 1.
        center: Set units.
        listed: The scene's list says so (else the picture does).
    """

    distance: NDArray[np.float32]
    classes: Mapping[str, float]
    error: float
    center: tuple[float, float]
    listed: bool
    uncertainty: NDArray[np.float32] | None = None

    @property
    def errors(self) -> FloatArray:
        """Standard deviation of the distance, (h, w) or one number; set units."""
        return np.asarray(self.error if self.uncertainty is None else self.error * self.uncertainty)


def logit_map(
    perceived: tuple[PerceivedObject, ...], rule: TypeRules, shape: tuple[int, int]
) -> NDArray[np.float32]:
    """ℓ(p): log-odds that a path whose worst place is p is valid, (h, w).

    p(valid at p) = Π_k (1 − r_k σ(a_k (c_k − d_k(p)))) over objects k with relevance r_k. That
    saturates where r_k < 1, so a small share of a_k (d_k − c_k) of the objects that
    probably matter is added: the gradient never vanishes near them, and the sign hardly moves.
    """
    keep = np.full(shape, np.log1p(-_WRONG))
    leak = np.full(shape, np.inf)
    for item in perceived:
        relevance, clearance, spread = of_classes(rule, item.classes)
        if relevance <= 0.0:
            continue
        slope = _SLOPE / np.hypot(item.errors, spread)
        u = slope * (clearance - item.distance.astype(np.float64))
        # log(1 − r σ(u)) = log(1 + (1 − r) eᵘ) − log(1 + eᵘ); next to nothing far off.
        near = u > _FAR
        v = u[near]
        keep[near] += np.logaddexp(0.0, v + np.log1p(-relevance)) - np.logaddexp(0.0, v)
        if relevance > 0.5:
            leak = np.minimum(leak, -u)
    odds = keep - np.log(-np.expm1(keep))
    return np.asarray(odds + _LEAK * np.where(np.isfinite(leak), leak, 0.0), np.float32)


@dataclass(frozen=True)
class FieldView(LogisticView):
    """An observed scene; a `DifferentiableView`.

    Args:
        model: Whose view it is.
        scene: Of what.
        perceived: The objects in it.
        size: (width, height) that the maps span, set units.
        shape: (h, w) of the maps.
        unit: As of `LogitMap`.
    """

    model: FieldModel
    scene: Scene
    perceived: tuple[PerceivedObject, ...]
    size: tuple[float, float]
    shape: tuple[int, int]
    unit: float = 1.0
    _maps: dict[str, LogitMap] = field(default_factory=dict, repr=False)

    def map_of(self, type: str) -> LogitMap:
        """The logit map of one type; made once.

        Whatever a type accepts, one whose rule is nested in its rule accepts too: of an object
        of uncertain class the mean clearance over the classes could say otherwise.
        """
        if type not in self._maps:
            rules = self.model.rules.rules
            if type not in rules:
                raise InputError(f"one of the types {', '.join(rules)}", type, field="type")
            values = logit_map(self.perceived, rules[type], self.shape)
            for name, other in rules.items():
                if is_nested_in(rules[type], other):
                    values = np.maximum(values, self.map_of(name).values)
            self._maps[type] = LogitMap(values, self.size, self.unit)
        return self._maps[type]

    def logits(self, paths: Paths, type: str) -> FloatArray:
        """(n,) log-odds of validity; unbounded."""
        return self.map_of(type).logits(paths)

    def logits_and_gradients(self, paths: FloatArray, type: str) -> tuple[FloatArray, FloatArray]:
        """(n, m, 2) → logits (n,) and ∂logit/∂paths (n, m, 2)."""
        return self.map_of(type).logits_and_gradients(paths)

    def relevance(self, type: str) -> tuple[tuple[PerceivedObject, float, float, float], ...]:
        """Every object: relevance to the type, clearance, standard deviation of the clearance."""
        rule = self.model.rules.of_type(type)
        return tuple((item, *of_classes(rule, item.classes)) for item in self.perceived)
