"""JSON Schema of the file formats, from the models that check them.

`python -m demospec.demonstrations._schema_export docs/schema` writes them; a test compares.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from demospec.demonstrations._migrate import FORMAT_VERSION
from demospec.demonstrations._schema import Coordinate, Header, Name, SceneLine
from demospec.demonstrations._trajectory import MAX_POINTS
from demospec.files import to_json

_DIALECT = "https://json-schema.org/draft/2020-12/schema"


class DemonstrationRow(BaseModel):
    """One row of ``demonstrations.parquet``, as JSON would hold it."""

    model_config = ConfigDict(extra="allow", strict=True)

    demo_id: str
    scene_id: str
    type: str | None = None
    demonstrator: str | None = None
    valid: bool | None = None
    points: Annotated[
        list[Annotated[list[Coordinate], Field(min_length=2)]],
        Field(min_length=1, max_length=MAX_POINTS),
    ]
    """One list of numbers a point, as long as ``columns`` of ``dataset.json``."""
    t: list[float] | None = None
    """Seconds, one a point."""
    score: Annotated[float, Field(ge=0, le=1)] | None = None
    """How acceptable; without ``valid``, one half and more is accepted."""


class PairRow(BaseModel):
    """One row of ``pairs.parquet``, as Arrow reads it."""

    model_config = ConfigDict(extra="allow", strict=True)

    preferred: str
    """A demonstration of the set."""
    other: str
    """Another one."""
    type: str | None = None
    """Who prefers; without it, the type of both demonstrations."""


class AuditedDemonstration(BaseModel):
    """One demonstration in the JSON of ``demospec audit``."""

    model_config = ConfigDict(extra="allow", strict=True)

    demo_id: Name
    verdict: Annotated[str, Field(pattern="^(pass|review)$")]
    why: str
    p_wrong: Annotated[float, Field(ge=0, le=1)] | None = None
    p_label: Annotated[float, Field(ge=0, le=1)] | None = None


class AuditDocument(BaseModel):
    """The JSON of ``demospec audit``."""

    model_config = ConfigDict(extra="allow", strict=True)

    conflict: list[Name] | None
    demonstrations: list[AuditedDemonstration]


def schemas() -> dict[str, dict[str, Any]]:
    """File name → JSON Schema."""
    from demospec.demonstrations.readers import Mapping

    models: dict[str, tuple[type[BaseModel], str]] = {
        "dataset": (Header, "dataset.json of a demonstration set"),
        "scene": (SceneLine, "one line of scenes/metadata.jsonl of a demonstration set"),
        "demonstration": (DemonstrationRow, "one row of demonstrations.parquet"),
        "pair": (PairRow, "one row of pairs.parquet"),
        "mapping": (Mapping, "a mapping file of demospec convert --map"),
        "audit": (AuditDocument, "the answer of demospec audit --json"),
    }
    out = {}
    for name, (model, title) in models.items():
        document = model.model_json_schema()
        document.pop("title", None)
        out[f"{name}.schema.json"] = {
            "$schema": _DIALECT,
            "title": title,
            "$comment": f"demospec format version {FORMAT_VERSION}; generated, do not edit",
            **document,
        }
    return out


def write_schemas(folder: Path) -> list[Path]:
    """Writes every schema into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, document in schemas().items():
        file = folder / name
        file.write_text(to_json(document) + "\n", encoding="utf-8")
        files.append(file)
    return files


if __name__ == "__main__":
    for written in write_schemas(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/schema")):
        print(written)
