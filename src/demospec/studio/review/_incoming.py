"""Recordings that somebody drops on the page: kept apart, tried, read."""

from __future__ import annotations

import re
import tempfile
import threading
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from uuid import uuid4

from pydantic import BaseModel, ConfigDict, Field

from demospec.demonstrations import DemonstrationSet, readers
from demospec.errors import InputError

MOST_BYTES = 2 * 1024**3
MOST_FILES = 20_000
MOST_BATCHES = 6
"""Batches that are kept; the oldest goes."""


class How(BaseModel):
    """How dropped recordings are read: a part of the mapping of ``demospec convert``."""

    model_config = ConfigDict(extra="forbid")
    format: str | None = Field(default=None, description="One of the formats of demospec convert.")
    columns: dict[str, str] | None = Field(default=None, description="Ours → theirs: x, y, z, …")
    path: str | None = Field(default=None, description="Array, feature or topic of the path.")
    demonstration: str | None = Field(default=None, description="Column that tells paths apart.")
    time: str | None = None
    time_unit: str | None = None
    units: str | None = Field(default=None, description="px, m, cm or mm.")
    metres_per_unit: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    plane: str | None = Field(default=None, description="xy, zx, yz or xz.")
    valid: str | None = None
    type: str | None = None
    demonstrator: str | None = None
    scene: str | None = None
    drop_missing: bool | None = None

    def mapping(self) -> readers.Mapping:
        """As the readers take it."""
        said = self.model_dump(exclude_none=True, exclude={"format", "plane"})
        if "columns" in said:
            words = [f"{ours}={theirs}" for ours, theirs in said["columns"].items() if theirs]
            said["columns"] = readers.column_options(words)
        if self.plane:
            said["projection"] = {"plane": self.plane}
        return readers.with_options(readers.Mapping(), said)


@dataclass
class Batch:
    """Files that were dropped together."""

    folder: Path
    size: int = 0
    count: int = 0
    unpacked: bool = False
    progress: tuple[str, float] = ("", 0.0)
    lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def source(self) -> Path:
        """The one file or folder that was dropped, else the folder of all."""
        found = sorted(self.folder.iterdir())
        while len(found) == 1 and found[0].is_dir():
            inner = sorted(found[0].iterdir())
            if len(inner) != 1 or not inner[0].is_dir():
                break
            found = inner
        return found[0] if len(found) == 1 else self.folder


class Incoming:
    """Dropped files of one studio, in a temporary folder that goes with it."""

    def __init__(self) -> None:
        self._root: tempfile.TemporaryDirectory[str] | None = None
        self._lock = threading.Lock()
        self._batches: dict[str, Batch] = {}

    def begin(self) -> str:
        """The name of a new batch."""
        import shutil

        with self._lock:
            if self._root is None:
                self._root = tempfile.TemporaryDirectory(
                    prefix="demospec-", ignore_cleanup_errors=True
                )
            while len(self._batches) >= MOST_BATCHES:
                oldest = self._batches.pop(next(iter(self._batches)))
                shutil.rmtree(oldest.folder, ignore_errors=True)
            name = uuid4().hex
            folder = Path(self._root.name) / name
            folder.mkdir()
            self._batches[name] = Batch(folder)
            return name

    def batch(self, name: str) -> Batch:
        """A batch that was begun."""
        with self._lock:
            found = self._batches.get(name)
        if found is None:
            raise InputError("recordings that were dropped here (drop them again)", "none",
                             field="batch")  # fmt: skip
        return found

    def put(self, name: str, file: str, data: bytes, offset: int) -> None:
        """A piece of a file; pieces of a file come in order."""
        batch = self.batch(name)
        place = batch.folder.joinpath(*_safe(file))
        with batch.lock:
            batch.size += len(data)
            batch.count += offset == 0
            _bounded(batch)
            place.parent.mkdir(parents=True, exist_ok=True)
            there = place.stat().st_size if offset and place.is_file() else 0
            if offset != there:
                raise InputError(f"the piece at byte {there}", offset, field="offset")
            with place.open("ab" if offset else "wb") as stream:
                stream.write(data)

    def read(self, name: str, how: How, *, pictures: bool) -> tuple[readers.Conversion, str]:
        """The recordings of a batch as a set, and what they are called."""
        batch = self.batch(name)

        def told(what: str, done: float, total: float) -> None:
            batch.progress = (what, min(1.0, done / total) if total else 0.0)

        with batch.lock:
            if not batch.unpacked:
                _unpack(batch)
                batch.unpacked = True
            source = batch.source
            try:
                found = readers.read_source(
                    source, format=how.format or None, mapping=how.mapping(), pictures=pictures,
                    progress=told,
                )  # fmt: skip
                if pictures:
                    from demospec.demonstrations import pictures_in_memory

                    found = _with(found, pictures_in_memory(found.data))
            except InputError as error:
                raise InputError(
                    _for_the_page(error.expected), error.found, row=error.row, field=error.field,
                    file=None if error.file is None else _inside(error.file, batch.folder),
                ) from error  # fmt: skip
            finally:
                batch.progress = ("", 0.0)
        label = source.name if source != batch.folder else f"{batch.count} files"
        return found, label


