"""Answer of the influence engines, as a value and as the JSON document of ``rules``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

Status = Literal["optimal", "infeasible", "timeout"]

Parameters = tuple[int, ...]
"""(T_min, T_object of every parameter in order)."""


@dataclass(frozen=True)
class InfluenceAnswer:
    """Everything that the demonstrations say about (T_min, T_object-k).

    Args:
        status: ``optimal``: every field is exact. ``infeasible``: no parameters agree with
            all labels, see `conflict`. ``timeout``: what was found is consistent, and
            `bound` holds what is proven.
        names: Names of the T_object.
        min: The printed optimum at the least L = T_min + Σ T_object: the lexicographically
            smallest.
        max: The printed optimum at the greatest L: the one with the largest T_min, then the
            lexicographically smallest T_object.
        n_feasible: Number of consistent parameter sets; None where not counted.
        hull_T_min: Least and greatest T_min over all consistent parameter sets.
        hull_radius: The same for every r_k = T_min + T_object-k.
        optima_min: Consistent parameter sets that attain the least L, printed one first, up
            to a limit; `n_optima_min` counts them all (None where not counted).
        bound: On time-out, L is proven to lie within.
        hull_exact: Whether the hull is proven (always, unless the status is timeout).
        conflict: Indices of a minimal conflicting subset of the trajectories.
        contradicted: Of a tolerant fit: as few demonstrations as any parameters contradict,
            by index; those that `fewest.min` does.
        allowed: The other fields describe all parameter sets that contradict up to so many.
        label_noise: Share of labels taken to be wrong, from which `allowed` follows.
        fewest: The same answer about the sets that contradict fewest alone.
        seconds: Wall time used.
    """

    status: Status
    names: tuple[str, ...]
    settings: Mapping[str, Any]
    engine: str
    seconds: float
    min: Parameters | None = None
    max: Parameters | None = None
    n_feasible: int | None = None
    hull_T_min: tuple[int, int] | None = None
    hull_radius: tuple[tuple[int, int], ...] | None = None
    optima_min: tuple[Parameters, ...] = ()
    optima_max: tuple[Parameters, ...] = ()
    n_optima_min: int | None = None
    n_optima_max: int | None = None
    bound: tuple[int, int] | None = None
    hull_exact: bool = True
    conflict: tuple[int, ...] | None = None
    contradicted: tuple[int, ...] | None = None
    allowed: int | None = None
    label_noise: float | None = None
    fewest: InfluenceAnswer | None = None
    trajectory_ids: tuple[str | None, ...] = field(default=(), repr=False)

    @property
    def L_min(self) -> int | None:
        """Least T_min + Σ T_object."""
        return None if self.min is None else sum(self.min)

    @property
    def L_max(self) -> int | None:
        """Greatest T_min + Σ T_object."""
        return None if self.max is None else sum(self.max)

    @property
    def saturated_min(self) -> tuple[str, ...]:
        """Parameters of the printed minimum that sit on a domain bound."""
        return self._saturated(self.min)

    @property
    def saturated_max(self) -> tuple[str, ...]:
        """Parameters of the printed maximum that sit on a domain bound."""
        return self._saturated(self.max)

    @property
    def saturated(self) -> tuple[str, ...]:
        """Names at a domain bound in either printed optimum: set by the bound, not by data."""
        both = {*self.saturated_min, *self.saturated_max}
        return tuple(name for name in ("T_min", *self.names) if name in both)

    def _saturated(self, values: Parameters | None) -> tuple[str, ...]:
        if values is None:
            return ()
        bounds = self.settings["bounds"]
        ends = [bounds["T_min"]] + [bounds["T_object"]] * len(self.names)
        names = ("T_min", *self.names)
        return tuple(n for n, v, e in zip(names, values, ends, strict=True) if v in e)

    def timed(self, seconds: float) -> InfluenceAnswer:
        """The same answer with the time used."""
        return replace(self, seconds=seconds)

    def to_json(self) -> dict[str, Any]:
        """The JSON document of the contract, and more fields."""
        document: dict[str, Any] = {
            "status": self.status,
            "min": self._optimum(self.min),
            "max": self._optimum(self.max),
            "n_feasible": self.n_feasible,
            "hull": None,
            "optima_min": [list(row) for row in self.optima_min],
            "optima_max": [list(row) for row in self.optima_max],
            "n_optima_min": self.n_optima_min,
            "n_optima_max": self.n_optima_max,
            "saturated": list(self.saturated),
            "saturated_min": list(self.saturated_min),
            "saturated_max": list(self.saturated_max),
            "seconds": self.seconds,
            "engine": self.engine,
            "settings": dict(self.settings),
        }
        if self.hull_T_min is not None and self.hull_radius is not None:
            document["hull"] = {
                "T_min": list(self.hull_T_min),
                "radius": {
                    name: list(pair)
                    for name, pair in zip(self.names, self.hull_radius, strict=True)
                },
            }
        if self.bound is not None:
            document["bound"] = {"L": list(self.bound), "hull_exact": self.hull_exact}
        if self.conflict is not None:
            document["conflict"] = list(self.conflict)
        if self.contradicted is not None:
            document["contradicted"] = list(self.contradicted)
            document["n_contradicted"] = len(self.contradicted)
            document["n_allowed"] = self.allowed
            document["label_noise"] = self.label_noise
        if self.fewest is not None:
            document["fewest"] = {
                name: value
                for name, value in self.fewest.to_json().items()
                if name in ("status", "min", "max", "n_feasible", "hull")
            }
        return document

    def _optimum(self, values: Parameters | None) -> dict[str, Any] | None:
        if values is None:
            return None
        return {
            "T_min": values[0],
            "T_object": dict(zip(self.names, values[1:], strict=True)),
            "L": sum(values),
        }
