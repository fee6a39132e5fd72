"""The source's unit and frame → the set's: homography, metres with a picture, or as it came."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from demospec.demonstrations._trajectory import (
    MAX_COORDINATE,
    Demonstration,
)
from demospec.demonstrations.readers._columns import QUATERNION, Columns
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._projection import Projection
from demospec.demonstrations.readers._recording import RawScene, Recording
from demospec.errors import InputError
from demospec.frames import METRES, FloatArray, PixelFrame
from demospec.scene import Picture


@dataclass(frozen=True)
class SourceUnit:
    """The unit of the points of a source.

    Args:
        unit: ``px``, ``m``, ``cm`` or ``mm``.
        how: From what it is known, in words.
        factors: Of each recording, what its positions are multiplied by to be in `unit`;
            by our name of the column.
    """

    unit: str
    how: str
    factors: list[dict[str, float]]


def source_unit(
    recordings: list[Recording], columns: list[Columns], mapping: Mapping, default: str
) -> SourceUnit:
    """The unit that the columns state, that the user said, or that the format fixes.

    Raises:
        InputError: A unit that is not read, columns of which only some state one, pixels beside
            metres, or a stated unit that is not the one that the user said.
    """
    stated: set[str] = set()
    silent = 0
    for recording, chosen in zip(recordings, columns, strict=True):
        for axis in ("x", "y", "z"):
            if axis not in chosen.places:
                continue
            unit = chosen.units.get(axis)
            silent += unit is None
            if unit is not None and unit != "px" and unit not in METRES:
                column = recording.columns[chosen.places[axis]]
                raise recording.complain("a length in px, m, cm or mm", unit, column)
            stated |= {unit} if unit is not None else set()
    if stated and silent:
        raise InputError(
            "a unit for every column of the position, or for none",
            f"{', '.join(sorted(stated))} for some", field="units",
        )  # fmt: skip
    none = [dict[str, float]() for _ in recordings]
    if not stated:
        how = "as asked" if mapping.units else "the format's" if default != "px" else "not stated"
        return SourceUnit(mapping.units or default, how, none)
    if mapping.units is not None and stated != {mapping.units}:
        expected = f"the unit that the columns state ({', '.join(sorted(stated))})"
        raise InputError(expected, mapping.units, field="units")
    if len(stated) == 1:
        return SourceUnit(stated.pop(), "as the columns state", none)
    if "px" in stated or (mapping.projection is not None and _is_picture_map(mapping)):
        raise InputError("one unit of length", ", ".join(sorted(stated)), field="units")
    factors = [
        {axis: METRES[unit] for axis, unit in c.units.items() if axis in ("x", "y", "z")}
        for c in columns
    ]
    return SourceUnit("m", f"as the columns state ({', '.join(sorted(stated))})", factors)


def _is_picture_map(mapping: Mapping) -> bool:
    p = mapping.projection
    return p is not None and (p.homography is not None or p.pairs is not None)


def in_source_unit(
    points: FloatArray, chosen: Columns, factors: dict[str, float], unit: str, recording: Recording
) -> FloatArray:
    """Positions in one unit, tilt in degrees, speed in that unit a second."""
    out = points.copy()
    for k, name in enumerate(chosen.places):
        stated = chosen.units.get(name)
        if name in factors:
            out[:, k] *= factors[name]
        elif name == "tilt" and stated == "rad":
            out[:, k] = np.rad2deg(out[:, k])
        elif name == "tilt" and stated not in (None, "deg"):
            raise recording.complain("a tilt in deg or rad", stated, name)
        elif name == "speed" and stated is not None:
            length, _, time = stated.partition("/")
            if time != "s" or (length != unit and not {length, unit} <= set(METRES)):
                raise recording.complain(f"a speed in {unit}/s", stated, name)
            out[:, k] *= METRES.get(length, 1.0) / METRES.get(unit, 1.0)
    return out


@dataclass(frozen=True)
class Converter:
    """The source's unit and frame → the set's.

    Args:
        units: Unit of the set.
        scale: What lengths are multiplied by, before anything else but the projection.
        flip: Metres → pixels of the picture, y turned, or None.
        projection: Source → plane → perhaps pixels, or None.
        given_metres: Metres in a unit of the set where that is known beforehand.
        source_metres: Metres in a unit of the source, or None.
        names: Our names of the columns.
        notes: Filled with what was decided.
    """

    units: str
    scale: float
    flip: PixelFrame | None
    projection: Projection | None
    given_metres: float | None
    source_metres: float | None
    names: tuple[str, ...]
    notes: list[str]

    @classmethod
    def of(
        cls,
        unit: SourceUnit,
        mapping: Mapping,
        projection: Projection | None,
        raw: dict[str, RawScene],
        names: tuple[str, ...],
        notes: list[str],
    ) -> Converter:
        units = unit.unit
        metres = METRES.get(units)
        solid = "z" in names
        if projection is not None and not solid and abs(projection.basis[2, 2]) < 1:
            raise InputError("a column for z (the plane is not x, y)", "none", field="columns")
        with_picture = any(s.load is not None for s in raw.values())
        if projection is not None and projection.to_pixels:
            if projection.residual_px is not None:
                notes.append(f"projection: fitted, residual {projection.residual_px:.2f} px")
            return cls("px", 1.0, None, projection, mapping.metres_per_unit, metres, names, notes)
        if metres is None:
            notes.append(f"units: px ({unit.how})")
            return cls("px", 1.0, None, projection, mapping.metres_per_unit, None, names, notes)
        if not with_picture:
            notes.append(f"units: {units} ({unit.how}) kept as metres, y as it came")
            return cls("m", metres, None, projection, 1.0, metres, names, notes)
        if mapping.metres_per_unit is None:
            raise InputError(
                "a way from the source's unit to picture pixels: projection.pairs, "
                "projection.homography, or metres_per_unit (or --picture none)",
                f"points in {units} and a picture",
                field="projection",
            )
        notes.append("units: metres to pixels, the picture's bottom left corner at (0, 0)")
        frame = PixelFrame(0.0, mapping.metres_per_unit)
        return cls("px", metres, frame, projection, mapping.metres_per_unit, metres, names, notes)

    @property
    def solid(self) -> bool:
        """Whether points have a height."""
        return "z" in self.names

    @property
    def flat(self) -> bool:
        """Whether the plane is that of the source's x and y, perhaps turned in itself."""
        return self.projection is None or abs(self.projection.basis[2, 2]) > 1 - 1e-12

    def similarity(self, picture: Picture | None) -> tuple[FloatArray, FloatArray] | None:
        """The map of the source's x and y as a matrix (2, 2) and an offset; None where it is none
        (a homography, another plane)."""
        if not self.flat or (self.projection is not None and self.projection.to_pixels):
            return None
        ends = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        offset, right, ahead = self.place(ends, picture)[:, :2]
        return np.stack([right - offset, ahead - offset], axis=1), offset

    def convert(
        self, recording: Recording, points: FloatArray, picture: Picture | None
    ) -> FloatArray:
        """(n, d) → (n, d) in the set's frame; z becomes the height over the plane."""
        out = points.copy()
        # Only spatial columns, speed and orientation change; others are kept as they came.
        spatial = 3 if self.solid else 2
        try:
            out[:, :spatial] = self.place(points[:, :spatial], picture)
        except InputError as error:
            raise error.at(file=recording.file, row=recording.name) from error
        if "speed" in self.names:
            out[:, self.names.index("speed")] *= self.length(1.0)
        if self.projection is not None and set(QUATERNION) <= set(self.names):
            k = self.names.index("qx")
            out[:, k : k + 4] = self.projection.turned(out[:, k : k + 4])
        wrong = ~(np.abs(out) <= MAX_COORDINATE)
        if wrong.any():
            i = int(np.argwhere(wrong)[0][0])
            raise recording.complain("points that project to the picture", f"point {i} far away",
                                     "projection")  # fmt: skip
        return out

    def place(self, points: FloatArray, picture: Picture | None) -> FloatArray:
        """(n, 2) or (n, 3) positions of the source → the set's frame."""
        out = points.copy()
        if self.projection is not None:
            out = self.projection.apply(points)[:, : points.shape[1]]
        out = out * self.scale
        if self.flip is not None:
            height = picture.size_px[1] if picture is not None else 0.0
            out = PixelFrame(height, self.flip.metres_per_unit).to_pixels(out)
        return np.asarray(out)

    def length(self, length: float) -> float:
        """A length of the source in the set's unit (where no homography scales it by place)."""
        if self.flip is not None and self.flip.metres_per_unit is not None:
            return length * self.scale / self.flip.metres_per_unit
        return length * self.scale

    def metres_per_unit(self, items: list[Demonstration]) -> float | None:
        """Given, or measured where the homography maps the paths."""
        if self.given_metres is not None or self.projection is None:
            return self.given_metres
        if not self.projection.to_pixels or self.source_metres is None:
            return None
        pixels = np.concatenate([i.points[:: max(1, len(i.points) // 20), :2] for i in items])
        length, spread = self.projection.unit_length(pixels)
        note = f"scale: {length * self.source_metres:.4g} m per pixel"
        if spread > 1.02:
            note += f" (perspective: it varies by a factor of {spread:.2f} over the paths)"
        self.notes.append(note)
        return length * self.source_metres

    def heights_in_pixels(
        self, items: list[Demonstration], metres: float | None
    ) -> list[Demonstration]:
        """After a homography the height is still in the source's unit: into pixels, if it can."""
        if self.projection is None or not self.projection.to_pixels or not self.solid:
            return items
        if metres is None or self.source_metres is None:
            self.notes.append("z: height over the plane, in the source's unit")
            return items
        self.notes.append("z: height over the plane, pixels")
        scale = np.ones(items[0].points.shape[1])
        scale[2] = self.source_metres / metres
        return [replace(item, points=item.points * scale) for item in items]
