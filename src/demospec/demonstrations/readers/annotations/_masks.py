"""Masks as annotation tools store them: run lengths of four kinds, and pictures in base64."""

from __future__ import annotations

import base64
import io
import warnings
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations.readers.annotations._shapes import MAX_PIXELS
from demospec.errors import InputError, MissingExtraError

Mask = NDArray[np.bool_]

_LARGEST_FILE = 1 << 28


def coco_mask(segmentation: dict[str, Any]) -> Mask:
    """COCO's run lengths, compressed (text) or not (a list), by pycocotools: (h, w).

    Raises:
        InputError: Run lengths that do not cover the picture.
        MissingExtraError: pycocotools is not installed.
    """
    size, counts = segmentation.get("size"), segmentation.get("counts")
    if not (
        isinstance(size, list)
        and len(size) == 2
        and all(isinstance(v, int) and v > 0 for v in size)
        and size[0] * size[1] <= MAX_PIXELS
    ):
        raise InputError("a size [height, width]", size, field="segmentation.size")
    try:
        from pycocotools import mask as coco
    except ImportError as error:
        raise MissingExtraError("pycocotools", "objects", "run-length masks") from error
    height, width = size
    if isinstance(counts, list):
        whole = all(isinstance(c, int) and 0 <= c <= height * width for c in counts)
        if not whole or sum(counts) != height * width:
            found = f"{sum(counts)}" if whole else "something else"
            expected = f"run lengths that add up to {height * width}"
            raise InputError(expected, found, field="segmentation.counts")
        encoded = coco.frPyObjects({"size": size, "counts": counts}, height, width)
    elif isinstance(counts, str) and counts.isascii() and _covers(counts, height * width):
        encoded = {"size": size, "counts": counts.encode("ascii")}
    else:
        raise InputError(f"run lengths of {height * width} pixels", str(counts)[:20] or "nothing",
                         field="segmentation.counts")  # fmt: skip
    try:
        with warnings.catch_warnings():
            # Its arrays speak to NumPy as those of version 1 did.
            warnings.filterwarnings("ignore", "__array__ implementation", DeprecationWarning)
            found_mask = np.asarray(coco.decode(encoded))
    except (ValueError, TypeError) as error:
        raise InputError("run lengths of COCO", str(error), field="segmentation.counts") from error
    return np.asarray(found_mask.reshape(height, width) > 0)


def _covers(text: str, pixels: int) -> bool:
    """Whether compressed run lengths add up to the picture; the decoder itself does not look."""
    lengths: list[int] = []
    value = shift = 0
    for byte in text.encode("ascii"):
        code = byte - 48
        if not 0 <= code < 64 or shift > 60:
            return False
        value |= (code & 31) << shift
        shift += 5
        if not code & 32:
            if code & 16:
                value -= 1 << shift
            lengths.append(value + (lengths[-2] if len(lengths) > 2 else 0))
            value = shift = 0
    return not shift and all(n >= 0 for n in lengths) and sum(lengths) == pixels


def cvat_mask(runs: str, width: int, height: int) -> Mask:
    """CVAT's run lengths of a box, background first, row by row: (h, w)."""
    try:
        lengths = [int(n) for n in runs.split(",")]
    except ValueError:
        lengths = [-1]
    if width < 1 or height < 1 or width * height > MAX_PIXELS:
        raise InputError("a box of the mask", f"{width}x{height}", field="mask")
    if min(lengths) < 0 or sum(lengths) != width * height:
        raise InputError(f"run lengths that add up to {width * height}", runs[:40], field="rle")
    values = np.arange(len(lengths)) % 2 == 1
    return np.repeat(values, lengths).reshape(height, width)


def brush_mask(runs: list[Any], width: int, height: int) -> Mask:
    """Label Studio's brush: (h, w), where its RGBA picture is not transparent.

    The run lengths are those of "rle-pack" (thi.ng/umbrella): 32 bits for the number of values,
    5 for the bits of a value less one, four times 4 for the sizes of a length less one; then a
    bit that says whether one value is repeated, two for the size of the length, the length less
    one, and the value or the values.

    Raises:
        InputError: Bytes that stop early, or another number of values than 4 a pixel.
    """
    if width < 1 or height < 1 or width * height > MAX_PIXELS:
        raise InputError(f"a picture of at most {MAX_PIXELS} pixels", f"{width}x{height}",
                         field="original_width")  # fmt: skip
    if not all(isinstance(b, int) and 0 <= b < 256 for b in runs):
        raise InputError("bytes from 0 to 255", "something else", field="rle")
    bits = np.unpackbits(np.array(runs, dtype=np.uint8)).astype(np.uint8)
    at = 0

    def read(count: int) -> int:
        nonlocal at
        piece = bits[at : at + count]
        if len(piece) < count:
            raise InputError("a whole run-length mask", f"{len(runs)} bytes", field="rle")
        at += count
        return int("".join(map(str, piece)), 2) if count else 0

    total, word = read(32), read(5) + 1
    sizes = [read(4) + 1 for _ in range(4)]
    if total != 4 * width * height or word > 8:
        raise InputError(f"{4 * width * height} values of a byte", f"{total} of {word} bits",
                         field="rle")  # fmt: skip
    values = np.empty(total, dtype=np.uint8)
    done = 0
    while done < total:
        repeated = read(1)
        length = read(sizes[read(2)]) + 1
        if done + length > total:
            raise InputError(f"{total} values", f"at least {done + length}", field="rle")
        if repeated:
            values[done : done + length] = read(word)
        else:
            piece = bits[at : at + length * word]
            if len(piece) < length * word:
                raise InputError("a whole run-length mask", f"{len(runs)} bytes", field="rle")
            at += length * word
            weights = 1 << np.arange(word)[::-1]
            values[done : done + length] = piece.reshape(length, word) @ weights
        done += length
    return np.asarray(values.reshape(height, width, 4)[:, :, 3] > 0)


def picture_mask(text: object, file: Path, *, packed: bool = False) -> Mask:
    """A picture in base64 (perhaps as ``data:`` address; `packed`: deflated too) as a mask.

    Where it has an alpha channel, what is not transparent; else what is not black.
    """
    import PIL.Image

    if not isinstance(text, str):
        raise InputError("a picture in base64", type(text).__name__, field="mask")
    try:
        data = base64.b64decode(text.partition("base64,")[2] or text, validate=True)
        if packed:
            unpack = zlib.decompressobj()
            data = unpack.decompress(data, _LARGEST_FILE)
            if unpack.unconsumed_tail:
                raise InputError(f"a mask of at most {_LARGEST_FILE} bytes", "more", field="mask")
    except (ValueError, zlib.error) as error:
        raise InputError("a picture in base64", str(error), field="mask") from error
    try:
        picture = PIL.Image.open(io.BytesIO(data), formats=("PNG",))
        if picture.width * picture.height > MAX_PIXELS:
            found = f"{picture.width}x{picture.height}"
            raise InputError(f"a mask of at most {MAX_PIXELS} pixels", found, field="mask")
        alpha = "A" in picture.getbands() or "transparency" in picture.info
        if alpha:
            pixels = np.asarray(picture.convert("RGBA").getchannel("A"))
        else:  # of a palette the number of the colour counts
            pixels = np.asarray(picture if picture.mode == "P" else picture.convert("L"))
    except InputError:
        raise
    except Exception as error:  # Pillow's decoders raise nearly anything on broken data
        raise InputError("a PNG picture in base64", str(error), file=file, field="mask") from error
    return np.asarray(pixels > 0)
