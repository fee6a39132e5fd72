"""Truncated picture files, found without decoding them.

A truncated picture has a good header. Who reads a set of ten thousand pictures does not decode
them, and must name the broken one all the same: a look at the file's end tells.
"""

from __future__ import annotations

import os
from typing import BinaryIO

_PNG_END = b"IEND\xaeB`\x82"
_JPEG_END, _JPEG_SCAN = b"\xff\xd9", b"\xff\xda"


def is_truncated(file: str | os.PathLike[str], kind: str) -> bool:
    """Whether a PNG or JPEG stops before its end mark; False for other formats.

    Bytes after the end mark, which some cameras and programs write, are no fault.

    Raises:
        OSError: The file cannot be read.
    """
    if kind == "PNG":
        with open(file, "rb") as stream:
            stream.seek(-min(len(_PNG_END), os.path.getsize(file)), os.SEEK_END)
            return stream.read() != _PNG_END and not _png_chunks_end(stream)
    if kind in ("JPEG", "MPO"):
        with open(file, "rb") as stream:
            stream.seek(-min(len(_JPEG_END), os.path.getsize(file)), os.SEEK_END)
            if stream.read() == _JPEG_END:
                return False
            stream.seek(0)
            data = stream.read()
        # A thumbnail in the header has an end mark too, but before the picture's own scan.
        return data.rfind(_JPEG_END) < data.rfind(_JPEG_SCAN)
    return False


def _png_chunks_end(stream: BinaryIO) -> bool:
    """Whether going from chunk to chunk reaches IEND."""
    stream.seek(8)
    while len(head := stream.read(8)) == 8:
        if head[4:] == b"IEND":
            return True
        stream.seek(int.from_bytes(head[:4], "big") + 4, os.SEEK_CUR)
    return False
