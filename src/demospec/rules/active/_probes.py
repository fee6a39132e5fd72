"""Paths worth asking about: grazing paths, and approach – dwell – leave probes.

A probe goes straight from its start to a place at a chosen distance from one object, stays
there for some points (to and fro on a circle about the object, so that the distance holds and
the path has length), and goes straight on to the goal. With one point of stay it grazes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from demospec.frames import FloatArray

MOST_POINTS = 400


@dataclass(frozen=True)
class Place:
    """Where probes of one scene may go.

    Args:
        scene: Index.
        starts, goals: (a, 2) and (b, 2) ends of paths.
        centers: (q, 2) of the objects.
        rest: Further columns of a point, constant along a probe.
    """

    scene: int
    starts: FloatArray
    goals: FloatArray
    centers: FloatArray
    rest: tuple[float, ...] = ()


@dataclass(frozen=True)
class Probe:
    """One path in a few numbers, so that neighbours of a good one can be tried.

    Args:
        place: Where.
        start, goal: (2,)
        item: Which object it goes near.
        angle: Direction from the object to the stay, radians.
        distance: Of the stay from the object's centre, set units.
        stay: Points spent there, ≥ 1.
        step: Set units between points on the way.
    """

    place: Place
    start: FloatArray
    goal: FloatArray
    item: int
    angle: float
    distance: float
    stay: int
    step: float

    def points(self) -> FloatArray:
        """(n, 2 + further columns), rounded to a tenth."""
        center = self.place.centers[self.item]
        swing = 0.5 * self.step / max(self.distance, self.step)
        turn = self.angle + swing * np.where(np.arange(self.stay) % 2 == 0, 0.0, 1.0)
        dwell = center + self.distance * np.column_stack([np.cos(turn), np.sin(turn)])
        path = np.concatenate(
            [self._leg(self.start, dwell[0])[:-1], dwell, self._leg(dwell[-1], self.goal)[1:]]
        )
        if self.place.rest:
            rest = np.broadcast_to(np.array(self.place.rest), (len(path), len(self.place.rest)))
            path = np.concatenate([path, rest], axis=1)
        return np.asarray(np.round(path, 1) + 0.0)

    def _leg(self, a: FloatArray, b: FloatArray) -> FloatArray:
        count = int(np.ceil(np.linalg.norm(b - a) / self.step)) + 1
        return np.asarray(np.linspace(a, b, int(np.clip(count, 2, MOST_POINTS))))

    def varied(self, rng: np.random.Generator) -> Probe:
        """A neighbour of this probe."""
        return replace(
            self,
            angle=self.angle + 0.3 * rng.standard_normal(),
            distance=max(0.1, self.distance + rng.choice([0.3, 1.0, 3.0]) * rng.standard_normal()),
            stay=int(np.clip(self.stay + rng.integers(-2, 3), 1, MOST_POINTS)),
            step=self.step * float(np.exp(0.2 * rng.standard_normal())),
        )


def draw_probe(
    rng: np.random.Generator, place: Place, item: int, distance: float, enough: float
) -> Probe:
    """A random probe that comes `distance` near to an object.

    Args:
        enough: About how many points of stay decide the verdict.
    """
    span = max(float(np.ptp(np.concatenate([place.starts, place.goals, place.centers]))), 1.0)
    stay = 1 if rng.random() < 0.35 else int(np.ceil(enough * np.exp(0.7 * rng.standard_normal())))
    return Probe(
        place=place,
        start=place.starts[rng.integers(len(place.starts))],
        goal=place.goals[rng.integers(len(place.goals))],
        item=item,
        angle=float(rng.uniform(0.0, 2 * np.pi)),
        distance=max(float(distance), 0.1),
        stay=int(np.clip(stay, 1, MOST_POINTS)),
        step=span * float(rng.choice([0.02, 0.05, 0.1, 0.25, 0.6])),
    )
