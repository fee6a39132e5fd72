"""Why is this path rejected? Which place on it, which object, how much further away.

The answer is checked by its own counterfactual: the path moved by that much at that place is
judged again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from demospec.demonstrations import DifferentiableView, View, densify, resample
from demospec.errors import InputError
from demospec.frames import FloatArray, describe_length
from demospec.scene import SceneObject

_POINTS = 200
_SHARES = np.linspace(0.0, 1.0, 41)


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
            None where the path is valid or no push up to a third of the picture makes it so.
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
    path: ArrayLike,
    type: str,
    *,
    units: str = "px",
    metres_per_unit: float | None = None,
) -> Explanation:
    """Explains a model's verdict on one path.

    The place is where the logit hangs most on the path: the largest |∂logit/∂p| where the view
    has gradients that single out a place, else the point nearest to a listed object. The
    counterfactual pushes the path there, straight away from the object (along the gradient
    where none is listed), as a smooth bump that leaves start and goal where they are.

    Args:
        view: A model that has seen the scene.
        path: (n, 2), pixels.
        type: User type whose verdict is explained.
        units, metres_per_unit: For the sentence.
    """
    points = resample(np.asarray(path, dtype=np.float64)[:, :2], _POINTS)
    logit = float(view.logits(points[None], type)[0])
    slope = _slope(view, points, type)
    at = _place(view, points, slope)
    item, gap = _nearest(view, points[at])
    away = _away(item, points[at], slope[at], points, at)
    share = at / (_POINTS - 1)
    further, changed, extra = None, None, 0.0
    if logit <= 0:
        further, changed, extra = _least_push(view, points, at, away, type, item)
    flips = changed is not None and float(view.logits(changed[None], type)[0]) > 0
    word = None if item is None else f"{item.symbol} {item.id}"
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
        ),
    )


def _slope(view: View, points: FloatArray, type: str) -> FloatArray:
    """∂logit/∂p, (m, 2); zeros where the view has no gradient."""
    if not isinstance(view, DifferentiableView):
        return np.zeros_like(points)
    try:
        return np.asarray(view.logits_and_gradients(points[None], type)[1][0])
    except InputError:
        return np.zeros_like(points)


def _place(view: View, points: FloatArray, slope: FloatArray) -> int:
    weight = np.linalg.norm(slope, axis=1)
    total = float(weight.sum())
    if total > 0:
        # Number of points that share the gradient: a network on z_θ spreads it over all.
        effective = total**2 / float((weight**2).sum())
        if effective < len(points) / 4 or not view.scene.objects:
            return int(weight.argmax())
    objects = view.scene.objects or ()
    if not objects:
        return len(points) // 2
    return int(np.min([o.outline.signed_distance(points) for o in objects], axis=0).argmin())


def _nearest(view: View, place: FloatArray) -> tuple[SceneObject | None, float | None]:
    objects = view.scene.objects or ()
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
        nudge = 1e-3 * np.eye(2)
        shape = item.outline
        direction = shape.signed_distance(place + nudge) - shape.signed_distance(place - nudge)
    along = points[min(at + 1, len(points) - 1)] - points[max(at - 1, 0)]
    across = np.array([-along[1], along[0]])
    norm = float(np.linalg.norm(across))
    if norm < 1e-12:  # a path that stands still has no sides
        across, norm = np.asarray(direction), float(np.linalg.norm(direction))
    unit = across / norm if norm > 1e-12 else np.array([0.0, 1.0])
    return np.asarray(unit if float(unit @ direction) >= 0 else -unit)


def _pushed(points: FloatArray, at: int, push: FloatArray) -> FloatArray:
    """The path with the point `at` moved by `push`, the ends fixed, smooth in between."""
    u = np.linspace(0.0, 1.0, len(points))
    centre = float(np.clip(u[at], 0.02, 0.98))
    # u^a (1 − u)^b peaks at a / (a + b): a bump that reaches over the whole path.
    total = 4.0
    a, b = total * centre, total * (1 - centre)
    bump = (u / centre) ** a * ((1 - u) / (1 - centre)) ** b
    return np.asarray(points + bump[:, None] * push)


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
    span = float(np.ptp(densify(points, 5.0), axis=0).max())
    reach = max(1.0, span) * 0.5
    best: tuple[float, FloatArray] | None = None
    for sign in (1.0, -1.0):
        low = 0.0
        trials = np.stack([_pushed(points, at, sign * s * reach * away) for s in _SHARES[1:]])
        held = np.flatnonzero(view.logits(trials, type) > 0)
        if not len(held):
            continue
        high = float(_SHARES[1 + held[0]]) * reach
        low = float(_SHARES[held[0]]) * reach
        for _ in range(12):
            middle = (low + high) / 2
            trial = _pushed(points, at, sign * middle * away)
            if float(view.logits(trial[None], type)[0]) > 0:
                high = middle
            else:
                low = middle
        if best is None or high < best[0]:
            best = (high, _pushed(points, at, sign * high * away))
    if best is None:
        return None, None, 0.0
    gained = best[0]
    if item is not None:
        shape = item.outline
        before = float(shape.signed_distance(points).min())
        gained = float(shape.signed_distance(best[1]).min()) - before
    return best[0], best[1], gained


def _sentence(
    type: str,
    valid: bool,
    share: float,
    word: str | None,
    gap: float | None,
    further: float | None,
    units: str,
    metres_per_unit: float | None,
) -> str:
    where = f"at {100 * share:.0f} % of the way"
    near = ""
    if word is not None and gap is not None:
        length = describe_length(abs(gap), metres_per_unit, units)
        near = f", {length} {'from' if gap >= 0 else 'inside'} {word}"
    if valid:
        return f"{type} accepts the path; it is decided {where}{near}."
    if further is None:
        return f"{type} rejects the path {where}{near}; moving it there alone does not help."
    length = describe_length(abs(further), metres_per_unit, units)
    side = "further away" if word is not None else "to the side"
    return f"{type} rejects the path {where}{near}; {length} {side} would make it valid."
