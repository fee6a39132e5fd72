"""Pictures that lie inside a recording are turned as those in files of their own are."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from PIL import Image

from demospec.demonstrations.readers._video import decoded
from demospec.scene import Picture


def test_a_camera_s_note_of_which_way_is_up_counts_in_bytes_too(tmp_path: Path) -> None:
    pixels = np.random.default_rng(0).integers(0, 255, (16, 24, 3), dtype=np.uint8)
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.fromarray(pixels).save(tmp_path / "a.png", exif=exif)
    read = decoded(io.BytesIO((tmp_path / "a.png").read_bytes()), tmp_path / "a.png", "row 0")
    np.testing.assert_array_equal(read, Picture(file=tmp_path / "a.png").pixels)
    np.testing.assert_array_equal(read, np.rot90(pixels, -1))
