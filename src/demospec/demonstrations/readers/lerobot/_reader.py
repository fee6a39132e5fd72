"""LeRobot datasets: one demonstration an episode, pictures from tables or videos.

A dataset holds ``meta/info.json`` (``codebase_version``, ``fps``, ``features``, ``data_path``,
``video_path``, ``splits``), metadata of its episodes, and Parquet files with a row a frame:
``timestamp``, ``frame_index``, ``episode_index``, ``index``, ``task_index``, and a column for each
feature that is no video.
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
    chosen_camera,
    path_array,
)
from demospec.demonstrations.readers._video import decoded, frame_at
from demospec.demonstrations.readers.lerobot._layout import Episode, episodes_of
from demospec.errors import InputError
from demospec.files import read_json
from demospec.progress import Progress
from demospec.scene import Picture

_PATHS = ("observation.state", "observation.ee_pose", "observation.eef_pos", "action")
_PICTURES = ("image", "video")


def read_lerobot(path: Path, mapping: Mapping, progress: Progress, pictures: Pictures) -> Source:
    """A LeRobot dataset of layout v2 or v3; one demonstration an episode.

    The path is the feature `mapping.path` (default ``observation.state``); the scene of an
    episode is its own first frame from the camera `mapping.picture` (its whole name, or its last
    part where only one camera has it), or one scene for all without. Columns of the episode's
    metadata and scalar features are fields; features of language are not read.

    Raises:
        InputError: Another version, a feature or file that is not there, a broken file.
        MissingExtraError: Frames are in a video and PyAV is not installed.
    """
    info_file = path / "meta" / "info.json"
    info = read_json(info_file)
    if not isinstance(info, dict):
        raise InputError("an object", type(info).__name__, file=info_file)
    features = info.get("features")
    if not isinstance(features, dict) or not all(isinstance(f, dict) for f in features.values()):
        raise InputError("an object of features", features, file=info_file, field="features")
    videos = tuple(k for k, f in features.items() if f.get("dtype") == "video")
    cameras = tuple(k for k, f in features.items() if f.get("dtype") in _PICTURES)
    camera = chosen_camera(mapping.picture, cameras)
    camera = camera if camera in cameras else None
    episodes = episodes_of(path, info, tuple(c for c in videos if c == camera))
    key = _path_feature(features, mapping, info_file)
    source = Source("lerobot", units="m", name=path.name, cameras=cameras)
    if camera is None and cameras:
        source.notes.append(f"cameras, not read: {', '.join(cameras)} (choose with --picture)")
    columns = _columns(features[key], key)
    splits = _splits(info.get("splits"))
    tables = _Tables(features, key)
    for i, episode in enumerate(episodes):
        recording = _episode_rows(tables.of(episode), key, columns, episode)
        if camera is not None:
            name = f"episode-{episode.index}"
            source.scenes[name] = RawScene(
                name, load=_loader(camera, episode, pictures), split=splits(episode.index)
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
    elif isinstance(names, dict) and all(isinstance(v, int) for v in names.values()):
        names = sorted(names, key=names.__getitem__)  # {"x": 0, "y": 1}
    shape = feature.get("shape")
    width = shape[0] if isinstance(shape, (list, tuple)) and shape else 0
    words = [n for n in names if isinstance(n, str)] if isinstance(names, list) else []
    if words == names and len(words) == width and len(set(words)) == len(words):
        return tuple(words)
    return tuple(str(i) for i in range(width if isinstance(width, int) else 0))


class _Tables:
    """The data files, one held at a time: episodes of one file follow each other."""

    def __init__(self, features: dict[str, Any], key: str) -> None:
        self.features = features
        self.key = key
        self.file: Path | None = None
        self.table: Any = None

    def of(self, episode: Episode) -> Any:
        """The file of an episode: its path, and its columns of one number or word a frame."""
        file = episode.data
        if file != self.file:
            with opened_parquet(file) as parquet, parquet_faults(file):
                schema = parquet.schema_arrow
                names = [n for n in schema.names if n == self.key or self._is_field(n, schema)]
                for name in ("episode_index", self.key):
                    if name not in names:
                        found = ", ".join(schema.names) or "none"
                        raise InputError(f"a column {name}", found, file=file, field=name)
                self.table = parquet.read(columns=names)
            self.file = file
        return self.table

    def _is_field(self, name: str, schema: Any) -> bool:
        kind = str(schema.field(name).type)
        stated = self.features.get(name, {}).get("dtype")
        if stated in _PICTURES or stated == "language" or name.startswith("language_"):
            return False
        return kind in ("bool", "string") or kind.startswith(("int", "uint", "float", "double"))


def _episode_rows(table: Any, key: str, columns: tuple[str, ...], episode: Episode) -> Recording:
    import pyarrow.compute as pc

    file, row = episode.data, f"episode {episode.index}"
    part = table.filter(pc.equal(table["episode_index"], episode.index))
    if not len(part):
        raise InputError("frames of this episode", "none", file=file, row=row)
    if episode.length is not None and episode.length != len(part):
        raise InputError(f"{episode.length} frames", len(part), file=file, row=row, field="length")
    try:
        values = np.array(part[key].to_pylist(), dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError("lists of numbers of one length", str(part[key].type), file=file, row=row,
                         field=key) from error  # fmt: skip
    points = path_array(values, file=file, name=key)
    if len(columns) != points.shape[1]:
        columns = tuple(str(i) for i in range(points.shape[1]))
    fields: dict[str, Any] = {"task": ", ".join(episode.tasks) or None, **episode.fields}
    for name in part.column_names:
        if name != key:
            fields[name] = np.array(part[name].combine_chunks().to_pylist())
    t = fields.get("timestamp")
    numeric = isinstance(t, np.ndarray) and t.dtype.kind in "iuf"
    return Recording(
        f"episode-{episode.index}",
        points,
        columns,
        t=np.asarray(t, dtype=np.float64) if numeric else None,
        fields=fields,
        file=file,
        row=row,
    )


def _loader(camera: str, episode: Episode, pictures: Pictures) -> Any:
    name = f"episode-{episode.index}"
    video = episode.videos.get(camera)

    def from_video() -> Picture:
        assert video is not None
        return pictures.keep(name, frame_at(video.file, video.seconds))

    def from_table() -> Picture:
        file = episode.data
        with opened_parquet(file) as parquet, parquet_faults(file):
            if camera not in parquet.schema_arrow.names:
                raise InputError(f"a column {camera}", "none", file=file, field=camera)
            for batch in parquet.iter_batches(batch_size=16, columns=["episode_index", camera]):
                for row in batch.to_pylist():
                    if row["episode_index"] == episode.index:
                        return _embedded(row[camera])
        raise InputError("a frame of this episode", "none", file=file, row=name)

    def _embedded(cell: Any) -> Picture:
        data = cell.get("bytes") if isinstance(cell, dict) else cell
        if not isinstance(data, bytes):
            raise InputError("a PNG or JPEG picture", type(data).__name__, file=episode.data,
                             row=name, field=camera)  # fmt: skip
        return pictures.keep(name, decoded(io.BytesIO(data), episode.data, name))

    return from_table if video is None else from_video


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
