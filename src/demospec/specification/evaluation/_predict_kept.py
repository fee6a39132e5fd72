"""Finished parts of a long prediction, kept until all are there: a killed run goes on."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from dataclasses import astuple
from pathlib import Path

from demospec.files import read_json, writing_file
from demospec.specification.evaluation._predict import Prediction, Predictions


class KeptParts:
    """Parts on disk, each written whole; those of another job are thrown away.

    Args:
        folder: Made where it is missing.
        job: What tells this job from others (see `job_of`).
    """

    def __init__(self, folder: Path, job: str) -> None:
        self.folder = folder
        name = folder / "job"
        if not name.is_file() or name.read_text(encoding="utf-8") != job:
            self.remove()
            folder.mkdir(parents=True)
            with writing_file(name) as temporary:
                temporary.write_text(job, encoding="utf-8")
        self.there = {int(f.stem) for f in folder.glob("*.json") if f.stem.isdecimal()}

    def save(self, index: int, part: Predictions) -> None:
        """Keeps one part. Numbers survive as they are: JSON writes all digits that matter."""
        document = {
            "items": [astuple(item) for item in part.items],
            "unjudged": part.unjudged,
            "unknown_types": part.unknown_types,
        }
        with writing_file(self.folder / f"{index}.json") as temporary:
            temporary.write_text(json.dumps(document), encoding="utf-8")

    def read(self, index: int) -> Predictions:
        """A part that is there."""
        document = read_json(self.folder / f"{index}.json")
        items = tuple(Prediction(*item) for item in document["items"])
        return Predictions(items, document["unjudged"], tuple(document["unknown_types"]))

    def remove(self) -> None:
        """Throws everything away, once the output is written."""
        shutil.rmtree(self.folder, ignore_errors=True)


def job_of(model: str, store: str, rows: int) -> str:
    """Changes whenever the answer could: versions, parts, and every file's size and time."""
    from importlib.metadata import version

    files = [f"demospec {version('demospec')}, {rows} rows"]
    for place in (model, store):
        for file in sorted(_files(Path(place))):
            state = os.stat(file)
            files.append(f"{file} {state.st_size} {state.st_mtime_ns}")
    return "\n".join(files)


def _files(place: Path) -> Iterator[Path]:
    # Of a set the pictures are left out: ten thousand are much to ask after, and replacing one
    # goes with rewriting the list.
    if place.is_file():
        yield place
    elif (place / "dataset.json").is_file():
        yield from (place / "dataset.json", place / "demonstrations.parquet")
        yield place / "scenes" / "metadata.jsonl"
    else:
        yield from (file for file in place.iterdir() if file.is_file())