def _with(found: readers.Conversion, data: DemonstrationSet) -> readers.Conversion:
    from dataclasses import replace

    return replace(found, data=data)


def _safe(file: str) -> list[str]:
    """The parts of a relative path; InputError where it leads elsewhere."""
    parts = [p for p in re.split(r"[/\\]", file) if p not in ("", ".")]
    wrong = not parts or len(parts) > 12 or ":" in parts[0]
    if wrong or any(p == ".." or len(p.encode()) > 200 or not p.isprintable() for p in parts):
        raise InputError("the name of a file in what was dropped", file, field="name")
    return parts


def _bounded(batch: Batch) -> None:
    if batch.size > MOST_BYTES or batch.count > MOST_FILES:
        expected = f"at most {MOST_BYTES // 2**30} GB in {MOST_FILES} files (demospec convert "
        raise InputError(expected + "reads larger ones)", "more", field="recordings")


def _unpack(batch: Batch) -> None:
    """Archives become folders; nothing in them is written elsewhere."""
    for file in sorted(p for p in batch.folder.rglob("*.zip") if p.is_file()):
        folder = file.with_suffix("")
        try:
            with zipfile.ZipFile(file) as archive:
                for entry in archive.infolist():
                    if entry.is_dir() or entry.filename.startswith("__MACOSX/"):
                        continue
                    place = folder.joinpath(*_safe(entry.filename))
                    place.parent.mkdir(parents=True, exist_ok=True)
                    batch.count += 1
                    with archive.open(entry) as inner, place.open("wb") as out:
                        # Told by what comes out: an archive may say less than it holds.
                        while piece := inner.read(1 << 20):
                            batch.size += len(piece)
                            _bounded(batch)
                            out.write(piece)
        except (zipfile.BadZipFile, NotImplementedError, RuntimeError, OSError) as error:
            raise InputError("a zip archive", str(error), file=file.name) from error
        file.unlink()


_OPTIONS = {
    "--drop-missing": "Leave out missing points", "--from": "Format", "--plane": "Plane",
    "--metres-per-unit": "One pixel is", "--time-unit": "Unit of time", "--units": "Unit",
    "--demonstration": "Paths told apart by", "--valid": "Verdict", "--type": "Whose",
    "--path": "Path", "--time": "Time",
}  # fmt: skip


def _for_the_page(words: str) -> str:
    """What an option of the command line is called on the page."""
    for option, label in _OPTIONS.items():
        words = re.sub(rf"{option}(?![\w-])", f"“{label}”", words)
    return re.sub(r"--column (\w+)=", r"“\1” = ", words)


def _inside(file: str, folder: Path) -> str:
    """A file's name without the place where it is kept."""
    text = str(file)
    return text.removeprefix(str(folder)).lstrip("/") or Path(text).name


def described(found: readers.Conversion) -> dict[str, Any]:
    """What the page says of recordings before they are taken in."""
    data = found.data
    return {
        "format": found.format,
        "notes": list(found.notes),
        "read": None if found.reading is None else found.reading.to_json(),
        "units": data.units,
        "metres_per_unit": data.metres_per_unit,
        "columns": list(data.columns),
        "types": list(data.types),
        "symbols": list(data.symbols),
        "scene_ids": [s.scene_id for s in data.scenes],
        "count": len(data.demonstrations),
        "judged": sum(d.valid is not None for d in data.demonstrations),
    }
