"""LeRobot datasets, layout v3.0: Parquet with several episodes a file, meta, pictures or video.

Layout: ``meta/info.json`` (``codebase_version``, ``fps``, ``features``, ``data_path``,
``video_path``, ``splits``), ``meta/tasks.parquet``, ``meta/episodes/chunk-*/file-*.parquet``
(``episode_index``, ``tasks``, ``length``, ``data/chunk_index``, ``data/file_index``,
``videos/KEY/chunk_index``, ``videos/KEY/file_index``, ``videos/KEY/from_timestamp``),
``data/chunk-*/file-*.parquet`` (``timestamp``, ``frame_index``, ``episode_index``, ``index``,
``task_index``, and a column for each feature that is no video).

Source: the format's own description, "LeRobotDataset v3.0" (huggingface.co/blog, lerobot).
"""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations._table import opened_parquet, parquet_faults
from demospec.demonstrations.readers._mapping import Mapping
from demospec.demonstrations.readers._recording import (
    Pictures,
    RawScene,
    Recording,
    Source,
    path_array,
)
from demospec.demonstrations.readers._video import decoded, frame_at
from demospec.errors import InputError
from demospec.files import read_json
from demospec.progress import Progress
from demospec.scene import Picture

_DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_VIDEO = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
_PATHS = ("observation.state", "observation.ee_pose", "observation.eef_pos", "action")


def read_lerobot(path: Path, mapping: Mapping, progress: Progress, pictures: Pictures) -> Source:
    """A LeRobot v3 dataset; one demonstration an episode.

    The path is the feature `mapping.path` (default ``observation.state``); the scene of an
    episode is its own first frame from the camera `mapping.picture`, or one scene for all
    without. Columns of the episode's metadata and scalar features are fields.

    Raises:
        InputError: Another version, a feature or file that is not there, a broken file.
        MissingExtraError: Frames are in a video and PyAV is not installed.
    """
    info_file = path / "meta" / "info.json"
    info = read_json(info_file)
    version = info.get("codebase_version") if isinstance(info, dict) else None
    if not isinstance(version, str) or not version.startswith("v3."):
        expected = "v3.x (LeRobot's own converter brings older sets there)"
        raise InputError(expected, version, file=info_file, field="codebase_version")
    features = info.get("features")
    if not isinstance(features, dict) or not all(isinstance(f, dict) for f in features.values()):
        raise InputError("an object of features", features, file=info_file, field="features")
    key = _path_feature(features, mapping, info_file)
    source = Source("lerobot", units="m", name=path.name)
    cameras = tuple(k for k, f in features.items() if f.get("dtype") in ("image", "video"))
    source.cameras = cameras
    camera = mapping.picture if mapping.picture in cameras else None
    if camera is None and cameras:
        source.notes.append(f"cameras, not read: {', '.join(cameras)} (choose with --picture)")
    episodes = _episodes(path)
    columns = _columns(features[key], key)
    splits = _splits(info.get("splits"))
    tables = _Tables(path, info, features, key)
    for i, episode in enumerate(episodes):
        file, table = tables.of(episode)
        index = int(episode["episode_index"])
        recording = _episode_rows(table, file, index, key, columns, episode)
        if camera is not None:
            name = f"episode-{episode['episode_index']}"
            source.scenes[name] = RawScene(
                name,
                load=_loader(path, info, features, camera, episode, (file, index), pictures),
                split=splits(index),
            )
            recording = replace(recording, scene=name)
        source.recordings.append(recording)
        progress("read", i + 1, len(episodes))
    source.notes.append(f"read: {len(source.recordings)} episodes, path {key}")
    return source


def _path_feature(features: dict[str, Any], mapping: Mapping, file: Path) -> str:
    if mapping.path is not None:
        if mapping.path not in features:
            known = ", ".join(features)
            raise InputError(f"a feature {mapping.path}", known, file=file, field="path")
        return mapping.path
    for name in _PATHS:
        if name in features:
            return name
    expected = "a feature for the path; say which: --path NAME"
    raise InputError(expected, ", ".join(features), file=file, field="features")


