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
"""s₀: a path that stays this long (map pixels) at its lowest place has just that logit."""

_POINT = 0.05  # share of s₀ that a path without length has
_SPACING = 1.0  # map pixels between places that are read
_NEGLIGIBLE = 10.0  # places this many T above the lowest count e⁻¹⁰ times as much


@dataclass(frozen=True)
class LogitMap:
    """ℓ(p) over a picture.

    Args:
        values: (h, w) float32; map pixel (i, j) is centred at ((i + ½)·W/w, (j + ½)·H/h).
        size: (W, H), set units. Outside the outer centres the map continues flat.
    """

    values: NDArray[np.float32]
    size: tuple[float, float]

    def logits(self, paths: Paths) -> FloatArray:
        """(n,) logits of stacked paths (n, m, 2) or of n arrays (m_i, 2); set units."""
        import torch

        with torch.no_grad():
            if isinstance(paths, np.ndarray) and paths.ndim == 3:
                out = self._stacked(torch.from_numpy(_checked(paths)), self._tensor())
            else:
                if len(paths) == 0:
                    return np.zeros(0)
                out = self._ragged([_checked(np.asarray(p)) for p in paths])
            return np.asarray(out.numpy(), dtype=np.float64)

    def logits_and_gradients(self, paths: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(n, m, 2) → logits (n,) and ∂logit/∂paths (n, m, 2), per set unit."""
        import torch

        p = torch.from_numpy(_checked(np.asarray(paths))).requires_grad_(True)
        if p.ndim != 3:
            raise InputError("stacked paths (n, m, 2)", str(tuple(p.shape)), field="paths")
        if p.numel() == 0:
            return np.zeros(len(p)), np.zeros(p.shape)
        out = self._stacked(p, self._tensor())
        (slope,) = torch.autograd.grad(out.sum(), p)
        gradient = np.asarray(slope.numpy(), dtype=np.float64)
        return np.asarray(out.detach().numpy(), dtype=np.float64), gradient

    def _tensor(self) -> Tensor:
        import torch

        return torch.from_numpy(self.values)[None, None]

    @property
    def _pixel(self) -> tuple[float, float]:
        height, width = self.values.shape
        return self.size[0] / width, self.size[1] / height

    def _stacked(self, p: Tensor, values: Tensor) -> Tensor:
        """(n, m, 2) → (n,). Reads every corner, then cuts only the segments that can matter."""
        import torch

        count, corners = p.shape[:2]
        if count == 0:
            return p.new_zeros(0)
        coarse = self._read(p.flatten(0, 1), values).view(count, corners)
        lowest = coarse.detach().amin(dim=1)
        if corners == 1:
            return coarse[:, 0] - TEMPERATURE * float(np.log(_POINT))
        width, height = self._pixel
        dx = (p[:, 1:, 0] - p[:, :-1, 0]) * (1.0 / width)
        dy = (p[:, 1:, 1] - p[:, :-1, 1]) * (1.0 / height)
        # A segment without length has no slope; the tiny term keeps its gradient finite.
        length = torch.sqrt(dx * dx + dy * dy + 1e-12)
        known = coarse.detach()
        bound = torch.minimum(known[:, 1:], known[:, :-1]) - self._steepest * 0.5 * length.detach()
        row, segment = (bound < (lowest + _NEGLIGIBLE * TEMPERATURE)[:, None]).nonzero().unbind(1)
        long = length[row, segment]
        pieces = min(512, max(1, int(np.ceil(float(long.detach().max()) / _SPACING))))
        t = ((torch.arange(pieces, dtype=p.dtype) + 0.5) / pieces)[None, :, None]
        first, last = p[row, segment], p[row, segment + 1]
        between = first[:, None] * (1 - t) + last[:, None] * t
        level = self._read(between.flatten(0, 1), values).view(len(row), pieces)
        # The lowest place may lie between corners.
        least = lowest.scatter_reduce(0, row, level.detach().amin(dim=1), "amin")
        share = torch.exp((least[row, None] - level) * (1.0 / TEMPERATURE)).mean(dim=1)
        total = _POINT * torch.exp((least - coarse.amin(dim=1)) * (1.0 / TEMPERATURE))
        total = total.index_add(0, row, share * long * (1.0 / STRETCH_PX))
        return least - TEMPERATURE * torch.log(total)

    def _read(self, points: Tensor, values: Tensor) -> Tensor:
        """(k, 2) set units → (k,)."""
        from torch.nn import functional

        # grid_sample's own frame: −1 and 1 are the outer edges of the picture.
        place = points * points.new_tensor([2.0 / self.size[0], 2.0 / self.size[1]]) - 1.0
        read = functional.grid_sample(
            values, place[None, None], mode="bilinear", padding_mode="border", align_corners=False
        )
        return read[0, 0, 0]

    @cached_property
    def _steepest(self) -> float:
        """Largest slope of the map, logits a map pixel."""
        v = self.values
        down, across = (float(np.abs(np.diff(v, axis=axis)).max(initial=0.0)) for axis in (0, 1))
        return float(np.hypot(down, across))

    def _ragged(self, paths: list[NDArray[np.float32]]) -> Tensor:
        """Paths of different lengths, each cut to the same spacing; equal lengths together."""
        import torch

        values = self._tensor()
        counts = np.array([len(p) for p in paths])
        out = torch.empty(len(paths))
        if len(set(counts.tolist())) <= 3:
            for count in set(counts.tolist()):
                rows = np.flatnonzero(counts == count)
                stacked = np.stack([paths[i] for i in rows])
                out[torch.from_numpy(rows)] = self._stacked(torch.from_numpy(stacked), values)
            return out
        # A path may be lengthened by repeating its last point: it adds no arc length, and the
        # share of a point is spread over the repeats.
        order = np.argsort(counts)
        for low in range(0, len(order), 64):
            rows = order[low : low + 64]
            longest = counts[rows].max()
            stacked = np.stack(
                [np.concatenate([paths[i], np.repeat(paths[i][-1:], longest - counts[i], 0)])
                 for i in rows]
            )  # fmt: skip
            out[torch.from_numpy(rows)] = self._stacked(torch.from_numpy(stacked), values)
        return out


def _checked(paths: NDArray[Any]) -> NDArray[np.float32]:
    array = np.ascontiguousarray(paths[..., :2], dtype=np.float32)
    if array.ndim < 2 or array.shape[-1] != 2 or (array.size and array.shape[-2] < 1):
        raise InputError("paths of [x, y] points", f"shape {paths.shape}", field="paths")
    if not np.isfinite(array).all():
        raise InputError("finite numbers", "NaN or infinity", field="paths")
    return array
