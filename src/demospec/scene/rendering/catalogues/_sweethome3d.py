"""The catalogue `sweethome3d`: real models of Debian's sweethome3d-furniture.

The package's libraries (``*.sh3f``) are zip files of OBJ models with a property file. Only the
models named here are used. Their catalogue sizes are often wrong (a bowl of 45 cm, a ladle of
47 cm): here each model has a plausible length of its own. Real models are few, so each appears
in several looks (colour of the glaze, a little larger or smaller). Train and test hold
*different models*, except for drill, hammer and screwdriver, of which there is one model each:
there the test looks are mirrored and coloured as no training look is. There is no clamp.
"""

from __future__ import annotations

import os
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from demospec.errors import InputError, MissingPackageError
from demospec.frames import FloatArray
from demospec.scene.rendering._mesh import Mesh
from demospec.scene.rendering.catalogues._builtin_looks import GLAZES, rng_of
from demospec.scene.rendering.catalogues._items import CatalogueItem
from demospec.scene.rendering.catalogues._obj import read_obj

_PLACES = ("sweethome3d/furniture", "sweethome3d-furniture", "sweethome3d/plugins")
"""Where Debian puts the libraries, below a folder of shared data."""


def library_folders() -> tuple[Path, ...]:
    """Where libraries are looked for: below every folder of ``XDG_DATA_DIRS``."""
    shared = os.environ.get("XDG_DATA_DIRS") or "/usr/local/share:/usr/share"
    return tuple(Path(root) / place for root in shared.split(":") if root for place in _PLACES)


