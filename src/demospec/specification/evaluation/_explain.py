"""Explanation of a rejected path: the place on it, the object, the distance that is missing.

The answer is checked by its own counterfactual: the path moved by that much at that place is
judged again.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.demonstrations import DifferentiableView, Motion, Motions, View, resample
from demospec.errors import InputError
from demospec.frames import FloatArray, describe_length
from demospec.geometry import extent
from demospec.rules import RuleView, Worst, broken_words
from demospec.scene import SceneObject

_POINTS = 200
_SHARES = np.linspace(0.0, 1.0, 41)
_BLOCKS = (6, 16)
"""Where the steps of `_SHARES` are parted: the first are tried first."""
_ROUNDS, _GRID = 4, 8
"""Every round narrows the least push by 8: after four it is known to 3e-6 of the path's span."""


@dataclass(frozen=True)
class Explanation:
    """Why a model rejects one path, or how near to rejection it is.

    Args:
        valid: The model's verdict on the path.
        logit: Its score.
        place: The point of the path that decides, pixels.
        share: How far along the path that is, in [0, 1] of its length.
        object_id, symbol: The listed object nearest to the place, or None where none is listed.
        gap: Distance from the place to that object's outline, pixels, negative inside.
        further: How much further away the place must be for the path to be valid, pixels;
            None where the path is valid, no push up to half the path's span makes it so, or
            none was tried.
        flips: The counterfactual path, pushed by `further`, is judged valid.
        counterfactual: That path, (200, 2), or None.
        sentence: The same in words.
    """

    valid: bool
    logit: float
    place: tuple[float, float]
    share: float
    object_id: str | None
    symbol: str | None
    gap: float | None
    further: float | None
    flips: bool
    counterfactual: FloatArray | None
    sentence: str

    def to_json(self) -> dict[str, Any]:
        """As one JSON object."""
        path = self.counterfactual
        return {
            "valid": self.valid,
            "logit": self.logit,
            "place": list(self.place),
            "share": self.share,
            "object": self.object_id,
            "symbol": self.symbol,
            "gap": self.gap,
            "further": self.further,
            "flips": self.flips,
            "counterfactual": None if path is None else path.tolist(),
            "sentence": self.sentence,
        }


def explain(
    view: View,
    path: ArrayLike | Motion,
    type: str,
    *,
    units: str = "px",
    metres_per_unit: float | None = None,
    counterfactual: bool = True,
    symbols: Collection[str] | None = None,
) -> Explanation:
    """Explains a model's verdict on one path.

    The place is where the logit hangs most on the path: the largest |∂logit/∂p| where the view
    has gradients that single out a place, else the point nearest to a listed object. The
    counterfactual pushes the path there, straight away from the object (along the gradient
    where none is listed), as a smooth bump that leaves start and goal where they are.

    Args:
        view: A model that has seen the scene.
        path: (n, 2), pixels; or a motion with times and columns, for rules that ask for more
            than places.
        type: User type whose verdict is explained.
        units, metres_per_unit: For the sentence.
        counterfactual: Look for the push that would make a rejected path valid. Without it the
            place and its object are named only, in a tenth of the time.
        symbols: Classes that can decide; None: every listed object can.
    """
    motion = path if isinstance(path, Motion) else Motion(np.asarray(path, dtype=np.float64)[:, :2])
    if isinstance(view, RuleView) and view.model.of_type(type).constraints:
        broken = view.broken(motion, type)
        if broken:
            return _of_constraint(view, motion, broken[0], type)
    points = resample(motion.xy, _POINTS)
    logit = float(view.logits(points[None], type)[0])
    slope = _slope(view, points, type)
    objects = tuple(o for o in view.scene.objects or () if symbols is None or o.symbol in symbols)
    at = _place(objects, points, slope)
    item, gap = _nearest(objects, points[at])
    away = _away(item, points[at], slope[at], points, at)
    share = at / (_POINTS - 1)
    further, changed, extra = None, None, 0.0
    if logit <= 0 and counterfactual:
        further, changed, extra = _least_push(view, points, at, away, type, item)
    flips = changed is not None and float(view.logits(changed[None], type)[0]) > 0
    word = None if item is None else item.id
    return Explanation(
        valid=logit > 0,
        logit=logit,
        place=(float(points[at, 0]), float(points[at, 1])),
        share=share,
        object_id=None if item is None else item.id,
        symbol=None if item is None else item.symbol,
        gap=gap,
        further=extra if further is not None else None,
        flips=flips,
        counterfactual=changed,
        sentence=_sentence(
            type,
            logit > 0,
            share,
            word,
            gap,
            None if further is None else extra,
            units,
            metres_per_unit,
            tried=counterfactual,
        ),
    )


