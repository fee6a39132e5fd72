"""One frame of a video, one picture from bytes."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

import numpy as np

from demospec.errors import InputError, MissingExtraError
from demospec.scene import Image, upright

MAX_PIXELS = 64_000_000


def frame_at(file: Path, seconds: float) -> Image:
    """The frame shown at `seconds`, (h, w, 3) uint8.

    Raises:
        MissingExtraError: PyAV is not installed.
        InputError: No such file, no video, or it ends before.
    """
    if not file.is_file():
        raise InputError("a video", "no such file", file=file)
    try:
        import av
    except ImportError as error:
        raise MissingExtraError("av", "video", "a frame of a video") from error
    last = None
    try:
        with av.open(str(file)) as container:
            stream = container.streams.video[0]
            rate = float(stream.average_rate or 30)
            base = float(stream.time_base or 1 / 90_000)
            container.seek(max(0, int((seconds - 0.5) / base)), stream=stream)
            for frame in container.decode(stream):
                if frame.width * frame.height > MAX_PIXELS:
                    raise InputError(f"frames of at most {MAX_PIXELS} pixels",
                                     f"{frame.width}x{frame.height}", file=file)  # fmt: skip
                last = frame
                # Frame times are rounded to the stream's clock: half a frame of slack.
                if frame.time is not None and frame.time >= seconds - 0.5 / rate:
                    return np.asarray(frame.to_ndarray(format="rgb24"))
    except (OSError, ValueError, IndexError, EOFError, MemoryError) as error:
        raise InputError("a video", str(error), file=file) from error
    if last is None:
        raise InputError("a video with frames", "none", file=file)
    raise InputError(f"a video that lasts {seconds:.2f} s", f"{last.time} s", file=file)


def decoded(data: io.BytesIO, file: Path, row: str) -> Image:
    """A PNG or JPEG picture from bytes, as viewers show it, (h, w, 3) uint8."""
    import PIL.Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PIL.Image.DecompressionBombWarning)
            picture = PIL.Image.open(data, formats=("PNG", "JPEG", "WEBP", "BMP"))
        if picture.width * picture.height > MAX_PIXELS:
            raise InputError(f"a picture of at most {MAX_PIXELS} pixels",
                             f"{picture.width}x{picture.height}", file=file, row=row)  # fmt: skip
        return np.asarray(upright(picture).convert("RGB"))
    except InputError:
        raise
    except Exception as error:  # Pillow's decoders raise nearly anything on broken data
        raise InputError("a PNG or JPEG picture", str(error), file=file, row=row) from error