LICENCES = {
    "KatorLegaz": "CC BY 3.0 US",
    "Scopia": "CC BY 3.0",
    "BlendSwap-CC-BY": "CC BY 3.0",
    "BlendSwap-CC-0": "CC0 1.0",
}
CREATORS = {
    "Kator Legaz": "Andrew Kator and Jennifer Legaz",
    "Scopia": "eTeks and Scopia Visual Interfaces Systems",
}

Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""OBJ frame (y up) → item frame (z up)."""
ON_ITS_SIDE = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
ON_ITS_BACK = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
AS_IT_STANDS = np.eye(3)
CLEAR = np.array([0.86, 0.95, 0.95])


@dataclass(frozen=True)
class Model:
    """One model of a library and what it is here.

    Args:
        symbol: Class word.
        part: ``train``, ``test``, or ``both`` (tools).
        library, path: Where it is.
        length_m: Its longest side on the table, metres.
        groups: Words of the OBJ groups that belong to it; all where empty.
        pose: How it lies.
        within: Faces further than this share of the length from the middle are left out.
        glazed: Whether looks differ by a glaze all over (else by a slight tint).
    """

    symbol: str
    part: str
    library: str
    path: str
    length_m: float
    groups: tuple[str, ...] = ()
    pose: str = "stands"
    within: float | None = None
    glazed: bool = False

    @property
    def name(self) -> str:
        """Short, unique."""
        word = self.groups[0] if self.groups else Path(self.path).stem
        return re.sub(r"[^a-z0-9]+", "-", f"{self.library}-{word}".lower()).strip("-")


_KL, _SC, _BY, _C0 = "KatorLegaz", "Scopia", "BlendSwap-CC-BY", "BlendSwap-CC-0"
_COVER = "scopia/ensemble-assiette-couteau-fourchette-cuillere-verre/"
_COVER += "ensemble-assiette-couteau-fourchette-cuillere-verre.obj"
_SET = "katorlegaz/plate-and-ustensils/plate-and-ustensils.obj"
_CUP = "scopia/cup/cup.obj"

MODELS = (
    Model("utensil", "train", _BY, "blendswap-cc-by/fork/fork.obj", 0.185),
    Model("utensil", "train", _BY, "blendswap-cc-by/spoon/spoon.obj", 0.185),
    Model("utensil", "train", _BY, "blendswap-cc-by/kitchenKnife/kitchenKnife.obj", 0.26),
    Model("utensil", "train", _SC, "scopia/kitchen_tool1/kitchen_tool1.obj", 0.25),
    Model("utensil", "train", _SC, "scopia/kitchen_tool3/kitchen_tool3.obj", 0.26),
    Model("utensil", "train", _KL, _SET, 0.19, ("table_knife",)),
    Model("utensil", "test", _BY, "blendswap-cc-by/knife/knife.obj", 0.21),
    Model("utensil", "test", _SC, "scopia/kitchen_tool2/kitchen_tool2.obj", 0.25),
    Model("utensil", "test", _SC, "scopia/kitchen_tool4/kitchen_tool4.obj", 0.24),
    Model("utensil", "test", _KL, _SET, 0.18, ("fork_fork",)),
    Model("utensil", "test", _C0, "blendswap-cc-0/cissors_swap/cissors_swap.obj", 0.15),
    Model("plate", "train", _KL, "katorlegaz/bread-plate/bread-plate.obj", 0.20, glazed=True),
    Model("plate", "train", _SC, _COVER, 0.21, ("dish",), glazed=True),
    Model("plate", "test", _KL, "katorlegaz/dinner-plate/dinner-plate.obj", 0.23, glazed=True),
    Model("plate", "test", _SC, _CUP, 0.165, ("plate_Plane",), glazed=True),
    Model("bowl", "train", _SC, "scopia/bowl/bowl.obj", 0.15, glazed=True),
    Model("bowl", "train", _SC, "scopia/bowlWithSalad/bowlWithSalad.obj", 0.165),
    Model("bowl", "test", _KL, "katorlegaz/bowl/bowl.obj", 0.18, glazed=True),
    Model("bowl", "test", _SC, "scopia/bowlWithFruits/bowlWithFruits.obj", 0.185),
    Model("glass", "train", _KL, "katorlegaz/12-oz-glass/12-oz-glass.obj", 0.075),
    Model("glass", "train", _KL, "katorlegaz/coffee-mug/coffee-mug.obj", 0.115, glazed=True),
    Model("glass", "train", _BY, "blendswap-cc-by/glass/glass.obj", 0.078),
    Model("glass", "train", _C0, "blendswap-cc-0/plasticCup/plasticCup.obj", 0.08, glazed=True),
    Model("glass", "train", _C0, "blendswap-cc-0/caffe_final/caffe_final.obj", 0.105, glazed=True),
    Model("glass", "test", _KL, "katorlegaz/highball-glass/highball-glass.obj", 0.07),
    Model("glass", "test", _BY, "blendswap-cc-by/cocktailGlass/cocktailGlass.obj", 0.085),
    Model("glass", "test", _C0, "blendswap-cc-0/beerGlass/beerGlass.obj", 0.135),
    Model("glass", "test", _SC, _CUP, 0.10, ("cup_Plane",), glazed=True),
    Model("drill", "both", _SC, "scopia/perceuse-electrique/perceuse-electrique.obj", 0.22,
          pose="side"),
    Model("hammer", "both", _SC, "scopia/marteau/marteau.obj", 0.28),
    Model("screwdriver", "both", _SC, "scopia/tournevis/tournevis.obj", 0.22),
    Model("tape", "train", _SC, "scopia/rouleau-de-ruban-adhesif/rouleau-de-ruban-adhesif.obj",
          0.10, pose="back", within=0.45),
    Model("tape", "test", _KL, "katorlegaz/tape-measure/tape-measure.obj", 0.14),
)  # fmt: skip

_LOOKS = {"train": 16, "test": 8}
"""About as many looks a symbol as the builtin catalogue has."""


def sweethome3d_items(folders: tuple[Path, ...]) -> tuple[CatalogueItem, ...]:
    """The items of all models whose libraries lie in one of the folders.

    Raises:
        MissingPackageError: No library is found.
    """
    libraries = _libraries(folders)
    if not libraries:
        raise MissingPackageError("sweethome3d-furniture", "the catalogue sweethome3d")
    items = []
    symbols = dict.fromkeys(model.symbol for model in MODELS)
    for symbol in symbols:
        for part, looks in _LOOKS.items():
            models = [
                m
                for m in MODELS
                if m.symbol == symbol and m.part in (part, "both") and m.library in libraries
            ]
            for k in range(looks if models else 0):
                items.append(_item(libraries, models[k % len(models)], part, k // len(models)))
    return tuple(items)


def _libraries(folders: tuple[Path, ...]) -> dict[str, Path]:
    """Library name → file, of those that are there."""
    found: dict[str, Path] = {}
    for folder in folders:
        for name in LICENCES:
            file = folder / f"{name}.sh3f"
            if name not in found and file.is_file():
                found[name] = file
    return found


def _item(libraries: Mapping[str, Path], model: Model, part: str, look: int) -> CatalogueItem:
    entry = _entry(libraries[model.library], model.path)
    creator = entry.get("creator", model.library)
    return CatalogueItem(
        "sweethome3d",
        f"{model.symbol}-{model.name}-{part}-{look}",
        model.symbol,
        part,
        partial(_make, libraries[model.library], model, part, look),
        creator=CREATORS.get(creator, creator),
        licence=LICENCES[model.library],
        source=f"Sweet Home 3D, {model.library}, {entry.get('name', model.name)}",
    )


@lru_cache(maxsize=16)
def _entries(library: Path) -> dict[str, dict[str, str]]:
    """Model path → its properties in the library."""
    try:
        with zipfile.ZipFile(library) as archive:
            text = archive.read("PluginFurnitureCatalog.properties").decode("latin-1")
    except (OSError, KeyError, zipfile.BadZipFile) as error:
        raise InputError("a Sweet Home 3D library", str(error), file=library) from error
    rows: dict[str, dict[str, str]] = {}
    for line in text.splitlines():
        match = re.match(r"(\w+)#(\d+)=(.*)", line)
        if match:
            rows.setdefault(match[2], {})[match[1]] = match[3].strip()
    return {row["model"].lstrip("/"): row for row in rows.values() if "model" in row}


def _entry(library: Path, path: str) -> dict[str, str]:
    return _entries(library).get(path, {})


@lru_cache(maxsize=64)
def _base(library: Path, model: Model) -> Mesh:
    """The model in the item frame, lying as it should, at its length."""
    with zipfile.ZipFile(library) as archive:
        mesh = read_obj(archive.read, model.path, groups=model.groups)
    turn = _entry(library, model.path).get("modelRotation")
    frame = np.eye(3) if turn is None else np.array(turn.split(), dtype=np.float64).reshape(3, 3)
    pose = {"stands": AS_IT_STANDS, "side": ON_ITS_SIDE, "back": ON_ITS_BACK}[model.pose]
    to_item = pose @ Y_UP @ frame
    mesh = replace(
        mesh, vertices=mesh.vertices @ to_item.T, normals=mesh.normals @ to_item.T
    ).seen_from_above()
    if model.within is not None:
        mesh = mesh.trimmed(model.within)
    span = np.ptp(mesh.vertices[:, :2], axis=0).max()
    glassy = mesh.opacity < 0.99
    return replace(
        mesh,
        vertices=mesh.vertices * (model.length_m / float(span)),
        # Drawn flat, the libraries' glass would be all but invisible on a light table.
        opacity=np.where(glassy, np.maximum(mesh.opacity, 0.26), mesh.opacity),
        colour=np.where(glassy[:, None], 0.4 * mesh.colour + 0.6 * CLEAR, mesh.colour),
        gloss=np.where(glassy, 0.8, mesh.gloss),
    ).centred()


def _make(library: Path, model: Model, part: str, look: int) -> Mesh:
    """One look of a model: look 0 of a training model is the model as it came."""
    base = _base(library, model)
    if look == 0 and not (part == "test" and model.part == "both"):
        return base
    rng = rng_of(f"{model.symbol}-{model.name}-{part}-{look}")
    v = base.vertices * rng.uniform(0.92, 1.08)
    normals = base.normals
    if part == "test" and model.part == "both":
        flip = np.array([1.0, -1.0, 1.0])
        v, normals = v * flip, normals * flip
    return Mesh(
        v, base.faces, normals, _recoloured(base, model, part, rng), base.opacity, base.gloss
    )


def _recoloured(base: Mesh, model: Model, part: str, rng: np.random.Generator) -> FloatArray:
    """Glazed: times a glaze. Others: strong colours change their hue, greys a little."""
    if model.glazed:
        glaze = GLAZES[rng.integers(len(GLAZES))] + rng.uniform(-0.05, 0.05, 3)
        return np.asarray(np.clip(base.colour * glaze * 1.05, 0.02, 0.98))
    if model.part == "both":
        # Training looks turn the hue one way round, test looks the other.
        turn = rng.uniform(0.08, 0.45) * (1.0 if part == "train" else -1.0)
    else:
        turn = rng.uniform(-0.04, 0.04)
    grey = base.colour.mean(axis=1, keepdims=True)
    angle = 2 * np.pi * turn
    # Rotation about the grey axis (1, 1, 1).
    c, s = np.cos(angle), np.sin(angle)
    third, root = (1 - c) / 3, s / np.sqrt(3.0)
    hue = np.array(
        [
            [c + third, third - root, third + root],
            [third + root, c + third, third - root],
            [third - root, third + root, c + third],
        ]
    )
    turned = grey + (base.colour - grey) @ hue.T
    return np.asarray(
        np.clip(turned * rng.uniform(0.85, 1.12) * rng.uniform(0.97, 1.03, 3), 0.02, 0.98)
    )
