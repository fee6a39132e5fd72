"""Catalogues of items: builtin parametric meshes, OBJ files, the Debian furniture library."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.scene.rendering.catalogues._catalogue import TASK_SYMBOLS, load_catalogue
    from demospec.scene.rendering.catalogues._items import ANGLE_STEPS, Catalogue, CatalogueItem
    from demospec.scene.rendering.catalogues._obj import read_obj

__all__ = [
    "ANGLE_STEPS",
    "TASK_SYMBOLS",
    "Catalogue",
    "CatalogueItem",
    "load_catalogue",
    "read_obj",
]

_HOME = {
    "ANGLE_STEPS": "_items",
    "TASK_SYMBOLS": "_catalogue",
    "Catalogue": "_items",
    "CatalogueItem": "_items",
    "load_catalogue": "_catalogue",
    "read_obj": "_obj",
}


__getattr__ = names_of(__name__, _HOME)
