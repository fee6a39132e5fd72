"""Reading a map of logits along paths: bilinear, soft minimum over arc length, exact gradients.

The logit of a path is −T·log ∫ exp(−ℓ(p)/T) ds / s₀ over the path's arc length: the lowest
place decides, places as low as it count along with it, and neither the number of points nor
their spacing changes the answer.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import Paths
from demospec.errors import InputError
from demospec.frames import FloatArray

if TYPE_CHECKING:
    from torch import Tensor

TEMPERATURE = 0.2
"""T, in logits: at a slope of 3 logits a pixel the softness is 0.07 px."""

STRETCH_PX = 2.0
"""s₀: a path that stays this long (times `LogitMap.unit`) at its lowest place has just that
logit."""

_POINT = 0.05  # share of s₀ that a path without length has
_SPACING = 2.5  # times `LogitMap.unit`: longer segments are cut
_BLOCK = 65_536  # places read at a time


@dataclass(frozen=True)
class LogitMap:
    """ℓ(p) over a picture.

    Args:
        values: (h, w) float32; map pixel (i, j) is centred at ((i + ½)·W/w, (j + ½)·H/h).
        size: (W, H), set units. Outside the outer centres the map continues flat.
        unit: Map pixels in the length that counts as one: a seen map is no finer than the picture
            that was enlarged for it.
    """

    values: NDArray[np.float32]
    size: tuple[float, float]
    unit: float = 1.0

    def logits(self, paths: Paths) -> FloatArray:
        """(n,) logits of stacked paths (n, m, 2) or of n arrays (m_i, 2); set units."""
        if len(paths) == 0:
            return np.zeros(0)
        if isinstance(paths, np.ndarray) and paths.ndim == 3:
            return self._in_blocks(_checked(paths))[0]
        return self._ragged([_checked(np.asarray(p)) for p in paths])

    def logits_and_gradients(self, paths: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(n, m, 2) → logits (n,) and ∂logit/∂paths (n, m, 2), per set unit."""
        p = _checked(np.asarray(paths))
        if p.ndim != 3:
            raise InputError("stacked paths (n, m, 2)", str(tuple(p.shape)), field="paths")
        if p.size == 0:
            return np.zeros(len(p)), np.zeros(p.shape)
        return self._in_blocks(p, slopes=True)

    @cached_property
    def _tensor(self) -> Tensor:
        import torch

        values: Tensor = torch.from_numpy(np.ascontiguousarray(self.values))[None, None]
        return values

    def _in_blocks(
        self, paths: NDArray[Any], *, slopes: bool = False
    ) -> tuple[FloatArray, FloatArray]:
        """Logits, and gradients if asked, of (n, m, 2), n, m ≥ 1; blocks bound the memory."""
        import torch

        count, corners = paths.shape[:2]
        rows = max(1, _BLOCK // corners)
        out = np.empty(count)
        gradient = np.empty((count, corners, 2) if slopes else (0, 0, 2))
        # grid_sample's own frame: −1 and 1 are the outer edges of the picture.
        frame = 2.0 / np.array(self.size)
        # One factor for both axes where they agree: a product along the last axis is slow.
        same = frame[0] == frame[1]
        to_frame: Any = float(frame[0]) if same else torch.from_numpy(frame.astype(np.float32))
        for low in range(0, count, rows):
            part = np.ascontiguousarray(paths[low : low + rows], np.float32)
            p = torch.from_numpy(part).mul(to_frame).sub_(1.0).requires_grad_(slopes)
            with torch.set_grad_enabled(slopes):
                level = self._stacked(p)
            out[low : low + rows] = level.detach().numpy()
            if slopes:
                (slope,) = torch.autograd.grad(level.sum(), p)
                np.multiply(slope.numpy(), frame, out=gradient[low : low + rows])
        if not np.isfinite(out).all():
            raise InputError("finite numbers", "NaN or infinity", field="paths")
        return out, gradient

    def _stacked(self, p: Tensor) -> Tensor:
        """(n, m, 2) in grid_sample's frame → (n,)."""
        import torch

        level = self._read(p)
        lowest = level.detach().amin(dim=1)
        if p.shape[1] == 1:
            return level[:, 0] - TEMPERATURE * float(np.log(_POINT))
        lengths = self._lengths(p)
        cut = _Cuts.of(p, lengths.detach())
        between = None if cut is None else self._read(cut.places[None])[0]
        if cut is not None and between is not None:
            lowest = lowest.scatter_reduce(0, cut.path, between.detach(), "amin")
            lengths = lengths / cut.pieces
        share = _weight(lowest[:, None] - level)
        # Trapezium rule: half of each piece's length belongs to either end.
        mass = ((share[:, 1:] + share[:, :-1]) * lengths).sum(dim=1)
        if cut is not None and between is not None:
            more = _weight(lowest[cut.path] - between)
            mass = mass.index_add(0, cut.path, 2.0 * more * lengths[cut.path, cut.segment])
        return lowest - TEMPERATURE * torch.log(_POINT + mass * (0.5 / STRETCH_PX))

    def _lengths(self, p: Tensor) -> Tensor:
        """(n, m, 2) → (n, m − 1) in units."""
        height, width = self.values.shape
        step = p[:, 1:] - p[:, :-1]
        square = step * step
        # A segment without length has no slope; the tiny term keeps its gradient finite.
        flat = square[..., 0] + square[..., 1] * (height / width) ** 2 + 1e-14
        lengths: Tensor = flat.sqrt() * (width / 2.0 / self.unit)
        return lengths

    def _read(self, p: Tensor) -> Tensor:
        """(n, m, 2) → (n, m), bilinear."""
        from torch.nn import functional

        read = functional.grid_sample(
            self._tensor, p[None], mode="bilinear", padding_mode="border", align_corners=False
        )
        along: Tensor = read[0, 0]
        return along

    def _ragged(self, paths: list[NDArray[Any]]) -> FloatArray:
        """Paths of different lengths; equal lengths together."""
        counts = np.array([len(p) for p in paths])
        out = np.empty(len(paths))
        if len(set(counts.tolist())) <= 3:
            for count in set(counts.tolist()):
                rows = np.flatnonzero(counts == count)
                out[rows] = self._in_blocks(np.stack([paths[i] for i in rows]))[0]
            return out
        # A path may be lengthened by repeating its last point: it adds no arc length.
        order = np.argsort(counts)
        for low in range(0, len(order), 64):
            rows = order[low : low + 64]
            longest = counts[rows].max()
            stacked = np.stack(
                [np.concatenate([paths[i], np.repeat(paths[i][-1:], longest - counts[i], 0)])
                 for i in rows]
            )  # fmt: skip
            out[rows] = self._in_blocks(stacked)[0]
        return out


def _weight(above: Tensor) -> Tensor:
    """What a place so far above (≤ 0: below) the lowest one weighs; next to nothing is 0 there.

    The exponential of less is not a normal number, which takes a processor ten times as long.
    """
    import torch

    return torch.exp((above * (1.0 / TEMPERATURE)).clamp(min=-60.0))


@dataclass(frozen=True)
class _Cuts:
    """Places inside segments that are longer than `_SPACING`, evenly spread over each.

    Args:
        pieces: (n, m − 1) into how many every segment is cut.
        path, segment: (k,) where each place belongs.
        places: (k, 2).
    """

    pieces: Tensor
    path: Tensor
    segment: Tensor
    places: Tensor

    @classmethod
    def of(cls, p: Tensor, lengths: Tensor) -> _Cuts | None:
        """Those of paths (n, m, 2); None where no segment is long."""
        import torch

        # Few paths have long segments: only those are searched.
        rows = torch.nonzero(lengths.amax(dim=1) > _SPACING)[:, 0]
        if len(rows) == 0:
            return None
        path, segment = torch.nonzero(lengths[rows] > _SPACING, as_tuple=True)
        path = rows[path]
        number = torch.ceil(lengths[path, segment] / _SPACING).nan_to_num(1.0).clamp(1, 512).long()
        pieces = torch.ones_like(lengths)
        pieces[path, segment] = number.to(pieces.dtype)
        of = torch.repeat_interleave(torch.arange(len(path)), number - 1)
        first = torch.cumsum(number - 1, 0) - (number - 1)
        t = (torch.arange(len(of)) - first[of] + 1) / number[of]
        path, segment = path[of], segment[of]
        start, end = p[path, segment], p[path, segment + 1]
        return cls(pieces, path, segment, start + (end - start) * t[:, None])


def _checked(paths: NDArray[Any]) -> NDArray[Any]:
    array = paths[..., :2]
    if array.ndim < 2 or array.shape[-1] != 2 or (array.size and array.shape[-2] < 1):
        raise InputError("paths of [x, y] points", f"shape {paths.shape}", field="paths")
    return array
