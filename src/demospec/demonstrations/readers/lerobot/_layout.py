"""Where LeRobot keeps its episodes: layouts v2 (a file an episode) and v3 (several a file).

v3: ``meta/episodes/chunk-*/file-*.parquet`` (``episode_index``, ``tasks``, ``length``,
``data/chunk_index``, ``data/file_index``, ``videos/KEY/chunk_index``, ``videos/KEY/file_index``,
``videos/KEY/from_timestamp``), ``data/chunk-*/file-*.parquet``. v2: ``meta/episodes.jsonl``
(``episode_index``, ``tasks``, ``length``), ``data/chunk-*/episode_*.parquet``, a video an episode.

Source: the format's own descriptions, "LeRobotDataset v2.1" and "v3.0" (huggingface.co, lerobot).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from demospec.demonstrations._table import opened_parquet, parquet_faults
from demospec.errors import InputError
from demospec.files import parse_json, read_bytes

_DATA_3 = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_VIDEO_3 = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
_DATA_2 = "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet"
_VIDEO_2 = "videos/chunk-{episode_chunk:03d}/{video_key}/episode_{episode_index:06d}.mp4"


@dataclass(frozen=True)
class Video:
    """Where an episode begins in a video."""

    file: Path
    seconds: float


@dataclass(frozen=True)
class Episode:
    """One episode, and where its frames are.

    Args:
        index: Its number.
        data: The Parquet file with its frames.
        length: Number of frames that the dataset states, or None.
        tasks: What it was about.
        fields: Everything else that its metadata say in one word or number.
        videos: Camera → where its frames are, where they are in a video.
    """

    index: int
    data: Path
    length: int | None
    tasks: tuple[str, ...]
    fields: dict[str, Any] = field(default_factory=dict)
    videos: dict[str, Video] = field(default_factory=dict)


def episodes_of(root: Path, info: dict[str, Any], cameras: tuple[str, ...]) -> list[Episode]:
    """The episodes of a dataset, in order.

    Args:
        root: The dataset.
        info: ``meta/info.json``.
        cameras: Features whose frames are in videos.

    Raises:
        InputError: A version that is not v2 or v3, metadata that are missing or broken.
    """
    version = info.get("codebase_version")
    text = version if isinstance(version, str) else ""
    if text.startswith("v3."):
        found = _version_3(root, info, cameras)
    elif text.startswith("v2."):
        found = _version_2(root, info, cameras)
    else:
        expected = "v2.x or v3.x (LeRobot's own converter brings older sets there)"
        raise InputError(expected, version, file=root / "meta" / "info.json",
                         field="codebase_version")  # fmt: skip
    if not found:
        raise InputError("at least one episode", "none", file=root / "meta")
    return sorted(found, key=lambda episode: episode.index)


def _version_3(root: Path, info: dict[str, Any], cameras: tuple[str, ...]) -> list[Episode]:
    folder = root / "meta" / "episodes"
    files = sorted(folder.glob("chunk-*/file-*.parquet"))
    if not files:
        raise InputError("chunk-*/file-*.parquet", "none", file=folder)
    needed = ("episode_index", "data/chunk_index", "data/file_index")
    rows: list[dict[str, Any]] = []
    for file in files:
        with opened_parquet(file) as parquet, parquet_faults(file):
            wanted = [n for n in parquet.schema_arrow.names if not n.startswith("stats/")]
            for name in needed:
                if name not in wanted:
                    found = ", ".join(wanted) or "none"
                    raise InputError(f"a column {name}", found, file=file, field=name)
            rows += parquet.read(columns=wanted).to_pylist()
    out = []
    for row, entry in enumerate(rows):
        for name in needed:
            if not isinstance(entry.get(name), int):
                raise InputError("a whole number", entry.get(name), file=folder, row=row,
                                 field=name)  # fmt: skip
        place = {"chunk_index": entry[needed[1]], "file_index": entry[needed[2]]}
        videos = {}
        for camera in cameras:
            numbers = {}
            for name in ("chunk_index", "file_index", "from_timestamp"):
                value = entry.get(f"videos/{camera}/{name}")
                if not isinstance(value, (int, float)):
                    raise InputError("a number", value, file=folder,
                                     row=f"episode {entry['episode_index']}",
                                     field=f"videos/{camera}/{name}")  # fmt: skip
                numbers[name] = value
            seconds = float(numbers.pop("from_timestamp"))
            video = _formatted(info.get("video_path"), _VIDEO_3, root, video_key=camera, **numbers)
            videos[camera] = Video(video, seconds)
        data = _formatted(info.get("data_path"), _DATA_3, root, **place)
        out.append(_episode(entry, data, videos))
    return out


def _version_2(root: Path, info: dict[str, Any], cameras: tuple[str, ...]) -> list[Episode]:
    file = root / "meta" / "episodes.jsonl"
    size = info.get("chunks_size", 1000)
    if not isinstance(size, int) or size < 1:
        raise InputError("a whole number of at least 1", size, file=root / "meta" / "info.json",
                         field="chunks_size")  # fmt: skip
    out = []
    for row, line in enumerate(read_bytes(file).splitlines()):
        if not line.strip():
            continue
        entry = parse_json(line, file=file, row=row)
        index = entry.get("episode_index") if isinstance(entry, dict) else None
        if not isinstance(index, int) or index < 0:
            raise InputError("a whole number", index, file=file, row=row, field="episode_index")
        place = {"episode_chunk": index // size, "episode_index": index}
        videos = {
            camera: Video(
                _formatted(info.get("video_path"), _VIDEO_2, root, video_key=camera, **place), 0.0
            )
            for camera in cameras
        }
        data = _formatted(info.get("data_path"), _DATA_2, root, **place)
        out.append(_episode(entry, data, videos))
    return out


def _episode(entry: dict[str, Any], data: Path, videos: dict[str, Video]) -> Episode:
    tasks = entry.get("tasks") or []
    length = entry.get("length")
    return Episode(
        int(entry["episode_index"]),
        data,
        length if isinstance(length, int) else None,
        tuple(map(str, tasks if isinstance(tasks, list) else [tasks])),
        {
            name: value
            for name, value in entry.items()
            if isinstance(value, (str, int, float, bool)) and "/" not in name
        },
        videos,
    )


def _formatted(template: object, default: str, root: Path, **values: Any) -> Path:
    """A path from a template of ``info.json``, inside the dataset."""
    try:
        name = str(template or default).format(**values)
    except (KeyError, IndexError, ValueError, AttributeError) as error:
        raise InputError(f"a path template of {', '.join(values)}", str(template),
                         file=root / "meta" / "info.json") from error  # fmt: skip
    file = root / name
    if not file.resolve().is_relative_to(root.resolve()):
        raise InputError("a path inside the dataset", name, file=root / "meta" / "info.json")
    return file
