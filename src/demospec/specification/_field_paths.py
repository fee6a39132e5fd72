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
_SPACING = 2.5  # map pixels: longer segments are cut
_BLOCK = 65_536  # places read at a time


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
        """Logits, and gradients if asked, of (n, m, 2), n, m ≥ 1.

        Blocks of paths stay in the processor's cache; in each, paths whose segments must be cut
        into equally many pieces go together.
        """
        import torch

        count, corners = paths.shape[:2]
        rows = max(1, _BLOCK // corners)
        out = np.empty(count)
        gradient = np.empty((count, corners, 2) if slopes else (0, 0, 2))
        frame = np.array(self.size)[:, None, None] / 2.0
        for low in range(0, count, rows):
            part = paths[low : low + rows]
            # grid_sample's own frame: −1 and 1 are the outer edges of the picture. x and y apart.
            plane = np.empty((2, len(part), corners), np.float32)
            for axis in (0, 1):
                np.multiply(part[..., axis], 1.0 / frame[axis, 0, 0], out=plane[axis])
            plane -= np.float32(1.0)
            lengths = self._lengths(torch.from_numpy(plane))
            pieces = _pieces(lengths)
            for number in np.unique(pieces):
                chosen = np.flatnonzero(pieces == number)
                every = len(chosen) == len(part)
                p = torch.from_numpy(plane if every else plane[:, chosen])
                p.requires_grad_(slopes)
                with torch.set_grad_enabled(slopes):
                    known = None if slopes else lengths if every else lengths[chosen]
                    level = self._stacked(p, int(number), known)
                out[low + chosen] = level.detach().numpy()
                if slopes:
                    (slope,) = torch.autograd.grad(level.sum(), p)
                    gradient[low + chosen] = (slope.numpy() / frame).transpose(1, 2, 0)
        if not np.isfinite(out).all():
            raise InputError("finite numbers", "NaN or infinity", field="paths")
        return out, gradient

    def _lengths(self, p: Tensor) -> Tensor:
        """(2, n, m) → (n, m − 1) map pixels."""
        height, width = self.values.shape
        dx = (p[0, :, 1:] - p[0, :, :-1]) * (width / 2.0)
        dy = (p[1, :, 1:] - p[1, :, :-1]) * (height / 2.0)
        # A segment without length has no slope; the tiny term keeps its gradient finite.
        lengths: Tensor = (dx.square() + dy.square() + 1e-12).sqrt()
        return lengths

    def _stacked(self, p: Tensor, pieces: int, lengths: Tensor | None) -> Tensor:
        """(2, n, m) → (n,), every segment cut into `pieces`; `lengths` of the whole segments."""
        import torch

        if p.shape[2] == 1:
            return self._read(p)[:, 0] - TEMPERATURE * float(np.log(_POINT))
        if pieces > 1:
            t = (torch.arange(pieces, dtype=p.dtype) / pieces)[None, None, None]
            cut = p[:, :, :-1, None] * (1 - t) + p[:, :, 1:, None] * t
            p = torch.cat([cut.flatten(2, 3), p[:, :, -1:]], dim=2)
            lengths = None
        if lengths is None:
            lengths = self._lengths(p)
        level = self._read(p)
        lowest = level.detach().amin(dim=1, keepdim=True)
        share = torch.exp((lowest - level) * (1.0 / TEMPERATURE))
        # Trapezium rule: half of each segment's length belongs to either end.
        mass = (share[:, 1:] + share[:, :-1]) * lengths
        total = _POINT + mass.sum(dim=1) * (0.5 / STRETCH_PX)
        return lowest[:, 0] - TEMPERATURE * torch.log(total)

    def _read(self, p: Tensor) -> Tensor:
        """(2, n, m) → (n, m), bilinear."""
        from torch.nn import functional

        read = functional.grid_sample(
            self._tensor, p.permute(1, 2, 0)[None], mode="bilinear", padding_mode="border",
            align_corners=False,
        )  # fmt: skip
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


def _pieces(lengths: Tensor) -> NDArray[np.int64]:
    """(n, m − 1) → (n,) into how many a path's segments are cut, by its longest."""
    if lengths.shape[1] == 0:
        return np.ones(len(lengths), np.int64)
    needed = np.ceil(np.nan_to_num(lengths.amax(dim=1).numpy()) / _SPACING)
    return np.asarray(np.clip(needed, 1, 512), np.int64)


def _checked(paths: NDArray[Any]) -> NDArray[Any]:
    array = paths[..., :2]
    if array.ndim < 2 or array.shape[-1] != 2 or (array.size and array.shape[-2] < 1):
        raise InputError("paths of [x, y] points", f"shape {paths.shape}", field="paths")
    return array
