"""nav2: a graded map, a keep-out mask and a speed mask, as `map_server` reads them.

Source of the semantics: nav2_map_server `map_io.cpp` (modes, row order), nav2_costmap_2d
`filter_values.hpp` (filter types, 0 = no speed limit).

- ``map.pgm`` (mode scale): 0 free, 1…99 in the clearance, the deeper the higher, 100 in the
  object itself; 1 in a cell that a zone only touches, so that it is free nowhere where
  ``keepout.pgm`` blocks.
- ``keepout.pgm`` (mode scale): 100 in every cell that a zone touches, else 0. A cell is blocked
  as soon as any part of it is: a path between free cells keeps the rule.
- ``speed.pgm`` (mode raw): percent of the full speed within one clearance of a zone, from 30 at
  its rim to 100, and no more than a rule's speed limit where a cell is within its radius; 0, which
  nav2 reads as "no limit", elsewhere.

The first image row has the greatest y; `origin` is the lower-left corner of the last.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from demospec.frames import FloatArray
from demospec.planning.exports._request import ExportRequest

SLOWEST_PERCENT = 30

_OCCUPIED, _FREE = 0.998, 0.002
"""Thresholds near 1 and 0: in mode scale every value 0…100 is read back as it was written, and
readers that know only occupied and free (strictly beyond a threshold) still get those two."""


def write_nav2(request: ExportRequest, folder: Path) -> None:
    """Writes the three maps and ``filters.yaml`` (parameters of the two filter servers)."""
    graded = occupancy(request)
    keepout = np.where(touched(request), 100, 0)
    # Scale mode: brightness 1 − v/100.
    _write(request, folder, "map", np.rint(255 * (1 - graded / 100)), "scale")
    _write(request, folder, "keepout", np.rint(255 * (1 - keepout / 100)), "scale")
    _write(request, folder, "speed", speed_percent(request), "raw")
    (folder / "filters.yaml").write_text(_FILTERS, encoding="utf-8")


def occupancy(request: ExportRequest) -> NDArray[np.int8]:
    """(rows, columns) 0…100; row 0 has the least y of the set."""
    where = request.cost_map
    centers = where.centers()
    share = np.zeros(where.shape)
    for zone in where.zones:
        gap = zone.shape.signed_distance(centers)
        reach = max(zone.reach, 1e-9)
        # Within the clearance 1…99, in the object 100.
        within = np.clip(np.ceil(99 * (1 - gap / reach)), 1, 99)
        share = np.maximum(share, np.where(gap <= 0, 100, np.where(gap < reach, within, 0)))
    # What the keep-out mask blocks is not free here either.
    return np.where(touched(request), np.maximum(share, 1), share).astype(np.int8)


def touched(request: ExportRequest) -> NDArray[np.bool_]:
    """(rows, columns): cells of which any part may lie in a zone."""
    return request.cost_map.within(request.cost_map.cell * np.sqrt(0.5))


def speed_percent(request: ExportRequest) -> NDArray[np.int8]:
    """(rows, columns): percent of the full speed, 0 for no limit."""
    where = request.cost_map
    centers = where.centers()
    percent = np.full(where.shape, 101.0)
    for zone in where.zones:
        beyond = zone.shape.signed_distance(centers) - zone.radius
        band = max(zone.radius, where.cell)
        limit = SLOWEST_PERCENT + (100 - SLOWEST_PERCENT) * np.clip(beyond / band, 0.0, 1.0)
        percent = np.minimum(percent, np.where(beyond < band, limit, 101.0))
    percent = np.minimum(np.rint(percent), _limited(request))
    return np.where(percent > 100, 0, percent).astype(np.int8)


def _limited(request: ExportRequest) -> FloatArray:
    """(rows, columns): percent of the full speed that the rule's speed limits leave, rounded down
    (1 at least, as 0 is no limit); 101 where there is none."""
    where = request.cost_map
    percent = np.full(where.shape, 101.0)
    limits = () if request.asked is None else request.asked.speeds
    half = where.cell * np.sqrt(0.5)
    for limit in limits:
        share = 100 * limit.value * request.scale_m / request.speed_m_s
        if share >= 100:
            continue
        near = np.ones(where.shape, dtype=bool)
        if limit.radius is not None:
            gaps = [shape.signed_distance(where.centers()) for shape in limit.shapes]
            near = np.min(gaps, axis=0) <= limit.radius + half
        percent[near] = np.minimum(percent[near], max(1.0, np.floor(share)))
    return percent


def _write(
    request: ExportRequest, folder: Path, name: str, pixels: NDArray[np.generic], mode: str
) -> None:
    import PIL.Image

    shown = np.ascontiguousarray(request.rows_upwards(np.asarray(pixels).astype(np.uint8))[::-1])
    PIL.Image.fromarray(shown, mode="L").save(folder / f"{name}.pgm")
    cell_m = request.cost_map.cell * request.scale_m
    x, y = request.corner
    (folder / f"{name}.yaml").write_text(
        f"image: {name}.pgm\n"
        f"mode: {mode}\n"
        f"resolution: {cell_m!r}\n"
        f"origin: [{_plain(x)!r}, {_plain(y)!r}, 0.0]\n"
        "negate: 0\n"
        f"occupied_thresh: {_OCCUPIED}\n"
        f"free_thresh: {_FREE}\n",
        encoding="utf-8",
    )


def _plain(value: float) -> float:
    """Without the last bits of rounding, and no −0."""
    return round(float(value), 12) + 0.0


_FILTERS = """\
keepout_filter_info_server:
  ros__parameters:
    type: 0
    filter_info_topic: keepout_filter_info
    mask_topic: keepout_mask
    base: 0.0
    multiplier: 1.0
speed_filter_info_server:
  ros__parameters:
    type: 1
    filter_info_topic: speed_filter_info
    mask_topic: speed_mask
    base: 0.0
    multiplier: 1.0
"""