def _of_constraint(view: RuleView, motion: Motion, worst: Worst, type: str) -> Explanation:
    """The constraint that a path breaks most; no push in the plane is looked for."""
    share = 0.5 if worst.share is None else worst.share
    item = next((o for o in view.scene.objects or () if o.id in worst.objects), None)
    place = motion.at(share)
    gap = None if item is None else float(item.outline.signed_distance(np.array(place)))
    words = broken_words(worst, view.model.units, view.model.metres_per_unit)
    return Explanation(
        valid=False,
        logit=float(view.logits(Motions([motion]), type)[0]),
        place=place,
        share=share,
        object_id=None if item is None else item.id,
        symbol=None if item is None else item.symbol,
        gap=gap,
        further=None,
        flips=False,
        counterfactual=None,
        sentence=f"{type} rejects the path {words}.",
    )


def _slope(view: View, points: FloatArray, type: str) -> FloatArray:
    """∂logit/∂p, (m, 2); zeros where the view has no gradient."""
    if not isinstance(view, DifferentiableView):
        return np.zeros_like(points)
    try:
        return np.asarray(view.logits_and_gradients(points[None], type)[1][0])
    except InputError:
        return np.zeros_like(points)


def _place(objects: Sequence[SceneObject], points: FloatArray, slope: FloatArray) -> int:
    weight = np.linalg.norm(slope, axis=1)
    total = float(weight.sum())
    if total > 0:
        # Number of points that share the gradient: a network on z_θ spreads it over all.
        effective = total**2 / float((weight**2).sum())
        if effective < len(points) / 4 or not objects:
            return int(weight.argmax())
    if not objects:
        return len(points) // 2
    return int(np.min([o.outline.signed_distance(points) for o in objects], axis=0).argmin())


def _nearest(
    objects: Sequence[SceneObject], place: FloatArray
) -> tuple[SceneObject | None, float | None]:
    if not objects:
        return None, None
    gaps = [float(o.outline.signed_distance(place)) for o in objects]
    best = int(np.argmin(gaps))
    return objects[best], gaps[best]


def _away(
    item: SceneObject | None, place: FloatArray, slope: FloatArray, points: FloatArray, at: int
) -> FloatArray:
    """Unit vector across the path, away from the object: up its distance, else up the logit.

    Across, because a push along the path moves it nowhere.
    """
    direction = slope
    if item is not None:
        shape = item.outline
        nudge = 1e-5 * max(_span(points), extent(shape.bounds)) * np.eye(2)
        direction = shape.signed_distance(place + nudge) - shape.signed_distance(place - nudge)
    along = points[min(at + 1, len(points) - 1)] - points[max(at - 1, 0)]
    across = np.array([-along[1], along[0]])
    norm = float(np.linalg.norm(across))
    if norm == 0:  # a path that stands still has no sides
        across, norm = np.asarray(direction), float(np.linalg.norm(direction))
    unit = across / norm if norm > 0 else np.array([0.0, 1.0])
    return np.asarray(unit if float(unit @ direction) >= 0 else -unit)


def _span(points: FloatArray) -> float:
    """The longer side of the box around a path."""
    return float(np.ptp(points, axis=0).max())


