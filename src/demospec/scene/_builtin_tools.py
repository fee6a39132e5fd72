"""The builtin catalogue's tools (workbench task)."""

from demospec.scene._catalogue import CatalogueItem


def tools() -> list[CatalogueItem]:
    return []
