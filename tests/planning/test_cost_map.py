"""Cost maps: arrays agree with callables, masks are exact, units are those of the set."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from demospec.errors import InputError
from demospec.planning import CostMap, Zone, cost_map
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Disc, Picture, Polygon, Scene, SceneObject

ZONES = (
    Zone("g", "glass", Disc((30.0, 40.0), 8.0), 5.0),
    Zone("b", "bowl", Polygon([[60, 60], [80, 62], [70, 70], [75, 90]]), 3.0),
)


@settings(deadline=None, max_examples=40)
@given(
    st.floats(0.37, 4),
    st.floats(0, 3),
    st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(1, 150), st.floats(1, 150)),
)
def test_quick_mask_equals_the_margin_at_every_cell(
    cell: float, inflate: float, box: tuple[float, float, float, float]
) -> None:
    x, y, width, height = box
    grid = CostMap(ZONES, (x, y, x + width, y + height), cell)
    margin = grid.signed_distance
    assert margin.shape == grid.shape
    sure = np.abs(margin - inflate) > 1e-9
    assert (grid.within(inflate) == (margin < inflate))[sure].all()


@settings(deadline=None, max_examples=60)
@given(st.floats(0, 100), st.floats(0, 100))
def test_cost_is_what_the_docstring_says(x: float, y: float) -> None:
    grid = CostMap(ZONES, (0, 0, 100, 100), weight=0.5)
    depth = sum(max(0.0, z.radius - float(z.shape.signed_distance([x, y]))) for z in ZONES)
    assert float(grid.cost([x, y])) == pytest.approx(1 + 0.5 * depth)
    assert (float(grid.margin([x, y])) < 0) == (depth > 0)


def test_deeper_costs_more_in_physical_and_less_in_paper() -> None:
    at = np.array([[30.0, 52.9], [30.0, 50.0], [30.0, 48.5]])
    physical = CostMap(ZONES, (0, 0, 100, 100)).cost(at)
    paper = CostMap(ZONES, (0, 0, 100, 100), preset="paper").cost(at)
    assert (np.diff(physical) > 0).all()
    assert (np.diff(paper) < 0).all()


def test_rows_run_down_and_columns_run_right() -> None:
    grid = CostMap(ZONES, (0, 0, 100, 50), 1.0)
    assert grid.shape == (50, 100)
    assert grid.centers()[0, 0].tolist() == [0.5, 0.5]
    assert grid.centers()[49, 99].tolist() == [99.5, 49.5]
    assert grid.cell_of([99.9, 0.0]) == (0, 99)
    assert grid.array[40, 30] == grid.cost([30.5, 40.5])


def test_integral_along_a_line_is_exact_for_linear_price() -> None:
    grid = CostMap((Zone("g", "glass", Disc((0.0, 0.0), 0.0), 10.0),), (-20, -20, 20, 20))
    # From the rim straight to the centre the price rises from 1 to 11.
    assert grid.path_cost([[10.0, 0.0], [0.0, 0.0]]) == pytest.approx(60.0, rel=1e-3)


def test_resolution_and_faults() -> None:
    picture = Picture(array=np.zeros((60, 80, 3), dtype=np.uint8))
    item = SceneObject("g", "glass", (40.0, 30.0), None, Disc((40.0, 30.0), 5.0))
    scene = Scene("s", (5.0, 5.0), (75.0, 55.0), (item,), picture)
    rules = RuleSet({"t": TypeRules(ClearanceRule({"glass": 4.0}))}, metres_per_unit=0.004)
    assert cost_map(rules, scene).shape == (75, 100)
    assert cost_map(rules, scene, resolution=1.0).shape == (60, 80)
    assert cost_map(rules, scene, resolution=2.0).shape == (120, 160)
    assert cost_map(rules, scene).metres_per_unit == 0.004
    with pytest.raises(InputError, match="resolution"):
        cost_map(rules, scene, resolution=float("nan"))
    with pytest.raises(InputError, match="preset: expected one of physical, paper, count"):
        cost_map(rules, scene, preset="steep")  # type: ignore[arg-type]