def _pushed(points: FloatArray, at: int, pushes: FloatArray) -> FloatArray:
    """The path with the point `at` moved by each of `pushes` (k, 2), (k, m, 2).

    The ends are fixed, and it is smooth in between.
    """
    u = np.linspace(0.0, 1.0, len(points))
    centre = float(np.clip(u[at], 0.02, 0.98))
    # u^a (1 − u)^b peaks at a / (a + b): a bump that reaches over the whole path.
    total = 4.0
    a, b = total * centre, total * (1 - centre)
    bump = (u / centre) ** a * ((1 - u) / (1 - centre)) ** b
    return np.asarray(points + bump[:, None] * pushes[:, None, :])


def _least_push(
    view: View,
    points: FloatArray,
    at: int,
    away: FloatArray,
    type: str,
    item: SceneObject | None,
) -> tuple[float | None, FloatArray | None, float]:
    """The smallest push that makes the path valid, the path, and the distance it gains.

    Both directions along `away` are tried: deep inside an object the nearer side may be behind.
    """
    reach = 0.5 * (_span(points) or view.scene.length_scale)

    def held(pushes: FloatArray) -> NDArray[np.bool_]:
        """Whether the path is valid after each signed push along `away`, in one call."""
        return np.asarray(view.logits(_pushed(points, at, pushes[:, None] * away), type) > 0)

    steps = reach * _SHARES[1:]
    best: tuple[float, FloatArray] | None = None
    for step, sign in _first_held(held, steps):
        low, high = float(reach * _SHARES[step]), float(steps[step])
        for _ in range(_ROUNDS):
            grid = np.linspace(low, high, _GRID + 1)
            inner = held(sign * grid[1:-1])
            k = int(inner.argmax()) + 1 if inner.any() else _GRID
            low, high = float(grid[k - 1]), float(grid[k])
        if best is None or high < best[0]:
            # A hair more: alone, a path's logit may be rounded otherwise than among others.
            best = (high, _pushed(points, at, np.array([sign * (high + 1e-9 * reach) * away]))[0])
    if best is None:
        return None, None, 0.0
    gained = best[0]
    if item is not None:
        shape = item.outline
        before = float(shape.signed_distance(points).min())
        gained = float(shape.signed_distance(best[1]).min()) - before
    return best[0], best[1], gained


def _first_held(
    held: Callable[[FloatArray], NDArray[np.bool_]], steps: FloatArray
) -> list[tuple[int, float]]:
    """The first step that holds and its sign; both signs where both hold at it; maybe none.

    Most pushes are short: the long ones are only tried where no short one helps.
    """
    for part in np.split(np.arange(len(steps)), _BLOCKS):
        valid = held(np.concatenate([steps[part], -steps[part]])).reshape(2, -1)
        if valid.any():
            k = int(valid.any(axis=0).argmax())
            return [(int(part[k]), s) for s, v in zip((1.0, -1.0), valid[:, k], strict=True) if v]
    return []


def _sentence(
    type: str,
    valid: bool,
    share: float,
    word: str | None,
    gap: float | None,
    further: float | None,
    units: str,
    metres_per_unit: float | None,
    tried: bool,
) -> str:
    where = f"at {100 * share:.0f} % of the way"
    near = ""
    if word is not None and gap is not None:
        length = describe_length(abs(gap), metres_per_unit, units)
        near = f", {length} {'from' if gap >= 0 else 'inside'} {word}"
    if valid and word is None:
        return f"{type} accepts the path: nothing that is listed here is known to matter."
    if valid:
        return f"{type} accepts the path; it is decided {where}{near}."
    if not tried:
        return f"{type} rejects the path {where}{near}."
    if further is None:
        return f"{type} rejects the path {where}{near}; moving it there alone does not help."
    length = describe_length(abs(further), metres_per_unit, units)
    side = "further away" if word is not None else "to the side"
    return f"{type} rejects the path {where}{near}; {length} {side} would make it valid."
