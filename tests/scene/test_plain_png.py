"""The size of a picture read without an imaging library is the size that the library reads."""

from __future__ import annotations

import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import PIL.Image
import pytest
from PIL.PngImagePlugin import PngInfo

from demospec.errors import InputError
from demospec.scene import Picture
from demospec.scene._plain_png import plain_png_size

NOISE = np.random.default_rng(0).integers(0, 255, (20, 30, 3), dtype=np.uint8)


@pytest.mark.parametrize("mode", ["RGB", "RGBA"])
def test_a_plain_picture_needs_no_library(tmp_path: Path, mode: str) -> None:
    file = tmp_path / "a.png"
    PIL.Image.fromarray(NOISE).convert(mode).save(file)
    assert plain_png_size(file) == (30, 20)
    code = (
        "import sys; from pathlib import Path; from demospec.scene import Picture; "
        f"print(Picture(file=Path({str(file)!r})).size_px, 'PIL.Image' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "(30, 20) False"


@pytest.mark.parametrize("mode", ["L", "P", "1", "I;16"])
def test_other_pictures_are_left_to_the_library(tmp_path: Path, mode: str) -> None:
    file = tmp_path / "a.png"
    picture = PIL.Image.fromarray(NOISE)
    (PIL.Image.new(mode, (30, 20)) if mode == "I;16" else picture.convert(mode)).save(file)
    assert plain_png_size(file) is None
    assert Picture(file=file).size_px == (30, 20)


def test_notes_that_may_turn_it_are_left_to_the_library(tmp_path: Path) -> None:
    turned, noted = PIL.Image.Exif(), PngInfo()
    turned[0x0112] = 6
    noted.add_text("who", "a camera")
    PIL.Image.fromarray(NOISE).save(tmp_path / "a.png", exif=turned)
    PIL.Image.fromarray(NOISE).save(tmp_path / "b.png", pnginfo=noted)
    assert plain_png_size(tmp_path / "a.png") is plain_png_size(tmp_path / "b.png") is None
    assert Picture(file=tmp_path / "a.png").size_px == (20, 30)
    assert Picture(file=tmp_path / "b.png").size_px == (30, 20)


def test_a_broken_header_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "a.png"
    PIL.Image.fromarray(NOISE).save(file)
    whole = file.read_bytes()
    wrong_sum = whole[:19] + b"\x1f" + whole[20:]
    empty = whole[:16] + bytes(4) + whole[20:29]
    no_width = empty + zlib.crc32(empty[12:]).to_bytes(4, "big") + whole[33:]
    bomb = whole[:16] + b"\0\1\0\0\0\1\0\0" + whole[24:29]
    bomb += zlib.crc32(bomb[12:]).to_bytes(4, "big") + whole[33:]
    for content in (b"", whole[:30], wrong_sum, no_width, bomb, whole[:-5]):
        file.write_bytes(content)
        with pytest.raises(InputError):
            _ = Picture(file=file).size_px