def _columns(feature: dict[str, Any], key: str) -> tuple[str, ...]:
    names = feature.get("names")
    if isinstance(names, dict) and len(names) == 1:  # {"motors": [...]}
        names = next(iter(names.values()))
    shape = feature.get("shape")
    width = shape[0] if isinstance(shape, (list, tuple)) and shape else 0
    words = [n for n in names if isinstance(n, str)] if isinstance(names, list) else []
    if words == names and len(words) == width and len(set(words)) == len(words):
        return tuple(words)
    return tuple(str(i) for i in range(width if isinstance(width, int) else 0))


def _episodes(path: Path) -> list[dict[str, Any]]:
    folder = path / "meta" / "episodes"
    files = sorted(folder.glob("chunk-*/file-*.parquet"))
    if not files:
        raise InputError("chunk-*/file-*.parquet", "none", file=folder)
    rows: list[dict[str, Any]] = []
    for file in files:
        with opened_parquet(file) as parquet, parquet_faults(file):
            wanted = [n for n in parquet.schema_arrow.names if not n.startswith("stats/")]
            rows += parquet.read(columns=wanted).to_pylist()
        for name in ("episode_index", "data/chunk_index", "data/file_index"):
            if name not in wanted:
                found = ", ".join(wanted) or "none"
                raise InputError(f"a column {name}", found, file=file, field=name)
    for row, episode in enumerate(rows):
        for name in ("episode_index", "data/chunk_index", "data/file_index"):
            if not isinstance(episode.get(name), int):
                raise InputError("a whole number", episode.get(name), file=folder, row=row,
                                 field=name)  # fmt: skip
    return sorted(rows, key=lambda episode: int(episode["episode_index"]))


def _formatted(template: object, default: str, root: Path, **values: Any) -> Path:
    """A path from a template of ``info.json``, inside the dataset."""
    try:
        name = str(template or default).format(**values)
    except (KeyError, IndexError, ValueError, AttributeError) as error:
        raise InputError("a path template of LeRobot v3", str(template),
                         file=root / "meta" / "info.json") from error  # fmt: skip
    file = root / name
    if not file.resolve().is_relative_to(root.resolve()):
        raise InputError("a path inside the dataset", name, file=root / "meta" / "info.json")
    return file


class _Tables:
    """The data files, one held at a time: episodes of one file follow each other."""

    def __init__(
        self, root: Path, info: dict[str, Any], features: dict[str, Any], key: str
    ) -> None:
        self.root = root
        self.template = info.get("data_path")
        self.pictures = {k for k, f in features.items() if f.get("dtype") in ("image", "video")}
        self.key = key
        self.file: Path | None = None
        self.table: Any = None

    def of(self, episode: dict[str, Any]) -> tuple[Path, Any]:
        """The file of an episode, and its columns without pictures."""
        chunk, number = episode["data/chunk_index"], episode["data/file_index"]
        file = _formatted(self.template, _DATA, self.root, chunk_index=chunk, file_index=number)
        if file != self.file:
            with opened_parquet(file) as parquet, parquet_faults(file):
                names = [n for n in parquet.schema_arrow.names if n not in self.pictures]
                for name in ("episode_index", self.key):
                    if name not in names:
                        found = ", ".join(names) or "none"
                        raise InputError(f"a column {name}", found, file=file, field=name)
                self.table = parquet.read(columns=names)
            self.file = file
        return file, self.table


