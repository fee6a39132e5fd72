"""A picture that somebody brings becomes a scene: decoded, checked, and encoded anew."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Sequence

import numpy as np

from demospec.errors import InputError
from demospec.scene import Picture, Scene

FORMATS = ("PNG", "JPEG", "WEBP")
MAX_SIDE_PX = 2000
"""Larger pictures are scaled down: the table is seen at screen size."""

MAX_PIXELS = 40_000_000
"""A picture that says it has more is refused before it is decoded."""

MIN_SIDE_PX = 16


def scene_from_picture(
    data: bytes,
    name: str,
    taken: Sequence[str],
    *,
    start: Sequence[float] | None = None,
    goal: Sequence[float] | None = None,
) -> Scene:
    """A scene with this picture, its objects not listed.

    Args:
        data: A PNG, JPEG or WebP file. The scene keeps its pixels only, so that nothing else
            that the file holds (places, programs) is kept or served.
        name: Wish for the id; other characters than letters, digits, - and _ are dropped.
        taken: Ids that are not free.
        start, goal: Pixels of the picture as it was sent; by default left and right.

    Raises:
        InputError: Not such a picture, broken, or too large.
    """
    import PIL.Image
    import PIL.ImageOps

    if not data:
        raise InputError("a picture", "nothing", field="picture")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", PIL.Image.DecompressionBombWarning)
            with PIL.Image.open(io.BytesIO(data), formats=FORMATS) as opened:
                width, height = opened.size
                if width * height > MAX_PIXELS or min(width, height) < MIN_SIDE_PX:
                    expected = f"a picture of at least {MIN_SIDE_PX} px a side and at most "
                    raise InputError(
                        expected + f"{MAX_PIXELS:,} pixels", f"{width}x{height}", field="picture"
                    )
                opened.thumbnail((MAX_SIDE_PX, MAX_SIDE_PX))
                image = PIL.ImageOps.exif_transpose(opened).convert("RGB")
    except InputError:
        raise
    except PIL.UnidentifiedImageError as error:
        raise InputError("a PNG, JPEG or WebP picture", "another file", field="picture") from error
    except Exception as error:  # whatever a decoder raises on a broken file
        raise InputError("a PNG, JPEG or WebP picture", str(error), field="picture") from error
    shrunk = max(image.size) / max(width, height)
    wide, high = image.size
    ends = []
    for field, given, usual in (("start", start, (0.06, 0.5)), ("goal", goal, (0.94, 0.5))):
        if given is None:
            ends.append((usual[0] * wide, usual[1] * high))
            continue
        x, y = (float(v) * shrunk for v in given)
        if not (0 <= x <= wide and 0 <= y <= high):
            raise InputError("a place in the picture", list(given), field=field)
        ends.append((x, y))
    return Scene(
        free_name(name, taken), ends[0], ends[1], None, Picture(array=np.asarray(image)), "train"
    )


def free_name(wish: str, taken: Sequence[str]) -> str:
    """A safe id near the wish that is not taken."""
    stem = re.sub(r"[^A-Za-z0-9_-]+", "-", wish)[:40].strip("-") or "picture"
    name, number = stem, 2
    while name in taken:
        name, number = f"{stem}-{number}", number + 1
    return name
