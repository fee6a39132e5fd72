"""A run folder made of stages that are computed once and found again.

Every stage writes one artefact (a file or a folder) and is recorded in ``run.json`` with a key
made of its settings and of the stages before it. A run that is started again computes only
what is missing or what has changed; an interrupted stage leaves nothing behind.
"""

from __future__ import annotations

import hashlib
import json
import platform
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import metadata, resources
from pathlib import Path
from typing import Any

from demospec.errors import InputError
from demospec.files import read_json, write_json
from demospec.progress import Progress, silent


@dataclass(frozen=True)
class Stage:
    """One step of a run.

    Args:
        name: Also the name of its artefact in the run folder.
        make: Writes the artefact; called with the run folder and a progress callback.
        title: For people.
        settings: What its result depends on, besides the stages before it.
        needs: Names of the stages it reads.
        weight: About how much of the run's time it takes, in any unit, > 0.
    """

    name: str
    title: str
    make: Callable[[Path, Progress], None]
    settings: Mapping[str, Any] = field(default_factory=dict)
    needs: tuple[str, ...] = ()
    weight: float = 1.0


@dataclass(frozen=True)
class RunRecord:
    """What happened: seconds by stage, 0.0 and ``cached`` where nothing had to be done."""

    folder: Path
    seconds: Mapping[str, float]
    cached: tuple[str, ...]


def run_stages(
    folder: Path,
    stages: tuple[Stage, ...],
    *,
    command: str,
    seed: int,
    progress: Progress = silent,
    versions: tuple[str, ...] = ("demospec", "numpy", "scipy", "ortools", "torch"),
) -> RunRecord:
    """Computes the stages that are missing or stale, in order.

    Raises:
        InputError: `folder` is not empty and holds no run of ours.
    """
    absent = not folder.exists()
    record = _open_record(folder)
    try:
        return _compute(folder, record, stages, command, seed, progress, versions)
    finally:
        if absent and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()  # the first stage was refused: nothing of ours stays behind


def _compute(
    folder: Path,
    record: dict[str, Any],
    stages: tuple[Stage, ...],
    command: str,
    seed: int,
    progress: Progress,
    versions: tuple[str, ...],
) -> RunRecord:
    record.update(
        command=command,
        seed=seed,
        python=platform.python_version(),
        machine=f"{platform.machine()}, {platform.system()}",
        versions={name: _version(name) for name in versions},
    )
    done: dict[str, Any] = record.setdefault("stages", {})
    keys: dict[str, str] = {}
    for stage in stages:
        keys[stage.name] = _key(stage, record["versions"]["demospec"], keys)
    cached = [
        s.name
        for s in stages
        if done.get(s.name, {}).get("key") == keys[s.name] and (folder / s.name).exists()
    ]
    seconds = dict.fromkeys(keys, 0.0)
    whole = _WholeRun(progress, sum(s.weight for s in stages if s.name not in cached))
    for stage in stages:
        if stage.name in cached:
            continue
        began = time.perf_counter()
        with whole.stage(stage.weight) as told:
            stage.make(folder, told)
        seconds[stage.name] = took = time.perf_counter() - began
        entry = {"key": keys[stage.name], "seconds": round(took, 2), "title": stage.title}
        done[stage.name] = entry
        write_json(folder / "run.json", record)
    return RunRecord(folder, seconds, tuple(cached))


class _WholeRun:
    """Tells beside a stage's own progress how much of all that is left to do is done."""

    def __init__(self, progress: Progress, total: float) -> None:
        self.progress = progress
        self.total = total
        self.before = 0.0

    @contextmanager
    def stage(self, weight: float) -> Iterator[Progress]:
        """A progress callback for one stage, which ends with all that it was told of done."""
        totals: dict[str, float] = {}
        first: dict[str, float] = {}
        furthest = 0.0

        def told(what: str, done: float, total: float) -> None:
            nonlocal furthest
            self.progress(what, done, total)
            totals[what] = total
            # What an earlier run left done says nothing of this one's speed.
            start = first.setdefault(what, done)
            if total > start:
                furthest = max(furthest, (done - start) / (total - start))
                self._tell(self.before + weight * min(furthest, 1.0))

        self._tell(self.before)
        yield told
        for what, total in totals.items():
            self.progress(what, total, total)
        self.before += weight
        self._tell(self.before)

    def _tell(self, done: float) -> None:
        self.progress("all stages", done, self.total)


def code_key(*packages: str) -> str:
    """A hash of the source of some packages, for the settings of a stage that draws with them.

    A page is cheap to write again and its words live in the code: a change there renews it,
    while fits stay until the version changes.
    """
    digest = hashlib.sha256()
    for package in packages:
        root = Path(str(resources.files(package)))
        for file in sorted(p for p in root.rglob("*") if p.suffix in (".py", ".j2")):
            digest.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def _open_record(folder: Path) -> dict[str, Any]:
    file = folder / "run.json"
    if file.is_file():
        record = read_json(file)
        if not isinstance(record, dict) or record.get("format") != "demospec-run":
            raise InputError("a run of demospec", "something else", file=file)
        return record
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError("a new or empty folder, or an earlier run", "other files", file=folder)
    folder.mkdir(parents=True, exist_ok=True)
    return {"format": "demospec-run", "version": 1}


def _key(stage: Stage, version: str, keys: Mapping[str, str]) -> str:
    content = {
        "name": stage.name,
        "settings": dict(stage.settings),
        "needs": {name: keys[name] for name in stage.needs},
        "version": version,
    }
    text = json.dumps(content, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"
