"""Catalogues by name: the builtin one, and Sweet Home 3D's where it is installed."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Literal

from demospec.errors import InputError
from demospec.scene.rendering.catalogues._builtin_tableware import tableware
from demospec.scene.rendering.catalogues._builtin_tools import tools
from demospec.scene.rendering.catalogues._items import Catalogue
from demospec.scene.rendering.catalogues._sweethome3d import library_folders, sweethome3d_items

Part = Literal["train", "test", "all"]

TASK_SYMBOLS: dict[str, tuple[str, ...]] = {
    "tabletop": ("utensil", "plate", "bowl", "glass"),
    "workbench": ("drill", "hammer", "screwdriver", "clamp", "tape"),
}
"""The symbols of each task, in the order in which sets list them."""


@lru_cache(maxsize=8)
def _whole(name: str, folders: tuple[Path, ...]) -> Catalogue:
    if name == "builtin":
        return Catalogue("builtin", (*tableware(), *tools()))
    if name == "sweethome3d":
        return Catalogue("sweethome3d", sweethome3d_items(folders))
    raise InputError("a catalogue: builtin or sweethome3d", name, field="catalogue")


def load_catalogue(name: str = "builtin", part: Part = "all") -> Catalogue:
    """A catalogue, or the part of it whose items training scenes or test scenes may hold.

    Args:
        name: ``builtin`` (always there) or ``sweethome3d`` (Debian package
            sweethome3d-furniture, found below the folders of ``XDG_DATA_DIRS``).
        part: ``train``, ``test`` or ``all``. Train and test share no item. Carried items are
            in ``all`` only.

    Raises:
        InputError: No such catalogue or part.
        MissingPackageError: The Debian package is not installed.
    """
    if part not in ("train", "test", "all"):
        raise InputError("a part: train, test or all", part, field="part")
    whole = _whole(name, library_folders() if name == "sweethome3d" else ())
    if part == "all":
        return whole
    return Catalogue(name, tuple(item for item in whole.items if item.part == part))
