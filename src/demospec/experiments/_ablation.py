"""The paper's ablation grid: models × demonstrations per scene × seeds, one line per fit.

A grid is a list of `Cell`s. Finished ones are lines of a JSON-lines file: a run that was cut
off goes on where it stopped. All types of a cell share one fit (encoder and decoder see the
same pictures whatever the type), so that 3 types × 3 ablations × 9 × 10 seeds are 270 fits.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.experiments._cells import (
    ABLATIONS,
    MOST,
    Cell,
    GridSettings,
    grid_set,
    rank_in_scene,
    scored,
)
from demospec.experiments._split import PicturesOnly
from demospec.experiments._stacked_grid import fit_stacked
from demospec.files import parse_json
from demospec.parallel import iterate_tasks
from demospec.progress import Progress, silent


def run_grid(
    file: Path,
    settings: GridSettings | None = None,
    *,
    workers: int = 1,
    cluster: str | None = None,
    device: str = "cpu",
    precision: str = "float32",
    stack: int | None = None,
    progress: Progress = silent,
) -> list[dict[str, Any]]:
    """Runs the fits that `file` does not hold yet, and returns all of the grid.

    Args:
        file: JSON lines, appended to as fits finish. Its first line holds the settings.
        workers: Processes; each uses one thread.
        cluster: Address of a Dask scheduler instead.
        device: Where the paper's models are trained: other than ``cpu``, in stacks in this
            process, as many as its memory holds, while scores and other models stay with the
            workers. A line then names device, precision and size of its stack.
        precision: As of `PaperSettings`.
        stack: Members of a stack; with it, a CPU stacks as well.

    Raises:
        InputError: No such device; the file belongs to other settings, or is damaged in the middle.
    """
    settings = settings or GridSettings()
    if device != "cpu" or precision != "float32":
        from demospec.specification import check_device

        check_device(device, precision)
    done = _finished(file, settings)
    left = [cell for cell in settings.cells() if cell not in done]
    at_once = device != "cpu" or stack is not None
    stacked = [cell for cell in left if at_once and cell.model in ABLATIONS]
    others = [cell for cell in left if cell not in set(stacked)]
    jobs: list[list[Cell]] = []
    for seed in settings.seeds:
        mine = [cell for cell in others if cell.seed == seed]
        # One job holds at most a handful of fits: the file grows steadily and little is lost.
        jobs += [mine[i : i + 3] for i in range(0, len(mine), 3)]
    found, total = len(done), len(done) + len(left)
    fitted = scored_fits = 0.0

    def show() -> None:
        # Half a fit is its training, half its scores: the bar moves while a stack is trained.
        half = (scored_fits + max(scored_fits, fitted)) / 2
        progress("fitting the grid", found + half, total)

    def trained(fits: float) -> None:
        nonlocal fitted
        fitted = fits
        show()

    show()

    def finished() -> Iterator[list[dict[str, Any]]]:
        if stacked:
            yield from fit_stacked(
                settings, stacked, device=device, precision=precision, most=stack,
                workers=workers, cluster=cluster, trained=trained,
            )  # fmt: skip
        yield from _run(jobs, settings, workers, cluster, precision)

    for lines in finished():
        _append(file, lines)
        for line in lines:
            done[Cell(line["seed"], line["model"], line["n"])] = line
        scored_fits += len(lines)
        show()
    return [done[cell] for cell in settings.cells()]


def _run(
    jobs: Sequence[list[Cell]],
    settings: GridSettings,
    workers: int,
    cluster: str | None,
    precision: str,
) -> Iterator[list[dict[str, Any]]]:
    work = partial(fit_cells, settings, precision=precision)
    yield from iterate_tasks(work, jobs, workers=workers, cluster=cluster)


def fit_cells(
    settings: GridSettings, cells: Sequence[Cell], precision: str = "float32"
) -> list[dict[str, Any]]:
    """Fits and scores some cells of one seed; one line each."""
    from demospec.specification import fit_model

    seed = cells[0].seed
    data, truth = grid_set(settings, seed)
    train, test = data.of_split("train"), data.of_split("test")
    rank = rank_in_scene(train)
    held_out = train.select(rank >= MOST)
    lines = []
    for cell in cells:
        began = time.process_time()
        model = _fitted(fit_model, cell, train.select(rank < cell.n), settings, precision)
        about: dict[str, Any] = {"fit_seconds": round(time.process_time() - began, 3)}
        if precision != "float32" and cell.model in ABLATIONS:
            about["precision"] = precision
        if cell.model == "field":  # it would read the lists of objects: let it see for itself
            model = PicturesOnly(model)
        lines.append(scored(cell, model, held_out, test, truth, about))
    return lines


def _fitted(
    fit_model: Any, cell: Cell, data: DemonstrationSet, settings: GridSettings, precision: str
) -> Any:
    if cell.model not in ABLATIONS:
        return fit_model(data, cell.model, seed=cell.seed)
    return fit_model(
        data, "paper", seed=cell.seed, ablation=cell.model, steps=settings.steps,
        precision=precision,
    )  # fmt: skip


def _finished(file: Path, settings: GridSettings) -> dict[Cell, dict[str, Any]]:
    """Finished fits by cell. A last line that was cut off while written is dropped."""
    if not file.exists():
        _append(file, [{"settings": _about(settings)}])
        return {}
    raw = file.read_bytes()
    whole = raw[: raw.rfind(b"\n") + 1]
    if whole != raw:
        os.truncate(file, len(whole))
    lines = [parse_json(line, file=file, row=i) for i, line in enumerate(whole.splitlines())]
    if not lines:
        _append(file, [{"settings": _about(settings)}])
        return {}
    if lines[0].get("settings") != _about(settings):
        raise InputError(
            "a grid file of the same settings", lines[0].get("settings"), file=file, row=0
        )
    wanted = set(settings.cells())
    done = {Cell(line["seed"], line["model"], line["n"]): line for line in lines[1:]}
    return {cell: line for cell, line in done.items() if cell in wanted}


def _about(settings: GridSettings) -> dict[str, Any]:
    """What every fit of a file has in common (models, counts and seeds may grow)."""
    about = asdict(settings)
    return {k: v for k, v in about.items() if k not in ("models", "counts", "seeds")}


def _append(file: Path, lines: Sequence[dict[str, Any]]) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    text = "".join(json.dumps(line, allow_nan=False) + "\n" for line in lines)
    with file.open("a", encoding="utf-8") as stream:
        stream.write(text)
        stream.flush()
        os.fsync(stream.fileno())
