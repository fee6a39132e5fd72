"""The pixel frame and the table frame are inverse maps; lengths are said with units."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demospec.errors import InputError
from demospec.frames import PixelFrame, describe_length

numbers = st.floats(-1e4, 1e4)


@given(numbers, numbers, st.floats(1, 1e4), st.floats(1e-4, 10))
def test_round_trip(x: float, y: float, height: float, scale: float) -> None:
    frame = PixelFrame(height, scale)
    assert np.allclose(frame.to_pixels(frame.to_metres([[x, y]])), [[x, y]], atol=1e-6)


def test_up_in_the_picture_is_away_on_the_table() -> None:
    frame = PixelFrame(100, 0.01)
    assert np.allclose(frame.to_metres([0, 100]), [0, 0])
    assert np.allclose(frame.to_metres([100, 0]), [1, 1])


def test_distances_scale() -> None:
    frame = PixelFrame(100, 0.004)
    a, b = frame.to_metres([[3, 4], [6, 8]])
    assert np.linalg.norm(a - b) == pytest.approx(frame.length_to_metres(5))


def test_unknown_scale_is_said() -> None:
    with pytest.raises(InputError, match="metres_per_unit"):
        PixelFrame(100, None).to_metres([1, 2])


def test_lengths_for_people() -> None:
    assert describe_length(37, 0.004) == "15 cm"
    assert describe_length(0.0405, None, "m", interval=(0.0377, 0.0436)) == "4.0 cm (3.8 to 4.4)"
    assert describe_length(2.94, None, interval=(2.93, 2.99)) == "2.94 px (2.93 to 2.99)"
    assert describe_length(8, 0.0005, interval=(6, float("inf"))) == "4.0 mm (3.0 or more)"
    assert describe_length(37.25, None) == "37 px"


def test_what_rounds_up_to_a_longer_number_has_no_digit_too_many() -> None:
    assert describe_length(0.065, 1.0, "m", interval=(0.026, 0.0996)) == "6.5 cm (2.6 to 10)"
    assert describe_length(0.0999, 1.0, "m") == "10 cm"
    assert describe_length(0.00996, 1.0, "m") == "1 cm"
