"""Homographies from pairs, oblique planes, drawn polylines, hostile HDF5."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from foreign_files import picture, png, write_robomimic
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from demospec.demonstrations.readers import Mapping, fit_homography, guess_format, read_source
from demospec.demonstrations.readers._mapping import ProjectionMapping
from demospec.demonstrations.readers._projection import projection_of, transform
from demospec.errors import InputError

entry = st.floats(-1, 1)


@settings(deadline=None)
@given(st.lists(entry, min_size=8, max_size=8), st.integers(4, 9))
def test_a_fitted_homography_is_the_one_that_made_the_pairs(entries: list[float], n: int) -> None:
    # A projective map near a similarity, with the unit square on the near side of its horizon.
    made = np.array([*entries, 0.0]).reshape(3, 3) * np.array([[0.5], [0.5], [0.2]]) + np.diag(
        [2.0, 2.0, 1.0]
    )
    assume(abs(np.linalg.det(made)) > 0.2)
    rng = np.random.default_rng(n)
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) + rng.uniform(-0.1, 0.1, (4, 2))
    points = np.concatenate([corners, rng.uniform(0, 1, (n - 4, 2))])
    fitted, residual = fit_homography(points, transform(made, points))
    assert residual < 1e-8
    probe = rng.uniform(0, 1, (20, 2))
    np.testing.assert_allclose(transform(fitted, probe), transform(made, probe), atol=1e-7)


def test_pairs_on_a_line_are_refused() -> None:
    line = [[0, 0], [1, 1], [2, 2], [3, 3]]
    with pytest.raises(InputError, match="line"):
        fit_homography(line, [[0, 0], [1, 0], [1, 1], [0, 1]])
    with pytest.raises(InputError, match="different places"):
        fit_homography([[1, 1]] * 4, [[0, 0], [1, 0], [1, 1], [0, 1]])


def test_a_tilted_plane_gives_its_own_coordinates_and_the_height() -> None:
    rng = np.random.default_rng(0)
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.linalg.det(q))
    origin = np.array([0.3, -0.2, 0.7])
    inside = rng.normal(size=(10, 3))
    plane = {"origin": origin.tolist(), "x_axis": q[0].tolist(), "y_axis": q[1].tolist()}
    projection = projection_of(ProjectionMapping.model_validate({"plane": plane}))
    assert projection is not None
    np.testing.assert_allclose(projection.apply(origin + inside @ q), inside, atol=1e-12)


def test_upright_planes_swap_axes() -> None:
    projection = projection_of(ProjectionMapping.model_validate({"plane": "xz"}))
    assert projection is not None
    assert projection.apply(np.array([[1.0, 2.0, 3.0]])).tolist() == [[1.0, 3.0, 2.0]]


def test_points_on_the_horizon_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("x,y\n1,0\n2,0\n")
    horizon = {"homography": [[1, 0, 0], [0, 1, 0], [1, 0, -2]]}
    with pytest.raises(InputError, match="horizon"):
        read_source(tmp_path / "a.csv", mapping=Mapping.model_validate({"projection": horizon}))


def test_label_studio_paths_and_objects(tmp_path: Path) -> None:
    size = {"original_width": 64, "original_height": 48}
    result = [
        {"id": "p1", "type": "vectorlabels", "from_name": "path", "to_name": "img", **size,
         "value": {"vertices": [{"x": 10, "y": 90}, {"x": 90, "y": 10}],
                   "vectorlabels": ["careful"]}},
        {"id": "p1", "type": "choices", "from_name": "valid", "to_name": "img",
         "value": {"choices": ["accepted"]}},
        {"id": "o1", "type": "polygonlabels", "from_name": "o", "to_name": "img", **size,
         "value": {"points": [[40, 40], [60, 40], [60, 60]], "polygonlabels": ["glass"]}},
        {"id": "o2", "type": "rectanglelabels", "from_name": "o", "to_name": "img", **size,
         "value": {"x": 0, "y": 0, "width": 25, "height": 50, "rectanglelabels": ["plate"]}},
    ]  # fmt: skip
    task = {
        "id": 5,
        "data": {"image": "/data/upload/table.png"},
        "annotations": [{"result": result}],
    }
    (tmp_path / "export.json").write_text(json.dumps([task]))
    (tmp_path / "table.png").write_bytes(png(picture(0)))
    assert guess_format(tmp_path / "export.json") == "label-studio"
    mapping = Mapping.model_validate({"type": "label"})
    data = read_source(tmp_path / "export.json", mapping=mapping).data
    (item,) = data.demonstrations
    np.testing.assert_allclose(item.points, [[6.4, 43.2], [57.6, 4.8]])
    assert (item.valid, item.type) == (True, "careful")
    assert data.symbols == ("glass", "plate")
    assert data.scenes[0].listed_objects()[1].bbox == (0, 0, 16, 24)
    assert data.scenes[0].size_px == (64, 48)


CVAT = """<?xml version="1.0" encoding="utf-8"?>
<annotations><version>1.1</version>
<image id="0" name="table.png" width="64" height="48">
  <polyline label="careful" points="6.4,43.2;30,20;57.6,4.8">
    <attribute name="valid">false</attribute></polyline>
  <box label="plate" xtl="0" ytl="0" xbr="16" ybr="24"/>
  <polygon label="glass" points="30,20;36,20;36,28"/>
</image></annotations>"""


def test_cvat_polylines_and_objects(tmp_path: Path) -> None:
    (tmp_path / "annotations.xml").write_text(CVAT)
    assert guess_format(tmp_path) == "cvat"
    data = read_source(tmp_path, mapping=Mapping.model_validate({"type": "label"})).data
    (item,) = data.demonstrations
    assert (item.valid, item.type, len(item.points)) == (False, "careful", 3)
    assert data.symbols == ("glass", "plate")


@pytest.mark.parametrize(
    "text",
    [
        '<!DOCTYPE a [<!ENTITY b "cccc">]>' + CVAT,
        CVAT[:120],
        CVAT.replace("6.4,43.2", "6.4"),
        CVAT.replace('xtl="0"', 'xtl="nan"'),
        CVAT.encode("utf-16").decode("latin-1"),
    ],
)
def test_broken_xml_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.xml").write_text(text, encoding="latin-1")
    with pytest.raises(InputError):
        read_source(tmp_path / "a.xml")


def test_hdf5_object_arrays_links_and_claims_are_refused(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py", reason="pip install 'demospec[hdf5]'")
    write_robomimic(tmp_path / "secret.hdf5")

    def read(path: str) -> None:
        read_source(tmp_path / "a.hdf5", mapping=Mapping.model_validate({"path": path}))

    with h5py.File(tmp_path / "a.hdf5", "w") as file:
        group = file.create_group("data/demo_0")
        group.create_dataset("objects", (3,), dtype=h5py.vlen_dtype(np.float64))
        group["outside"] = h5py.ExternalLink("secret.hdf5", "/data/demo_0/obs/robot0_eef_pos")
        group["loop"] = h5py.SoftLink("/data/demo_0")
        group.create_dataset("vast", (10**9, 10**4), dtype="f8", chunks=(10**3, 10**3))
        group.create_dataset("flat", data=np.zeros(5))
    with pytest.raises(InputError, match="never loaded"):
        read("objects")
    with pytest.raises(InputError, match="a dataset outside"):
        read("outside")
    with pytest.raises(InputError, match="at most"):
        read("vast")
    with pytest.raises(InputError, match="one row a point"):
        read("flat")
