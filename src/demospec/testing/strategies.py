"""Hypothesis strategies: footprints, scenes, paths, demonstration sets, rule problems."""

from __future__ import annotations

import numpy as np

try:
    from hypothesis import strategies as st
except ImportError as error:
    from demospec.errors import MissingExtraError

    raise MissingExtraError("hypothesis", "testing", "demospec.testing.strategies") from error

from demospec.demonstrations import DemonstrationSet
from demospec.frames import FloatArray
from demospec.geometry import Capsule, Disc, Footprint, Polygon
from demospec.rules import RuleProblem
from demospec.scene import Scene
from demospec.testing._problems import random_problem
from demospec.testing._scenes import SYMBOLS, random_paths, random_scene
from demospec.testing._sets import demonstrator_set

_SEEDS = st.integers(0, 2**32 - 1)

scales = st.sampled_from([1.0, 0.01, 0.0082, 1000.0])
"""Units of a set, per percent of the table's size: pixels, metres, millimetres."""


@st.composite
def footprints(draw: st.DrawFn) -> Footprint:
    """Discs, capsules and star-shaped polygons in a plane of 100 × 100."""
    at = st.floats(5, 95)
    size = st.floats(0.1, 20)
    kind = draw(st.sampled_from(["disc", "capsule", "polygon"]))
    if kind == "disc":
        return Disc((draw(at), draw(at)), draw(size))
    if kind == "capsule":
        return Capsule((draw(at), draw(at)), (draw(at), draw(at)), draw(size))
    radii = np.array(draw(st.lists(st.floats(1, 20), min_size=3, max_size=9)))
    turn = np.linspace(0, 2 * np.pi, len(radii), endpoint=False)
    center = np.array([draw(at), draw(at)])
    return Polygon(center + radii[:, None] * np.column_stack([np.cos(turn), np.sin(turn)]))


@st.composite
def scenes(draw: st.DrawFn, symbols: tuple[str, ...] = SYMBOLS) -> Scene:
    """As `random_scene`, in any unit."""
    rng = np.random.default_rng(draw(_SEEDS))
    return random_scene(rng, symbols=symbols, scale=draw(scales))


@st.composite
def paths(draw: st.DrawFn, most: int = 8) -> FloatArray:
    """(n, m, 2): 1 to `most` curves as of `random_paths`, of 2 to 80 points."""
    rng = np.random.default_rng(draw(_SEEDS))
    return random_paths(rng, draw(st.integers(1, most)), draw(st.integers(2, 80)))


@st.composite
def demonstration_sets(draw: st.DrawFn) -> DemonstrationSet:
    """As `demonstrator_set`: one to three types with rules of up to all symbols, in any unit."""
    rules = {
        name: draw(st.dictionaries(st.sampled_from(SYMBOLS), st.floats(0.5, 12)))
        for name in ("careful", "normal", "third")[: draw(st.integers(1, 3))]
    }
    rng = np.random.default_rng(draw(_SEEDS))
    scale = draw(scales)
    return demonstrator_set(
        rng, rules, draw(st.integers(1, 4)), draw(st.integers(1, 8)), scale=scale,
        metres_per_unit=0.0082 / scale,
    )  # fmt: skip


@st.composite
def rule_problems(draw: st.DrawFn) -> RuleProblem:
    """As `random_problem`: small enough for brute force."""
    return random_problem(draw(st.integers(0, 10**9)))
