"""The size of a plain PNG from its first 41 bytes, without an imaging library.

Most pictures of a set are written by this program, and commands that read object lists never
decode one: for them, loading Pillow would take longer than all their work.
"""

from __future__ import annotations

import os
import struct
import zlib

_BEGIN = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR"
_RGB8, _RGBA8 = b"\x08\x02\x00\x00\x00", b"\x08\x06\x00\x00\x00"
"""Depth, colours, and the only known ways to pack, filter and not interlace."""


def plain_png_size(file: str | os.PathLike[str]) -> tuple[int, int] | None:
    """(width, height) of an 8-bit RGB or RGBA picture with pixels right after its header.

    Returns:
        None for everything else, such as a PNG with notes (EXIF may turn it) or a broken one.

    Raises:
        OSError: The file cannot be read.
    """
    with open(file, "rb") as stream:
        head = stream.read(41)
    if len(head) < 41 or not head.startswith(_BEGIN) or head[37:] != b"IDAT":
        return None
    width, height, checksum = struct.unpack(">II5xI", head[16:33])
    plain = head[24:29] in (_RGB8, _RGBA8) and zlib.crc32(head[12:29]) == checksum
    return (width, height) if plain and min(width, height) > 0 else None
