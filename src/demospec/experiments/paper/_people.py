"""Simulated participants: those of the paper's rule, and those whose rule it cannot write.

Each has two quantities a reader can check without any family of rules: the distance below which
a stroke is always rejected, and the distance to each object beyond which the object is ignored.
For somebody of the paper's rule these are T_min and the radii T_min + T_object.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.rules import RuleObject, RuleProblem, RuleScene, RuleTrajectory, evaluate_rule

SIZE: Final = 500
"""Side of the workbench in its own units, our choice: the paper does not print one."""

F_MAX: Final = 2000

OBJECTS: Final = (
    RuleObject("drill", "drill", (180.0, 260.0)),
    RuleObject("toolbox", "toolbox", (340.0, 220.0)),
)

Rule = Callable[[list[FloatArray], np.random.Generator], NDArray[np.bool_]]
"""Strokes, each (60, 2), and the noise of the hand that labels → (n,) accepted."""


@dataclass(frozen=True)
class Participant:
    """Somebody who labels strokes.

    Args:
        words: The rule, for a table.
        T_min: Nearer than this to either object, a stroke is always rejected (but for slips).
        radius: (drill, toolbox): farther than this, the object is always ignored.
        in_family: Some T_min and T_object of the paper give every verdict of this person.
        accepts: The person's own verdicts.
    """

    words: str
    T_min: int
    radius: tuple[int, int]
    in_family: bool
    accepts: Rule


def free_strokes(n: int, rng: np.random.Generator, points: int = 60) -> list[FloatArray]:
    """Freehand strokes over the workbench, each (points, 2), equally spaced in time.

    Up to five places are visited on the way; the hand trembles, hesitates and hurries. No Bézier
    curve of order two comes near such a stroke.
    """
    from scipy.interpolate import PchipInterpolator

    start, goal = np.array([20.0, 480.0]), np.array([480.0, 20.0])
    along = (goal - start) / np.linalg.norm(goal - start)
    out = []
    for _ in range(n):
        via = rng.uniform(0.06 * SIZE, 0.94 * SIZE, (int(rng.integers(2, 6)), 2))
        corners = np.vstack([start, via[np.argsort(via @ along)], goal])
        legs = np.linalg.norm(np.diff(corners, axis=0), axis=1)
        time = np.concatenate([[0.0], np.cumsum(legs * rng.uniform(0.5, 2.0, len(legs)))])
        at = np.linspace(0.0, time[-1], points)
        stroke = PchipInterpolator(time, corners)(at)
        phase = rng.uniform(0, 2 * np.pi, (2, 3, 1))
        waves = np.sin(2 * np.pi * np.array([[[2.0], [5.0], [9.0]]]) * at / time[-1] + phase)
        stroke = stroke + 2.5 * waves.sum(axis=1).T * np.sin(np.pi * at / time[-1])[:, None]
        out.append(np.rint(stroke))
    return out


def _distances(stroke: FloatArray) -> FloatArray:
    """(points, 2) distance to the centre of each object."""
    centres = np.array([item.center for item in OBJECTS])
    return np.asarray(np.linalg.norm(stroke[:, None] - centres, axis=2))


def problem_of(strokes: list[FloatArray], accepted: NDArray[np.bool_]) -> RuleProblem:
    """Labelled strokes as the problem that the solver reads."""
    from demospec.rules import Bounds

    paths = tuple(RuleTrajectory(0, bool(v), s) for v, s in zip(accepted, strokes, strict=True))
    return RuleProblem((RuleScene(OBJECTS),), paths, F_MAX, bounds=Bounds((1, 100), (1, 100)))


def verdicts(strokes: list[FloatArray], T_min: int, T_object: tuple[int, ...]) -> NDArray[np.bool_]:
    """What parameters of the paper's family say, by the plain evaluator."""
    problem = problem_of(strokes, np.ones(len(strokes), dtype=bool))
    own = dict(zip(problem.parameters, T_object, strict=True))
    return np.array([v.valid for v in evaluate_rule(problem, T_min, own)], dtype=bool)


def _of_the_paper(T_min: int, T_object: tuple[int, int]) -> Participant:
    def accepts(strokes: list[FloatArray], rng: np.random.Generator) -> NDArray[np.bool_]:
        return verdicts(strokes, T_min, T_object)

    radius = (T_min + T_object[0], T_min + T_object[1])
    return Participant("the paper's rule", T_min, radius, True, accepts)


def _inconsistent() -> Participant:
    """The first participant on many days: another T_min each time, and one label in ten slips."""
    T_min, own = 40, (20, 60)

    def accepts(strokes: list[FloatArray], rng: np.random.Generator) -> NDArray[np.bool_]:
        days = np.clip(np.rint(rng.normal(T_min, 10, len(strokes))), 1, 100).astype(int)
        said = np.array(
            [verdicts([s], int(day), own)[0] for s, day in zip(strokes, days, strict=True)]
        )
        return np.asarray(said ^ (rng.random(len(strokes)) < 0.1))

    words = "the paper's rule, T_min drawn anew for each stroke (σ = 10), one label in ten wrong"
    return Participant(words, T_min, (T_min + own[0], T_min + own[1]), False, accepts)


def _own_clearance() -> Participant:
    """A clearance for each class, and no sum: a long pass just outside it is fine."""
    clearance = (45, 90)

    def accepts(strokes: list[FloatArray], rng: np.random.Generator) -> NDArray[np.bool_]:
        return np.array([bool((_distances(s).min(axis=0) > clearance).all()) for s in strokes])

    words = "a clearance of its own for each object (45 and 90)"
    return Participant(words, 45, clearance, False, accepts)


def _by_speed() -> Participant:
    """The faster, the farther: 25 at rest, 75 at 20 units a step and above."""

    def accepts(strokes: list[FloatArray], rng: np.random.Generator) -> NDArray[np.bool_]:
        out = []
        for stroke in strokes:
            step = np.linalg.norm(np.gradient(stroke, axis=0), axis=1)
            needed = 25 + 2.5 * np.minimum(step, 20)
            out.append(bool((_distances(stroke).min(axis=1) > needed).all()))
        return np.array(out)

    return Participant("the faster, the farther (25 to 75)", 25, (75, 75), False, accepts)


def _by_side() -> Participant:
    """Farther on the side of the handles, above and to the right, than on the other."""

    def accepts(strokes: list[FloatArray], rng: np.random.Generator) -> NDArray[np.bool_]:
        centres = np.array([item.center for item in OBJECTS])
        out = []
        for stroke in strokes:
            handle = (stroke[:, None] - centres) @ np.array([1.0, 1.0]) > 0
            needed = np.where(handle, 90, 30)
            out.append(bool((_distances(stroke) > needed).all()))
        return np.array(out)

    words = "farther on the side of the handles (90) than on the other (30)"
    return Participant(words, 30, (90, 90), False, accepts)


PEOPLE: Final = (
    # T_min and T_object of the first three: our choice, near the paper's printed T_min.
    _of_the_paper(40, (20, 60)),
    _of_the_paper(41, (50, 50)),
    _of_the_paper(50, (10, 80)),
    _inconsistent(),
    _own_clearance(),
    _by_speed(),
    _by_side(),
)
