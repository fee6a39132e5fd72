"""Rendered pretraining pictures: distances against a dense raster, answers that fit, the judge."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import binary_fill_holes, distance_transform_edt, label

from demospec.perception import KINDS, load_network, observe
from demospec.perception.synthetic import NoiseBank, kind_shares, make_solid, render_picture
from demospec.perception.training import label_of, paint
from demospec.scene import Polygon, coverage, outline

FINE = 16


@pytest.fixture(scope="module")
def bank() -> NoiseBank:
    return NoiseBank.make(np.random.default_rng(0), count=12, size=64)


@pytest.mark.parametrize("kind", range(len(KINDS)))
def test_outline_of_a_solid_is_that_of_its_dense_raster(kind: int) -> None:
    """Oracle: the projection rastered sixteen times finer, holes filled, Euclidean transform."""
    checked = 0
    for seed in range(6):
        solid = make_solid(np.random.default_rng([kind, seed]), kind, np.full(3, 0.5))
        mask, half = coverage(solid.mesh, FINE)
        mask = np.pad(binary_fill_holes(mask), 5 * FINE)
        if label(mask, np.ones((3, 3)))[1] > 1:
            continue  # pictures leave such solids out
        exact = (distance_transform_edt(~mask) - distance_transform_edt(mask)) / FINE
        rows, columns = np.mgrid[0 : mask.shape[0] : 7, 0 : mask.shape[1] : 7]
        x = (columns + 0.5) / FINE - 5 - half[0] / FINE
        y = (rows + 0.5) / FINE - 5 - half[1] / FINE
        rim = outline(solid.mesh, 700)
        rim[:, 1] *= -1
        found = Polygon(rim).signed_distance(np.stack([x, y], axis=-1))
        gap = np.abs(found - exact[rows, columns])
        assert np.quantile(gap, 0.99) < 0.2, (kind, seed)
        checked += 1
    assert checked >= 3


def test_answers_agree_with_one_another(bank: NoiseBank) -> None:
    for seed in range(4):
        picture, planes = render_picture(np.random.default_rng(seed), bank, 160, kind_shares())
        distance, kind, thing = planes[0], planes[5], planes[6]
        assert picture.shape == (160, 160, 3)
        assert picture.dtype == np.uint8
        assert np.isfinite(planes).all()
        assert ((thing >= 0) == (distance < 0)).all()
        assert ((kind >= 0) == (thing >= 0)).all()
        slope = np.abs(np.diff(distance, axis=0))
        assert (slope < 1.001).mean() > 0.999  # a distance changes by one pixel a pixel at most


def test_a_thing_is_drawn_where_its_distance_says(bank: NoiseBank) -> None:
    """Without the thing the picture is the table: what differs inside is it, outside its shadow."""
    inside, outside = [], []
    for seed in range(12):
        picture, planes = render_picture(np.random.default_rng(seed), bank, 160, kind_shares())
        grey = picture.astype(float).mean(axis=2)
        steep = np.hypot(*np.gradient(grey))
        rim, table = np.abs(planes[0]) < 0.8, planes[0] > 12
        if rim.any() and table.any():
            inside.append(steep[rim].mean())
            outside.append(steep[table].mean())
    assert np.mean(np.array(inside) > np.array(outside)) > 0.75


def test_the_same_seed_gives_the_same_picture(bank: NoiseBank) -> None:
    a, b = (render_picture(np.random.default_rng(5), bank, 64, kind_shares()) for _ in range(2))
    assert (a[0] == b[0]).all()
    assert (a[1] == b[1]).all()


def test_the_shipped_judge_tells_things_from_nothing() -> None:
    """Pictures that neither the network nor its judge was shown."""
    network = load_network()
    things, nothing, right = [], [], []
    for picture, planes in zip(*paint(9_000_017, 0, 60, 160), strict=True):
        for detection in observe(picture, network=network, scale=1.0).detections:
            what = label_of(planes, detection)
            if what == len(KINDS):
                nothing.append(detection.confidence)
            elif what is not None:
                things.append(detection.confidence)
                right.append(detection.kind == KINDS[what])
    assert len(things) > 100
    assert np.mean(np.array(things) > 0.5) > 0.9
    assert np.mean(right) > 0.5  # chance is 1 in 7
    # What is left of nothing by the network is hard: most things must be surer than most of it.
    assert nothing
    assert np.mean(np.array(things)[:, None] > np.array(nothing)) > 0.75
