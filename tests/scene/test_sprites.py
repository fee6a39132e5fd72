"""What is drawn is what is listed: sprites, outlines, and the half-pixel convention."""

from __future__ import annotations

import numpy as np
import pytest

from demospec.scene import (
    SAMPLES,
    Light,
    Mesh,
    Stamp,
    bar,
    coverage,
    draw_sprite,
    joined,
    lathe,
    load_catalogue,
    outline,
    slab,
)
from demospec.scene.rendering import mesh, snap_center
from demospec.scene.rendering.catalogues import ANGLE_STEPS


def box(x0: float, y0: float, x1: float, y1: float, top: float = 0.02) -> Mesh:
    corners = [[x0, y0, top], [x1, y0, top], [x1, y1, top], [x0, y1, top]]
    return mesh(corners, [[0, 1, 2], [0, 2, 3]], [0.5, 0.5, 0.5])


def test_a_rectangle_covers_exactly_its_pixels() -> None:
    # 1 px = 0.01 m; the rectangle covers x in [-2, 3] px, and y up [-1, 4] is y down [-4, 1].
    sprite = draw_sprite(box(-0.02, -0.01, 0.03, 0.04), 100.0)
    cover = 1.0 - sprite.through[..., 0]
    half_x, half_y = sprite.half_px
    h, w = cover.shape
    pixels = cover.reshape(h // SAMPLES, SAMPLES, w // SAMPLES, SAMPLES).mean(axis=(1, 3))
    expected = np.zeros_like(pixels)
    expected[half_y - 4 : half_y + 1, half_x - 2 : half_x + 3] = 1.0
    np.testing.assert_allclose(pixels, expected, atol=1e-6)


def test_partly_covered_pixels_get_their_share() -> None:
    area = 0.0373 * 0.0511
    sprite = draw_sprite(box(-0.01, -0.02, 0.0273, 0.0311), 100.0)
    share = float((1.0 - sprite.through[..., 0]).sum()) / SAMPLES**2
    assert share == pytest.approx(area * 100.0**2, rel=0.03)


def test_the_upper_surface_hides_the_lower() -> None:
    low = mesh([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], [[0, 1, 2]], [1.0, 0.0, 0.0])
    high = mesh([[-1, -1, 1], [1, -1, 1], [0, 1, 1]], [[0, 1, 2]], [0.0, 0.0, 1.0])
    for parts in ([low, high], [high, low]):
        sprite = draw_sprite(joined(parts), 10.0)
        middle = tuple(n // 2 for n in sprite.height.shape)
        assert sprite.albedo[middle].tolist() == [0.0, 0.0, 1.0]
        assert sprite.height[middle] == pytest.approx(1.0)


def test_glass_lets_the_table_through_and_hides_more_in_two_layers() -> None:
    def pane(z: float) -> Mesh:
        corners = [[-1, -1, z], [1, -1, z], [1, 1, z], [-1, 1, z]]
        return mesh(corners, [[0, 1, 2], [0, 2, 3]], [0.8, 0.9, 0.9], opacity=0.3)

    one, two = draw_sprite(pane(0.1), 10.0), draw_sprite(joined([pane(0.1), pane(0.2)]), 10.0)
    at = tuple(n // 2 for n in one.height.shape)
    assert 0.5 < one.through[at][0] < 0.95
    np.testing.assert_allclose(two.through[at], one.through[at] ** 2, rtol=1e-5)


def test_normals_face_the_viewer_and_slopes_lean_outwards() -> None:
    cone = lathe([(0.0, 0.1), (0.1, 0.0)], [0.5] * 3)
    sprite = draw_sprite(cone, 300.0)
    h, w = sprite.height.shape
    assert (sprite.normal[..., 2] > 0).all()
    row = h // 2
    assert sprite.normal[row, w // 4, 0] < -0.3 < 0.3 < sprite.normal[row, 3 * w // 4, 0]
    assert sprite.normal[h // 4, w // 2, 1] < -0.3  # picture y points down


def test_coverage_by_runs_equals_a_point_in_triangle_test() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        v = np.column_stack([rng.uniform(-0.1, 0.1, (9, 2)), np.zeros(9)])
        shape = mesh(v, [[0, 1, 2], [3, 4, 5], [6, 7, 8]], [0.5] * 3)
        mask, half = coverage(shape, 170.0)
        j, i = np.mgrid[0 : mask.shape[0], 0 : mask.shape[1]]
        x, y = (i + 0.5 - half[0]) / 170.0, -(j + 0.5 - half[1]) / 170.0
        expected = np.zeros_like(mask)
        for a, b, c in v[:, :2].reshape(3, 3, 2):
            sides = [
                (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
                for p, q in ((a, b), (b, c), (c, a))
            ]
            expected |= np.all([s >= 0 for s in sides], axis=0)
            expected |= np.all([s <= 0 for s in sides], axis=0)
        assert (mask != expected).sum() == 0


def test_the_outline_of_a_union_and_of_a_ring() -> None:
    cross = joined([box(-0.05, -0.01, 0.05, 0.01), box(-0.01, -0.05, 0.01, 0.05)])
    found = outline(cross)
    x, y = found.T
    area = 0.5 * abs(float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))
    assert area == pytest.approx(0.0036, rel=0.01)
    assert len(found) < 40
    phi = np.linspace(0, 2 * np.pi + 0.3, 60)  # overlaps itself: no seam
    ring = bar(np.column_stack([0.05 * np.cos(phi), 0.05 * np.sin(phi)]), 0.004, [0.5] * 3)
    radius = np.linalg.norm(outline(ring), axis=1)
    assert radius.min() > 0.0535  # the hole counts as inside


def test_a_slab_is_as_large_as_its_outline() -> None:
    square = np.array([[-0.03, -0.02], [0.03, -0.02], [0.03, 0.02], [-0.03, 0.02]])
    x, y = np.abs(outline(slab(square, 0.03, [0.5] * 3))).max(axis=0)
    assert (x, y) == (pytest.approx(0.03, abs=3e-4), pytest.approx(0.02, abs=3e-4))


def test_every_listed_polygon_agrees_with_the_drawn_mask_to_half_a_pixel() -> None:
    rng = np.random.default_rng(4)
    metres_per_px = 0.82 / 100
    for item in load_catalogue("builtin").items:
        center = snap_center(rng.uniform(40, 60, 2))
        angle = float(rng.uniform(0, 2 * np.pi))
        stamp = Stamp.of(item, center, angle, Light(), metres_per_px)
        polygon = item.footprint(center, angle, metres_per_px)
        sprite = item.sprite(angle, 1 / metres_per_px)
        first = np.round(np.asarray(center) * SAMPLES).astype(int)
        first -= np.asarray(sprite.half_px) * SAMPLES
        j, i = np.nonzero(sprite.cover)
        drawn = (np.column_stack([i, j]) + 0.5 + first) / SAMPLES
        # nothing drawn lies half a pixel outside
        assert polygon.signed_distance(drawn).max() < 0.5, item.name
        # and no corner of the polygon is further than half a pixel from something drawn
        nearest = np.sqrt(((polygon.vertices[:, None] - drawn[None]) ** 2).sum(axis=2)).min(axis=1)
        assert nearest.max() < 0.5, item.name
        # the window of the stamp holds the whole polygon
        x0, y0, x1, y1 = stamp.window
        assert x0 <= polygon.bounds[0], item.name
        assert y0 <= polygon.bounds[1], item.name
        assert x1 >= polygon.bounds[2], item.name
        assert y1 >= polygon.bounds[3], item.name


def test_sprites_are_kept_and_angles_wrap() -> None:
    item = load_catalogue("builtin").item("bowl-train-00")
    step = 2 * np.pi / ANGLE_STEPS
    assert item.sprite(3 * step, 120.0) is item.sprite(3 * step + 2 * np.pi + 0.3 * step, 120.0)
    assert item.sprite(3 * step, 120.0) is not item.sprite(4 * step, 120.0)
