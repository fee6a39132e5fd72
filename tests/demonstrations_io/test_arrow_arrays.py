"""Arrow arrays read from their memory: what Arrow's own, slower functions say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from demospec.demonstrations._table import given, to_numpy

ARRAYS = {
    "truth values": pa.array([True, None, False, True, None, *[True, False] * 20], pa.bool_()),
    "numbers": pa.array([0.5, None, -1.0, 7.25, None, *range(40)], pa.float64()),
    "lists": pa.array([[1.0], None, [], [2.0, 3.0], None, *[[4.0]] * 40], pa.list_(pa.float64())),
    "no nulls": pa.array(range(45), pa.int32()),
    "nulls alone": pa.nulls(45, pa.bool_()),
}


@pytest.mark.parametrize("array", ARRAYS.values(), ids=ARRAYS)
@pytest.mark.parametrize(("first", "length"), [(0, 45), (1, 44), (7, 3), (8, 20), (13, 0), (45, 0)])
def test_nulls_and_values_of_slices(array: Any, first: int, length: int) -> None:
    part = array.slice(first, length)
    known = given(part)
    assert known.tolist() == part.is_valid().to_pylist()
    if pa.types.is_list(part.type):
        return
    values = to_numpy(part)
    assert values.dtype == np.dtype(part.type.to_pandas_dtype())
    assert values[known].tolist() == part.drop_null().to_pylist()
