"""Three verdicts on a path: accept, reject, or unknown where no demonstration decides.

A class that matters decides where some path as near was accepted, or some path as far was rejected
for it alone; where labels contradict the rule, outside its interval. In between, and nearer to any
other class than an accepted path ever came, nothing was shown.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import Paths, Verdict
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules._goodness import Fit
from demospec.rules.clearance._measure import Distance, nearest_approach
from demospec.rules.constraints._constraint import Constraint
from demospec.scene import Scene


@dataclass(frozen=True)
class Known:
    """What demonstrations decided about every class, for one user type.

    Args:
        reject_below: Class → distance below which a path is rejected; −inf for none.
        accept_from: Class → distance from which a path is accepted; +inf for none.
        default: Distance from which things that nothing is known about are let be: the
            largest clearance that is known, 0 where none is.
        decided: Whether anything was decided at all.
    """

    reject_below: Mapping[str, float]
    accept_from: Mapping[str, float]
    default: float
    decided: bool = True

    def unknown(self, symbol: str) -> bool:
        """Whether nothing was shown about a class."""
        return symbol not in self.accept_from

    def keep_from(self, symbol: str) -> float:
        """How far a path must stay from a class for its acceptance to be known."""
        return self.accept_from.get(symbol, self.default)


def known_of(
    value: Mapping[str, float],
    interval: Mapping[str, tuple[float, float]],
    evidence: Mapping[str, Any],
    fit: Fit | None,
) -> Known:
    """What a learned rule's demonstrations decided. Arguments as of `ClearanceRule`, `TypeRules`.

    A rule without evidence (written by hand) is certain of every class.
    """
    ends = {symbol: interval.get(symbol, (c, c)) for symbol, c in value.items()}
    bounds = [b for end in ends.values() for b in end if np.isfinite(b)]
    default = max([*value.values(), *bounds, 0.0])
    reject = {symbol: low for symbol, (low, _) in ends.items()}
    accept = {symbol: high for symbol, (_, high) in ends.items()}
    decided = evidence.get("decided")
    if isinstance(decided, Mapping):
        for symbol, (low, high) in decided.items():
            if low is not None:
                farther = float(np.nextafter(float(low), np.inf))
                reject[symbol] = max(reject[symbol], farther)
            if high is not None:
                accept[symbol] = min(accept[symbol], float(high))
    at_most = evidence.get("at_most")
    if isinstance(at_most, Mapping):
        for symbol, nearest in at_most.items():
            if nearest is not None and symbol not in value:
                accept[str(symbol)] = float(nearest)
    return Known(reject, accept, default, fit is None or fit.verdict != "not")


def decided_by(
    value: Mapping[str, float],
    names: Sequence[str],
    distances: FloatArray,
    valid: NDArray[np.bool_],
) -> dict[str, list[float | None]]:
    """Class → [distance of the farthest path that it alone rejects, of the nearest accepted].

    For a rule that no label contradicts: both ends are then known, whatever may be wrong with
    the positions of things.

    Args:
        value: Class that matters → clearance.
        names: K classes; `distances` (n, K) and `valid` (n,) are what they were learned from.
    """
    columns = [names.index(symbol) for symbol in value]
    near = distances[:, columns]
    below = near < np.array(list(value.values()))
    out: dict[str, list[float | None]] = {}
    for j, symbol in enumerate(value):
        alone = ~valid & below[:, j] & (below.sum(axis=1) == 1)
        far, close = near[alone, j], near[valid, j]
        ends = (far.max(initial=-np.inf), close.min(initial=np.inf))
        out[symbol] = [float(end) if np.isfinite(end) else None for end in ends]
    return out


def verdicts(
    known: Known, scene: Scene, paths: Paths, distance: Distance, *, learned: bool
) -> list[Verdict]:
    """``accept``, ``reject`` or ``unknown`` for each path.

    Args:
        learned: Whether classes without a bound are unknown (else they do not matter).

    Raises:
        CannotJudgeError: The scene does not list its objects.
    """
    symbols = tuple(dict.fromkeys(o.symbol for o in scene.listed_objects()))
    near = nearest_approach(scene, paths, symbols, distance=distance)
    out = np.full(len(near), "accept", dtype=object)
    if not known.decided:
        return ["unknown"] * len(near)
    # Rejection is known whatever else is not.
    rejected = np.zeros(len(near), dtype=bool)
    for k, symbol in enumerate(symbols):
        column: FloatArray = near[:, k]
        rejected |= column < known.reject_below.get(symbol, -np.inf)
        if symbol in known.accept_from or learned:
            out[column < known.keep_from(symbol)] = "unknown"
    out[rejected] = "reject"
    said: list[Verdict] = out.tolist()
    return said


def constraint_verdicts(constraint: Constraint, margins: FloatArray) -> list[Verdict]:
    """``accept``, ``reject`` or ``unknown`` by one constraint.

    Unknown is what cannot be measured (NaN), and what lies within its interval.

    Args:
        margins: (n,) see `rules.margins`.
    """
    out = np.where(margins >= 0, "accept", "reject").astype(object)
    out[np.isnan(margins)] = "unknown"
    if constraint.interval is not None:
        low, high = constraint.interval
        ends = sorted(constraint.sign * (constraint.value - end) for end in (low, high))
        # margin + end: the margin to the end of the interval that asks for least, and for most.
        with np.errstate(invalid="ignore"):  # nothing of it there, and no end
            doubted = (margins < 0) & (margins + ends[1] >= 0)
            doubted |= (margins >= 0) & (margins + ends[0] < 0)
        out[doubted] = "unknown"
    said: list[Verdict] = out.tolist()
    return said


def refuse_unexplained(fit: Fit | None, type: str, *, anyway: bool = False) -> None:
    """Refuses to use a rule that does not explain the answers it was learned from.

    Raises:
        InputError: The verdict of the fit is ``not``; `anyway` lets it pass.
    """
    if fit is not None and fit.verdict == "not" and not anyway:
        found = f"verdict not ({fit.contradicted} of {fit.n} contradicted, p = {fit.p_chance:.2g})"
        raise InputError(
            "a rule that explains the answers (--anyway uses it all the same)",
            found,
            field=f"types.{type}.fit",
        )
