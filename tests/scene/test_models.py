"""OBJ models, and the catalogue of Debian's real ones."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np
import PIL.Image
import pytest

from demospec.errors import InputError, MissingPackageError
from demospec.scene import SAMPLES, TASK_SYMBOLS, Catalogue, load_catalogue
from demospec.scene.rendering.catalogues import read_obj

OBJ = b"""mtllib thing.mtl
v 0 0 0
v 2 0 0
v 2 1 0
v 0 1 0
v 0 0 5
vt 0.25 0.25
vt 0.75 0.25
vt 0.75 0.75
vn 0 0 -1
o base
usemtl red
f 1 2 3 4
o top
usemtl clear
f -5//1 -4//1 -1//1
usemtl picture
f 1/1 2/2 3/3
"""
MTL = b"""newmtl red
Kd 1 0 0
Ks 0.5 0.5 0.5
newmtl clear
Kd 0.5 0.9 0.9
d 0.3
newmtl picture
map_Kd picture.png
"""


def files(obj: bytes = OBJ) -> dict[str, bytes]:
    picture = io.BytesIO()
    PIL.Image.new("RGB", (8, 8), (0, 128, 255)).save(picture, format="PNG")
    return {"m/thing.obj": obj, "m/thing.mtl": MTL, "m/picture.png": picture.getvalue()}


def test_polygons_materials_textures_and_relative_indices() -> None:
    mesh = read_obj(files().__getitem__, "m/thing.obj")
    assert len(mesh.faces) == 4  # the quadrilateral is two triangles
    assert mesh.colour[0].tolist() == [1.0, 0.0, 0.0]
    assert mesh.gloss[0] == pytest.approx(0.5)
    assert mesh.opacity.tolist() == [1.0, 1.0, 0.3, 1.0]
    np.testing.assert_allclose(mesh.colour[3], [0, 128 / 255, 1], atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=2), 1.0, atol=1e-9)
    np.testing.assert_allclose(mesh.vertices[mesh.faces[2]], [[0, 0, 0], [2, 0, 0], [0, 0, 5]])


def test_one_group_of_a_model() -> None:
    mesh = read_obj(files().__getitem__, "m/thing.obj", groups=("top",))
    assert len(mesh.faces) == 2
    assert len(mesh.vertices) == 4  # what no face uses is gone


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"v 0 0 zero\nf 1 1 1", r"row 0: expected a line of an OBJ model"),
        (b"v 0 0 0\nf 1 2 3", r"row 1: expected a line of an OBJ model"),
        (b"v 0 0 0\nf 0 1 1", r"row 1"),
        (b"v 0 0 0\n", "at least one face"),
        (b"\xff\xfe\x00", "at least one face"),
    ],
)
def test_broken_models_are_named(text: bytes, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_obj(files(text).__getitem__, "m/thing.obj")


def test_absent_files() -> None:
    with pytest.raises(InputError, match="no such file"):
        read_obj({}.__getitem__, "m/thing.obj")
    grey = read_obj({"m/thing.obj": OBJ}.__getitem__, "m/thing.obj")
    assert (grey.colour == 0.7).all()


def test_without_the_debian_package_the_message_names_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_DATA_DIRS", str(tmp_path))
    libraries = tmp_path / "sweethome3d-furniture"
    libraries.mkdir()
    with pytest.raises(MissingPackageError, match="apt-get install sweethome3d-furniture"):
        load_catalogue("sweethome3d")
    (libraries / "Scopia.sh3f").write_bytes(b"not a zip")
    with pytest.raises(InputError, match=r"a Sweet Home 3D library"):
        load_catalogue("sweethome3d")
    with zipfile.ZipFile(libraries / "Scopia.sh3f", "w") as archive:
        archive.writestr("readme.txt", "nothing here")
    with pytest.raises(InputError, match=r"a Sweet Home 3D library"):
        load_catalogue("sweethome3d")


@pytest.fixture(scope="module")
def real() -> Catalogue:
    try:
        return load_catalogue("sweethome3d")
    except MissingPackageError as error:
        pytest.skip(str(error))


def test_real_items_are_of_plausible_size_and_credited(real: Catalogue) -> None:
    limits = {"glass": (0.06, 0.15), "plate": (0.14, 0.26), "bowl": (0.12, 0.22),
              "utensil": (0.13, 0.30), "drill": (0.15, 0.28), "hammer": (0.22, 0.34),
              "screwdriver": (0.15, 0.28), "tape": (0.08, 0.17)}  # fmt: skip
    for item in real.items[::2]:
        low, high = limits[item.symbol]
        long = float(np.ptp(item.outline_m, axis=0).max())
        assert low <= long <= high, item.name
        sprite = item.sprite(0.7, 1 / 0.0082)
        j, i = np.nonzero(sprite.cover)
        drawn = (np.column_stack([i, j]) + 0.5) / SAMPLES - np.asarray(sprite.half_px)
        gap = item.footprint((0.0, 0.0), 0.7, 0.0082).signed_distance(drawn)
        assert gap.max() < 0.5, item.name  # one outline holds all that is drawn
        assert item.creator
        assert item.licence.startswith("CC")
    assert {row["item"] for row in real.attribution()} == {i.name for i in real.items}


def test_real_train_and_test_items_are_disjoint(real: Catalogue) -> None:
    train, test = load_catalogue("sweethome3d", "train"), load_catalogue("sweethome3d", "test")
    for symbol in TASK_SYMBOLS["tabletop"]:
        models = [
            {item.name.rsplit("-", 2)[0] for item in part.of_symbol(symbol)}
            for part in (train, test)
        ]
        assert not models[0] & models[1]  # other models, not other colours of the same
        assert len(train.of_symbol(symbol)) >= 12
    looks = [{i.sprite(0.0, 60.0).albedo.tobytes() for i in part.items} for part in (train, test)]
    assert not looks[0] & looks[1]
    assert len(train.items) + len(test.items) == len(real.items)
