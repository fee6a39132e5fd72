"""Evidence: what labelled demonstrations showed, in columns of features that have a direction.

A row is a demonstration with its label and its person. A column is a feature whose value says
how safe the path is in one respect: distance to a class of objects, say. Values are stored so
that more is safer, whatever the feature; a rule is then a set of columns with a threshold each.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import blake2b
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules._rule_set import ANYONE
from demospec.rules.clearance._encounters import Passes
from demospec.rules.clearance._measure import Distance

Bools = NDArray[np.bool_]
Sense = Literal["at_least", "at_most"]
Unit = Literal["length", "deg", "speed", "time", "1"]


@dataclass(frozen=True)
class Column:
    """A feature of a path beside the things of a scene, and the direction in which it is safer.

    Args:
        feature: Its name: ``distance``, ….
        of: The class, or the two classes, that it is about; None for the path as such.
        sense: Whether a rule asks for *at least* or for *at most* its threshold.
        unit: Kind of quantity; ``length`` is in units of the set.
        sector: The side of the thing that counts, or None for all sides.
        when: (radius, class): counts only within that distance of that class; None: always.
    """

    feature: str = "distance"
    of: str | tuple[str, str] | None = None
    sense: Sense = "at_least"
    unit: Unit = "length"
    sector: str | None = None
    when: tuple[float, str] | None = None

    @property
    def name(self) -> str:
        """The class for a distance, else the feature with all that qualifies it."""
        if self.feature == "distance" and self.sector is None and isinstance(self.of, str):
            return self.of
        of = "" if self.of is None else self.of if isinstance(self.of, str) else "–".join(self.of)
        when = "" if self.when is None else f"within {self.when[0]:g} of {self.when[1]}"
        return " ".join(part for part in (self.feature, of, self.sector or "", when) if part)


@dataclass(frozen=True, eq=False)
class Preferences:
    """Pairs of paths, measured: which of two somebody would rather have.

    Args:
        preferred, other: (q, K) values, as those of `Evidence`.
        names: (q, 2) demonstrations, the preferred one first.
        person: (q,) who prefers.
    """

    preferred: FloatArray
    other: FloatArray
    names: NDArray[np.object_]
    person: NDArray[np.object_]

    def __len__(self) -> int:
        return len(self.person)

    def view(self, keep: Bools) -> Preferences | None:
        """Some of the pairs; None where none is left."""
        if not keep.any():
            return None
        return Preferences(
            self.preferred[keep], self.other[keep], self.names[keep], self.person[keep]
        )


@dataclass(frozen=True, eq=False)
class Evidence:
    """Labelled demonstrations, measured.

    Args:
        columns: K features.
        values: (n, K) oriented so that more is safer; +inf where nothing is there to come near.
        valid: (n,) accepted or rejected.
        extent: The length scale: `DemonstrationSet.length_scale`.
        rows: (n,) rows of the set.
        demo_id, scene, person, demonstrator: (n,) names; a person is a user type.
        score: (n,) how acceptable, from 0 to 1; NaN where only the verdict is known.
        error: (n, K) standard deviation of each value; 0 where a list says where things are.
        seen: (n,) whether measured in a picture, not by the scene's list.
        distance: What distances were measured to.
        notes: What was left out, and why.
        encounters: Past which objects the demonstrations lead (measured when asked for), or
            None where it is not known.
        preferences: Pairs that were compared, of demonstrations with labels and without; None
            where there are none.
    """

    columns: tuple[Column, ...]
    values: FloatArray
    valid: Bools
    extent: float
    rows: NDArray[np.int64]
    demo_id: NDArray[np.object_]
    scene: NDArray[np.object_]
    person: NDArray[np.object_]
    demonstrator: NDArray[np.object_]
    score: FloatArray
    error: FloatArray
    seen: Bools
    distance: Distance = "footprint"
    notes: tuple[str, ...] = ()
    encounters: Callable[[], Passes] | None = field(default=None, repr=False)
    preferences: Preferences | None = None

    @classmethod
    def of(
        cls,
        values: ArrayLike,
        valid: ArrayLike,
        symbols: Sequence[str],
        *,
        extent: float,
        distance: Distance = "footprint",
        encounters: Callable[[], Passes] | None = None,
    ) -> Evidence:
        """One person's nearest approaches (n, K) to K classes, without a set.

        Raises:
            InputError: Shapes that do not fit, NaN, no demonstration, a symbol twice.
        """
        near, ok, names = _checked(values, valid, symbols)
        n = len(ok)
        anyone = np.full(n, ANYONE, dtype=object)
        nobody = np.full(n, None, dtype=object)
        number = np.arange(n)
        return cls(
            tuple(Column(of=name) for name in names), near, ok, extent, number,
            number.astype(str).astype(object), nobody, anyone, nobody, np.full(n, np.nan),
            np.zeros_like(near), np.zeros(n, dtype=bool), distance, (), encounters,
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.valid)

    @property
    def names(self) -> tuple[str, ...]:
        """The columns by name: classes, for distances."""
        return tuple(column.name for column in self.columns)

    @property
    def unit(self) -> float:
        """A hundredth of the extent: priors and errors of distances are stated in it."""
        return self.extent / 100.0

    @property
    def persons(self) -> tuple[str, ...]:
        """Who demonstrated, in order of first appearance."""
        who = self.person.tolist()
        if self.preferences is not None:
            who += self.preferences.person.tolist()
        return tuple(dict.fromkeys(who))

    def view(self, keep: ArrayLike) -> Evidence:
        """Some of the demonstrations (a mask, or rows in ascending order), and all pairs."""
        mask = np.asarray(keep)
        if mask.dtype != np.bool_:
            chosen = np.zeros(len(self), dtype=bool)
            chosen[mask] = True
            mask = chosen
        encounters = self.encounters
        return replace(
            self,
            values=self.values[mask],
            valid=self.valid[mask],
            rows=self.rows[mask],
            demo_id=self.demo_id[mask],
            scene=self.scene[mask],
            person=self.person[mask],
            demonstrator=self.demonstrator[mask],
            score=self.score[mask],
            error=self.error[mask],
            seen=self.seen[mask],
            encounters=None if encounters is None else lambda: encounters().of_demonstrations(mask),
        )

    def of_person(self, name: str) -> Evidence:
        """The demonstrations and the pairs of one person."""
        own, pairs = self.view(self.person == name), self.preferences
        if pairs is None:
            return own
        return replace(own, preferences=pairs.view(pairs.person == name))

    @property
    def compared(self) -> FloatArray:
        """(n + 2 q, K) values of the demonstrations, then of the preferred, then of the others."""
        pairs = self.preferences
        if pairs is None:
            return self.values
        return np.concatenate([self.values, pairs.preferred, pairs.other])

    @property
    def pairs(self) -> int:
        """How many pairs were compared."""
        return 0 if self.preferences is None else len(self.preferences)

    def by_person(self) -> dict[str, Evidence]:
        """Each person's own."""
        return {name: self.of_person(name) for name in self.persons}

    def at(self, row: int) -> Mapping[str, float]:
        """Column → value of one demonstration."""
        return dict(zip(self.names, self.values[row].tolist(), strict=True))

    @cached_property
    def digest(self) -> bytes:
        """Equal for equal evidence of one person: who fitted it once need not fit it again."""
        parts = blake2b(repr((self.columns, self.extent, self.distance)).encode(), digest_size=16)
        for array in (self.values, self.valid, self.score, self.error, self.seen):
            parts.update(np.ascontiguousarray(array).tobytes())
        if self.preferences is not None:
            parts.update(np.ascontiguousarray(self.compared).tobytes())
        parts.update(repr((self.pairs, self.scene.tolist(), self.encounters is None)).encode())
        return parts.digest()


def _checked(
    values: ArrayLike, valid: ArrayLike, symbols: Sequence[str]
) -> tuple[FloatArray, Bools, tuple[str, ...]]:
    d = np.asarray(values, dtype=np.float64)
    labels = np.asarray(valid)
    names = tuple(symbols)
    if d.ndim != 2 or d.shape != (len(labels), len(names)):
        expected = f"distances of shape ({len(labels)}, {len(names)}): demonstrations, symbols"
        raise InputError(expected, f"shape {d.shape}", field="nearest")
    if len(labels) == 0:
        raise InputError("at least one labelled demonstration", "none", field="valid")
    if labels.dtype != np.bool_ and not np.isin(labels, (0, 1)).all():
        raise InputError("True or False for every demonstration", labels.tolist(), field="valid")
    if np.isnan(d).any() or (d == -np.inf).any():
        raise InputError("distances, +inf where absent", "NaN or -inf", field="nearest")
    if len(set(names)) != len(names):
        raise InputError("each symbol once", list(names), field="symbols")
    return d, labels.astype(bool), names
