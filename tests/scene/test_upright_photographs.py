"""A photograph is read the way up that its camera noted, as every viewer shows it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageOps

from demospec.scene import Picture


def photograph(path: Path, orientation: int | None, note: bytes | None = None) -> None:
    """24 × 16 pixels, four corners of four colours, and the camera's note."""
    pixels = np.zeros((16, 24, 3), dtype=np.uint8)
    pixels[:8, :12], pixels[:8, 12:] = (250, 0, 0), (0, 250, 0)
    pixels[8:, :12], pixels[8:, 12:] = (0, 0, 250), (250, 250, 0)
    exif = Image.Exif()
    if orientation is not None:
        exif[0x0112] = orientation
    Image.fromarray(pixels).save(path, exif=exif if note is None else note)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("name", ["a.jpg", "a.png", "a.webp", "a.tif"])
def test_pixels_and_size_are_those_that_a_viewer_shows(
    tmp_path: Path, name: str, orientation: int
) -> None:
    file = tmp_path / name
    photograph(file, orientation)
    with Image.open(file) as stored:
        shown = np.asarray(ImageOps.exif_transpose(stored).convert("RGB"))
    assert Picture(file=file).size_px == (shown.shape[1], shown.shape[0])
    np.testing.assert_array_equal(Picture(file=file).pixels, shown)
    if orientation in (5, 6, 7, 8):
        assert shown.shape == (24, 16, 3)


@pytest.mark.parametrize("orientation", [0, 9, 4096])
def test_a_note_that_names_no_way_is_ignored(tmp_path: Path, orientation: int) -> None:
    photograph(tmp_path / "a.jpg", orientation)
    photograph(tmp_path / "b.jpg", None)
    assert Picture(file=tmp_path / "a.jpg") == Picture(file=tmp_path / "b.jpg")


@pytest.mark.parametrize(
    "note", [b"Exif\0\0", b"Exif\0\0MM\0*\0\0\0\x08\0\x09", b"Exif\0\0nonsense"]
)
def test_a_damaged_note_does_not_cost_the_picture(tmp_path: Path, note: bytes) -> None:
    photograph(tmp_path / "a.jpg", None, note)
    assert Picture(file=tmp_path / "a.jpg").size_px == (24, 16)
    assert Picture(file=tmp_path / "a.jpg").pixels.shape == (16, 24, 3)
