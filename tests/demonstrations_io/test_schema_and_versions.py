"""The published schemas are current and accept what is read; version 0 becomes version 1."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from small_sets import change_json, change_line, digest

from demospec.demonstrations import check_set, iterate_batches, read_set, write_set
from demospec.demonstrations._schema_export import schemas
from demospec.demonstrations.readers import convert
from demospec.files import to_json
from demospec.testing import small_set, write_small_set

DOCS = Path(__file__).parents[2] / "docs" / "schema"


@pytest.mark.parametrize("name", list(schemas()))
def test_published_schemas_are_current(name: str) -> None:
    assert (DOCS / name).read_text() == to_json(schemas()[name]) + "\n", (
        "run  python -m demospec.demonstrations._schema_export docs/schema"
    )


def test_no_stale_schema_is_published() -> None:
    assert {p.name for p in DOCS.iterdir()} == set(schemas())


def test_written_sets_satisfy_the_published_schemas(tmp_path: Path) -> None:
    jsonschema = pytest.importorskip("jsonschema", reason="pip install jsonschema")
    import pyarrow.parquet as pq

    root = write_small_set(tmp_path / "set", t=True)

    def accepts(name: str, document: object) -> None:
        schema = json.loads((DOCS / name).read_text())
        jsonschema.Draft202012Validator.check_schema(schema)
        jsonschema.validate(document, schema, cls=jsonschema.Draft202012Validator)

    accepts("dataset.schema.json", json.loads((root / "dataset.json").read_text()))
    for line in (root / "scenes" / "metadata.jsonl").read_text().splitlines():
        accepts("scene.schema.json", json.loads(line))
    for row in pq.read_table(root / "demonstrations.parquet").to_pylist():
        accepts("demonstration.schema.json", row)
    with pytest.raises(jsonschema.ValidationError):
        accepts("dataset.schema.json", {"format": "demospec", "columns": ["x"]})


def version_0(folder: Path) -> Path:
    """A set as the draft before version 1 had it."""
    import pyarrow.parquet as pq

    root = write_small_set(folder)

    def header(document: dict) -> None:
        for old, new in (("classes", "symbols"), ("user_types", "types")):
            document[old] = document.pop(new)
        document.pop("columns")
        document.pop("metres_per_unit")
        document["pixel_size_m"] = 0.004
        document["version"] = 0

    change_json(root / "dataset.json", header)

    def scene(line: dict) -> None:
        for item in line["objects"]:
            item["label"] = item.pop("symbol")

    change_line(root, 0, scene)
    change_line(root, 1, scene)
    file = root / "demonstrations.parquet"
    table = pq.read_table(file)
    names = ["success" if n == "valid" else n for n in table.column_names]
    pq.write_table(table.rename_columns(names), file)
    return root


def test_version_0_is_read_and_converted(tmp_path: Path) -> None:
    from dataclasses import replace

    root = version_0(tmp_path / "old")
    before = digest(root)
    expected = replace(small_set(), metres_per_unit=0.004)
    assert read_set(root) == expected
    assert [d for b in iterate_batches(root, rows=4) for d in b.demonstrations] == list(
        expected.demonstrations
    )
    assert check_set(root).readable
    convert(root, tmp_path / "new")
    assert json.loads((tmp_path / "new" / "dataset.json").read_text())["version"] == 1
    assert read_set(tmp_path / "new") == expected
    assert digest(root) == before


def test_unknown_keys_are_kept(tmp_path: Path) -> None:
    root = write_small_set(tmp_path / "set")
    change_json(root / "dataset.json", lambda d: d.update(camera={"height_m": 1.2}))
    change_line(root, 0, lambda d: d.update(lamp="left"))
    write_set(read_set(root), tmp_path / "copy")
    again = json.loads((tmp_path / "copy" / "dataset.json").read_text())
    assert again["camera"] == {"height_m": 1.2}
    assert '"lamp": "left"' in (tmp_path / "copy" / "scenes" / "metadata.jsonl").read_text()
