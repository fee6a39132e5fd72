"""A model's verdicts on a large set, part by part: here, in processes, or on a cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from demospec.demonstrations import ValidityModel, cut_rows, read_part
from demospec.errors import InputError
from demospec.parallel import iterate_tasks
from demospec.progress import Progress, silent
from demospec.rules import RuleSet, rules_for_set
from demospec.specification.evaluation._predict import Predictions, predict_part
from demospec.specification.evaluation._predict_kept import KeptParts, job_of


@dataclass(frozen=True)
class _Source:
    model: str
    store: str


def predict_parts(
    model: str,
    store: str,
    *,
    rows: int = 100_000,
    workers: int = 1,
    cluster: str | None = None,
    keep: Path | None = None,
    iterate: Callable[..., Iterator[Predictions]] = iterate_tasks,
    progress: Progress = silent,
) -> Iterator[Predictions]:
    """As `predict_batches`, for a model and a set that every worker reads for itself.

    The parts are the same whatever the number of workers, and so is every bit of the answer.

    Args:
        model: Path of a model folder or rule file, seen by every worker.
        store: Folder of the set seen by every worker, or a URL (`cut_rows`).
        rows: Demonstrations of a part, ≥ 1.
        workers: Processes on this machine.
        cluster: Address of a Dask scheduler.
        keep: A folder for finished parts (of a set on disk): a run that was killed goes on
            from them. The caller removes it when all is written.
        iterate: Gives out the parts; called as `iterate_tasks`.

    Raises:
        InputError: As `read_set`; also a demonstration that is there twice.
    """
    _load(model, ())  # a fault of the model is told before anything starts
    tasks = cut_rows(store, rows=rows)
    kept = None if keep is None else KeptParts(keep, job_of(model, store, rows))
    there = set() if kept is None else kept.there
    left = [task for i, task in enumerate(tasks) if i not in there]
    fresh = iterate(
        partial(_judge, _Source(model, store)), left, workers=workers, cluster=cluster,
        progress=progress, what="judging parts",
    )  # fmt: skip
    seen: set[int] = set()
    for i in range(len(tasks)):
        part = kept.read(i) if kept is not None and i in there else next(fresh)
        if kept is not None and i not in there:
            kept.save(i, part)
        for name in dict.fromkeys(item.demo_id for item in part.items):
            if hash(name) in seen:
                raise InputError("each demonstration once", name, file=store, field="demo_id")
            seen.add(hash(name))
        yield part


def _judge(source: _Source, rows: tuple[int, int]) -> Predictions:
    data = read_part(source.store, *rows)
    model = _load(source.model, data.types)
    if isinstance(model, RuleSet):
        model = rules_for_set(model, data)
    return predict_part(model, data)


@lru_cache(maxsize=2)
def _load(model: str, types: tuple[str, ...]) -> ValidityModel:
    from demospec.specification import load_model

    loaded: Any = load_model(model, types)
    return loaded  # type: ignore[no-any-return]
