"""The source's unit and frame → the set's: homography, metres with a picture, or as it came."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from demospec.demonstrations._trajectory import (
    MAX_COORDINATE,
    Demonstration,
)
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._projection import Projection
from demospec.demonstrations.readers._recording import RawScene, Recording
from demospec.errors import InputError
from demospec.frames import FloatArray, PixelFrame
from demospec.scene import Picture

_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}


@dataclass(frozen=True)
class Converter:
    """The source's unit and frame → the set's."""

    units: str
    scale: float
    flip: PixelFrame | None
    projection: Projection | None
    given_metres: float | None
    source_metres: float | None
    solid: bool
    notes: list[str]

    @classmethod
    def of(
        cls,
        units: str,
        mapping: Mapping,
        projection: Projection | None,
        raw: dict[str, RawScene],
        solid: bool,
        notes: list[str],
    ) -> Converter:
        metres = _METRES.get(units)
        if projection is not None and not solid and abs(projection.basis[2, 2]) < 1:
            raise InputError("a column for z (the plane is not x, y)", "none", field="columns")
        with_picture = any(s.load is not None for s in raw.values())
        if projection is not None and projection.to_pixels:
            if projection.residual_px is not None:
                notes.append(f"projection: fitted, residual {projection.residual_px:.2f} px")
            return cls("px", 1.0, None, projection, mapping.metres_per_unit, metres, solid, notes)
        if metres is None:
            return cls("px", 1.0, None, projection, mapping.metres_per_unit, None, solid, notes)
        if not with_picture:
            notes.append(f"units: {units} kept as metres, y as it came")
            return cls("m", metres, None, projection, 1.0, metres, solid, notes)
        if mapping.metres_per_unit is None:
            raise InputError(
                "a way from the source's unit to picture pixels: projection.pairs, "
                "projection.homography, or metres_per_unit (or --picture none)",
                f"points in {units} and a picture",
                field="projection",
            )
        notes.append("units: metres to pixels, the picture's bottom left corner at (0, 0)")
        frame = PixelFrame(0.0, mapping.metres_per_unit)
        return cls("px", metres, frame, projection, mapping.metres_per_unit, metres, solid, notes)

    def convert(
        self, recording: Recording, points: FloatArray, picture: Picture | None
    ) -> FloatArray:
        """(n, d) → (n, d) in the set's frame; z becomes the height over the plane."""
        out = points.copy()
        # Only spatial columns change; further ones (tilt, speed) are kept as they came.
        spatial = 3 if self.solid else 2
        if self.projection is not None:
            try:
                moved = self.projection.apply(points[:, :spatial])
            except InputError as error:
                raise error.at(file=recording.file, row=recording.name) from error
            out[:, :spatial] = moved[:, :spatial]
        out[:, :spatial] *= self.scale
        if self.flip is not None:
            height = picture.size_px[1] if picture is not None else 0.0
            frame = PixelFrame(height, self.flip.metres_per_unit)
            out[:, :spatial] = frame.to_pixels(out[:, :spatial])
        wrong = ~(np.abs(out) <= MAX_COORDINATE)
        if wrong.any():
            i = int(np.argwhere(wrong)[0][0])
            raise recording.complain("points that project to the picture", f"point {i} far away",
                                     "projection")  # fmt: skip
        return out

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
