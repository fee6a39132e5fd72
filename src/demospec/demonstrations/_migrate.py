"""Older versions of the set format, brought to the current one in memory, never on disk.

`demospec convert OLD NEW` (format ``demospec``) writes the current version.

Version 0 is the draft that preceded version 1: ``classes`` for ``symbols``, ``user_types`` for
``types``, ``pixel_size_m`` for ``metres_per_unit``, an object's ``label`` for its ``symbol``, a
column ``success`` for ``valid``, and no ``columns``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pyarrow as pa

FORMAT_VERSION = 1

_Document = dict[str, Any]

_HEADER_0 = {"classes": "symbols", "user_types": "types", "pixel_size_m": "metres_per_unit"}
_OBJECT_0 = {"label": "symbol"}
_TABLE_0 = {"success": "valid"}


def version_of(header: object) -> int:
    """The version a header states; the current one where it states none or not a number."""
    version = header.get("version", FORMAT_VERSION) if isinstance(header, dict) else None
    known = isinstance(version, int) and not isinstance(version, bool) and version >= 0
    return version if known and version is not None else FORMAT_VERSION


def migrate_header(header: object) -> object:
    """``dataset.json`` as the current version would have it."""
    return _each(header, version_of(header), _HEADERS)


def migrate_scene(line: object, version: int) -> object:
    """A line of ``metadata.jsonl`` as the current version would have it."""
    return _each(line, version, _SCENES)


def migrate_table(table: pa.Table, version: int) -> pa.Table:
    """The columns of ``demonstrations.parquet`` as the current version names them."""
    if version > 0:
        return table
    return table.rename_columns([_TABLE_0.get(name, name) for name in table.column_names])


def _each(
    document: object, version: int, steps: Mapping[int, Callable[[_Document], _Document]]
) -> object:
    if not isinstance(document, dict):
        return document  # the schema will say what is wrong with it
    for old in range(version, FORMAT_VERSION):
        document = steps[old](document)
    return document


def _renamed(document: _Document, names: Mapping[str, str]) -> _Document:
    return {names.get(key, key): value for key, value in document.items()}


def _header_from_0(document: _Document) -> _Document:
    return {**_renamed(document, _HEADER_0), "version": 1}


def _scene_from_0(document: _Document) -> _Document:
    objects = document.get("objects")
    if not isinstance(objects, list):
        return document
    renamed = [_renamed(o, _OBJECT_0) if isinstance(o, dict) else o for o in objects]
    return {**document, "objects": renamed}


_HEADERS: dict[int, Callable[[_Document], _Document]] = {0: _header_from_0}
_SCENES: dict[int, Callable[[_Document], _Document]] = {0: _scene_from_0}