def _episode_rows(
    table: Any, file: Path, index: int, key: str, columns: tuple[str, ...], episode: dict[str, Any]
) -> Recording:
    import pyarrow.compute as pc

    row = f"episode {index}"
    part = table.filter(pc.equal(table["episode_index"], index))
    if not len(part):
        raise InputError("frames of this episode", "none", file=file, row=row)
    length = episode.get("length")
    if isinstance(length, int) and length != len(part):
        raise InputError(f"{length} frames", len(part), file=file, row=row, field="length")
    try:
        values = np.array(part[key].to_pylist(), dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError("lists of numbers of one length", str(part[key].type), file=file, row=row,
                         field=key) from error  # fmt: skip
    points = path_array(values, file=file, name=key)
    if len(columns) != points.shape[1]:
        columns = tuple(str(i) for i in range(points.shape[1]))
    fields: dict[str, Any] = {"task": ", ".join(map(str, episode.get("tasks") or [])) or None}
    for name, value in episode.items():
        if isinstance(value, (str, int, float, bool)) and "/" not in name:
            fields[name] = value
    for name in part.column_names:
        array = part[name].combine_chunks()
        kind = str(array.type)
        if kind in ("bool", "string") or kind.startswith(("int", "uint", "float", "double")):
            fields[name] = np.array(array.to_pylist())
    t = fields.get("timestamp")
    numeric = isinstance(t, np.ndarray) and t.dtype.kind in "iuf"
    return Recording(
        f"episode-{index}",
        points,
        columns,
        t=np.asarray(t, dtype=np.float64) if numeric else None,
        fields=fields,
        file=file,
        row=row,
    )


def _loader(
    root: Path,
    info: dict[str, Any],
    features: dict[str, Any],
    camera: str,
    episode: dict[str, Any],
    frames: tuple[Path, int],
    pictures: Pictures,
) -> Any:
    index = episode["episode_index"]

    def from_video() -> Picture:
        place = f"videos/{camera}"
        for name in ("chunk_index", "file_index", "from_timestamp"):
            if not isinstance(episode.get(f"{place}/{name}"), (int, float)):
                raise InputError("a number", episode.get(f"{place}/{name}"),
                                 file=root / "meta" / "episodes", row=f"episode {index}",
                                 field=f"{place}/{name}")  # fmt: skip
        file = _formatted(
            info.get("video_path"), _VIDEO, root, video_key=camera,
            chunk_index=episode[f"{place}/chunk_index"], file_index=episode[f"{place}/file_index"],
        )  # fmt: skip
        pixels = frame_at(file, float(episode[f"{place}/from_timestamp"]))
        return pictures.keep(f"episode-{index}", pixels)

    def from_table() -> Picture:
        file, number = frames
        with opened_parquet(file) as parquet, parquet_faults(file):
            if camera not in parquet.schema_arrow.names:
                raise InputError(f"a column {camera}", "none", file=file, field=camera)
            for batch in parquet.iter_batches(batch_size=16, columns=["episode_index", camera]):
                for row in batch.to_pylist():
                    if row["episode_index"] == number:
                        return _embedded(row[camera])
        raise InputError("a frame of this episode", "none", file=file, row=f"episode {number}")

    def _embedded(cell: Any) -> Picture:
        file, number = frames
        data = cell.get("bytes") if isinstance(cell, dict) else cell
        if not isinstance(data, bytes):
            raise InputError("a PNG or JPEG picture", type(data).__name__, file=file,
                             row=f"episode {number}", field=camera)  # fmt: skip
        pixels = decoded(io.BytesIO(data), file, f"episode {number}")
        return pictures.keep(f"episode-{number}", pixels)

    return from_video if features[camera].get("dtype") == "video" else from_table


def _splits(splits: object) -> Any:
    """Episode → name of its split (``{"train": "0:40", "test": "40:50"}``), or None."""
    ranges: list[tuple[str, int, int]] = []
    for name, text in splits.items() if isinstance(splits, dict) else ():
        low, _, high = str(text).partition(":")
        if low.isdecimal() and high.isdecimal():
            ranges.append((str(name), int(low), int(high)))

    def split(episode: int) -> str | None:
        return next((name for name, low, high in ranges if low <= episode < high), None)

    return split
