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
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np

from demospec.demonstrations import DemonstrationSet, ValidityModel, simulate_set
from demospec.errors import InputError
from demospec.files import parse_json
from demospec.progress import Progress, silent

ABLATIONS = ("full", "autoencoder", "classifier")
MODELS = (*ABLATIONS, "irl", "field")
MOST = 9
"""Most demonstrations per scene and type that a fit sees (paper: 9)."""

HELD_OUT = 9
"""Further demonstrations per scene and type, kept for measuring seen scenes."""


@dataclass(frozen=True)
class GridSettings:
    """Which fits.

    Args:
        models: Of `MODELS`; the first three are ablations of the paper's model.
        counts: Demonstrations per scene and type.
        seeds: Each draws its own set and its own initial weights.
        catalogue: Items of the scenes.
        train_scenes, test_scenes: Per seed.
        reading: ``uniform``: held-out demonstrations are drawn as the training ones, and both
            are what random paths are. ``clustered``: demonstrators repeat themselves. A
            scene's demonstrations of a type are near copies of few paths, as people's are; the
            held-out ones are near copies of the same paths.
        steps: Of the paper's model.
    """

    models: tuple[str, ...] = ("full", "autoencoder", "classifier", "irl")
    counts: tuple[int, ...] = tuple(range(1, MOST + 1))
    seeds: tuple[int, ...] = tuple(range(10))
    catalogue: str = "builtin"
    train_scenes: int = 20
    test_scenes: int = 20
    reading: Literal["uniform", "clustered"] = "uniform"
    steps: int = 300

    def __post_init__(self) -> None:
        for name in self.models:
            if name not in MODELS:
                raise InputError(", ".join(MODELS), name, field="models")
        if not all(1 <= n <= MOST for n in self.counts):
            raise InputError(f"counts from 1 to {MOST}", list(self.counts), field="counts")
        if self.reading not in ("uniform", "clustered"):
            raise InputError("uniform or clustered", self.reading, field="reading")

    def cells(self) -> Iterator[Cell]:
        """Every fit; sets change slowest, so that each is simulated once."""
        for seed in self.seeds:
            for model in self.models:
                for n in self.counts:
                    yield Cell(seed, model, n)


@dataclass(frozen=True)
class Cell:
    """One fit of the grid."""

    seed: int
    model: str
    n: int


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
            from demospec.experiments._stacked_grid import fit_stacked

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
    from functools import partial

    from demospec.parallel import iterate_tasks

    work = partial(fit_cells, settings, precision=precision)
    yield from iterate_tasks(work, jobs, workers=workers, cluster=cluster)


def fit_cells(
    settings: GridSettings, cells: Sequence[Cell], precision: str = "float32"
) -> list[dict[str, Any]]:
    """Fits and scores some cells of one seed; one line each."""
    from demospec.experiments._split import PicturesOnly
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


def scored(
    cell: Cell,
    model: ValidityModel,
    held_out: DemonstrationSet,
    test: DemonstrationSet,
    truth: Any,
    about: dict[str, Any],
) -> dict[str, Any]:
    """The line of a fit: what is said about it, and its scores on seen and unseen scenes."""
    from demospec.specification import evaluate

    began = time.process_time()
    seen = evaluate(model, held_out, truth=truth).to_json()["types"]
    unseen = evaluate(model, test, truth=truth).to_json()["types"]
    line: dict[str, Any] = {
        **asdict(cell),
        **about,
        "score_seconds": round(time.process_time() - began, 3),
        "types": {},
    }
    for type_ in seen:
        line["types"][type_] = {"seen": seen[type_], "unseen": unseen.get(type_)}
    return line


def _fitted(
    fit_model: Any, cell: Cell, data: DemonstrationSet, settings: GridSettings, precision: str
) -> Any:
    if cell.model not in ABLATIONS:
        return fit_model(data, cell.model, seed=cell.seed)
    return fit_model(
        data, "paper", seed=cell.seed, ablation=cell.model, steps=settings.steps,
        precision=precision,
    )  # fmt: skip


# Jobs of one seed follow each other: the set that a process has just simulated is the next one's.
@lru_cache(maxsize=1)
def grid_set(settings: GridSettings, seed: int) -> tuple[DemonstrationSet, Any]:
    """The set of one seed, and its truth as a model. `MOST + HELD_OUT` demonstrations each."""
    from demospec.rules import rules_from_document

    data, document = simulate_set(
        catalogue=settings.catalogue,
        train_scenes=settings.train_scenes,
        test_scenes=settings.test_scenes,
        demonstrations=MOST + HELD_OUT,
        seed=seed,
    )
    truth = rules_from_document(document)
    if settings.reading == "clustered":
        data = clustered(data, truth, np.random.default_rng([seed, 11]))
    return data, truth


def clustered(
    data: DemonstrationSet,
    truth: Any,
    rng: np.random.Generator,
    *,
    habits: int = 3,
    spread_px: float = 6.0,
) -> DemonstrationSet:
    """The same scenes with demonstrators of few habits: near copies of `habits` paths a scene.

    Each demonstration of a scene and type is one of its first `habits` paths, the control point
    moved by a normal step of `spread_px` (at 100 px pictures); labels are the truth's.
    """
    from dataclasses import replace

    from demospec.demonstrations import Demonstration, Demonstrations, bezier_points, fit_bezier

    d = data.demonstrations
    items: list[Demonstration] = []
    for scene_id, rows in data.rows_by_scene().items():
        scene = data.scene(scene_id)
        width = scene.size_px[0] if scene.size_px is not None else 100
        view = truth.see(scene)
        for type_ in data.types:
            mine = [int(i) for i in rows if d.type[i] == type_]
            if not mine:
                continue
            centres = [fit_bezier(p)[0] for p in d.paths_xy(mine[:habits])]
            pick = rng.integers(len(centres), size=len(mine))
            step = rng.normal(0.0, spread_px * width / 100, (len(mine), 2))
            control = (np.array(centres)[pick] + step)[:, None]
            start = np.tile(np.asarray(scene.start[:2]), (len(mine), 1))
            paths = bezier_points(start, np.asarray(scene.goal[:2]), control, 100)
            valid = view.p_valid(paths, type_) > 0.5
            items += [
                Demonstration(d.demo_id[i], scene_id, path, type_, d.demonstrator[i], bool(v))
                for i, path, v in zip(mine, paths, valid, strict=True)
            ]
    return replace(data, demonstrations=Demonstrations.of(items))


def rank_in_scene(data: DemonstrationSet) -> np.ndarray:
    """(n,) how many demonstrations of the same scene and type come before each."""
    seen: dict[tuple[str, str | None], int] = {}
    out = np.empty(len(data.demonstrations), dtype=np.int64)
    pairs = zip(data.demonstrations.scene_id, data.demonstrations.type, strict=True)
    for i, key in enumerate(pairs):
        out[i] = seen.get(key, 0)
        seen[key] = int(out[i]) + 1
    return out


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
