"""What demonstrations without error say about clearances: logic, no probabilities.

A rule is a set S of classes and a clearance c_k ≥ floor for every k in S; a path with nearest
approaches d_k is acceptable iff d_k ≥ c_k for all k in S. Accepted demonstrations bound every
c_k from above by u_k = min d_k. A rejected one needs a class k in S with d_k < c_k, and the
largest c_k there is, u_k, explains most: so S is consistent iff every rejected demonstration
has a k in S with d_k < u_k. Consistent sets are the hitting sets of a bipartite graph.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class ClearanceSpace:
    """All clearance rules that agree with every demonstration.

    Args:
        upper: (K,) largest clearance that every accepted demonstration keeps; +inf where none
            comes near the class. Below `floor` the class cannot matter.
        explains: (R, K) whether class k, at its largest clearance, explains rejection r.
        near: (R, K) nearest approaches of the rejected demonstrations.
        floor: Smallest clearance a class that matters may have.
    """

    upper: FloatArray
    explains: BoolArray
    near: FloatArray
    floor: float

    @classmethod
    def of(cls, nearest: FloatArray, valid: BoolArray, floor: float = 0.0) -> ClearanceSpace:
        """From nearest approaches (n, K) and labels (n,)."""
        accepted, rejected = nearest[valid], nearest[~valid]
        upper = accepted.min(axis=0, initial=np.inf)
        explains = (rejected < upper) & (upper >= floor)
        return cls(upper, explains, rejected, floor)

    @property
    def consistent(self) -> bool:
        """Whether any rule at all agrees with every demonstration."""
        return bool(self.explains.any(axis=1).all())

    def allows(self, subset: Sequence[int]) -> bool:
        """Whether some clearances for exactly these classes agree with every demonstration."""
        chosen = list(subset)
        if any(self.upper[k] < self.floor for k in chosen):
            return False
        return bool(self.explains[:, chosen].any(axis=1).all())

    def interval(self, subset: Sequence[int], k: int) -> tuple[float, float]:
        """[lower, upper] end of c_k over all consistent clearances of these classes.

        The lower end comes from the rejections that nothing else in the subset explains (c_k
        must exceed it; `floor` where there is none), the upper end from accepted
        demonstrations.
        """
        others = [j for j in subset if j != k]
        alone = ~self.explains[:, others].any(axis=1)
        low = float(self.near[alone, k].max(initial=self.floor))
        return low, float(self.upper[k])

    def required(self) -> BoolArray:
        """(K,) classes in every consistent subset."""
        single = self.explains.sum(axis=1) == 1
        return np.asarray(self.explains[single].any(axis=0))

    def fewest_classes_bound(self) -> int:
        """No consistent rule needs fewer classes: rejections that share no explanation."""
        rows = self.explains[np.argsort(self.explains.sum(axis=1), kind="stable")]
        used = np.zeros(rows.shape[1], dtype=bool)
        count = 0
        for row in rows:
            if row.any() and not (row & used).any():
                used |= row
                count += 1
        return count
