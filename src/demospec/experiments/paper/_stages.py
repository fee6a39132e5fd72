"""`demospec reproduce`: the stages, top to bottom; each leaves JSON, CSV and a picture."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from demospec.errors import DemospecError
from demospec.experiments import RunRecord, Stage, code_key, run_stages
from demospec.experiments.paper._by_model import (
    MODELS,
    causes_by_model,
    model_of,
    repairs_by_model,
    set_of,
    truth_of,
)
from demospec.files import write_json
from demospec.progress import Progress, silent

READINGS = ("uniform", "clustered")

FIT_S = {"full": 10.0, "autoencoder": 10.0, "classifier": 4.0, "irl": 1.0, "field": 6.0}
"""Seconds of a fit of the grid, rounded from `benchmarks/reproduce.py`: for the time left only."""


@dataclass(frozen=True)
class ReproduceSettings:
    """How much of everything.

    Args:
        seeds: Randomisations of the accuracy grid (paper: 10).
        counts: Trajectories per scene and type.
        clustered_counts: The same for the ``clustered`` reading.
        models: Columns of the grid, for the ``uniform`` reading; ``clustered`` takes the first.
        starts: Rejected trajectories repaired per type.
        particles: Of the second repair column (the first is the paper's single one).
        demonstrations: Of each simulated participant.
        resamples: Of each cell of the heat maps.
        boundary_scenes: Scenes whose boundaries of validity are searched, and unseen ones in which
            solutions are sampled.
        rejected: Rejected demonstrations of each type asked object by object.
        identified: Demonstrators of each type whose type is to be found, for each number shown.
        samples: Solutions sampled of each type in a scene.
        catalogue: Items of the scenes.
        seed: Of all that is not a randomisation of the grid.
    """

    seeds: int = 10
    counts: tuple[int, ...] = tuple(range(1, 10))
    clustered_counts: tuple[int, ...] = tuple(range(1, 10))
    models: tuple[str, ...] = ("full", "autoencoder", "classifier", "irl", "field")
    starts: int = 200
    particles: int = 32
    demonstrations: int = 40
    resamples: int = 10
    boundary_scenes: int = 20
    rejected: int = 20
    identified: int = 200
    samples: int = 20
    catalogue: str = "builtin"
    seed: int = 0

    @classmethod
    def quick(cls, seed: int = 0) -> ReproduceSettings:
        """The same tables and figures from less: minutes."""
        return cls(
            seeds=2, counts=(1, 3, 9), clustered_counts=(1, 9), starts=40, particles=16,
            demonstrations=24, boundary_scenes=3, rejected=4, identified=50, samples=10, seed=seed,
        )  # fmt: skip


def reproduce(
    folder: Path,
    settings: ReproduceSettings | None = None,
    *,
    workers: int = 1,
    cluster: str | None = None,
    device: str = "cpu",
    precision: str = "float32",
    command: str = "demospec reproduce",
    progress: Progress = silent,
) -> RunRecord:
    """Measures every table and figure of the paper anew; resumes what an earlier run left.

    Args:
        folder: New, empty, or an earlier run.
        workers: Processes, one thread each, for the accuracy grid, repairs and causes.
        cluster: Address of a Dask scheduler for the grid instead.
        device, precision: Where and how the grid's fits of the paper's model are trained, in
            stacks where the device is no CPU (`run_grid`).

    Raises:
        InputError: `folder` holds other things, or there is no such device.
        MissingExtraError: torch is absent.
    """
    settings = settings or ReproduceSettings()
    if device != "cpu" or precision != "float32":
        from demospec.specification import check_device

        check_device(device, precision)  # before the first stage, not after an hour
    stages = reproduce_stages(settings, workers, cluster, device, precision)
    return run_stages(folder, stages, command=command, seed=settings.seed, progress=progress)


def reproduce_stages(
    s: ReproduceSettings,
    workers: int = 1,
    cluster: str | None = None,
    device: str = "cpu",
    precision: str = "float32",
) -> tuple[Stage, ...]:
    """The stages of `reproduce`, in order."""

    def simulate(folder: Path, progress: Progress) -> None:
        from demospec.demonstrations import simulate_set, write_set
        from demospec.experiments.paper._pictures import draw_items, draw_samples

        data, truth = simulate_set(
            catalogue=s.catalogue, demonstrations=9, seed=s.seed, progress=progress
        )
        write_set(data, folder / "set", replace_existing=True, documents={"truth.json": truth})
        draw_samples(data, folder / "samples.png")
        draw_items(data.symbols, s.catalogue, folder / "items.png")

    def fit(name: str) -> Callable[[Path, Progress], None]:
        def work(folder: Path, progress: Progress) -> None:
            from demospec.files import writing_folder
            from demospec.specification import fit_model

            model = fit_model(
                set_of(folder).of_split("train"), name, seed=s.seed, progress=progress
            )
            with writing_folder(folder / f"model-{name}", replace=True) as temporary:
                model.save(temporary, replace=True)

        return work

    def accuracy(reading: str) -> Callable[[Path, Progress], None]:
        models, counts = _cells(s, reading)

        def work(folder: Path, progress: Progress) -> None:
            from demospec.experiments import GridSettings, grid_table, run_grid
            from demospec.experiments.paper._pictures import draw_accuracy

            def told(what: str, done: float, total: float) -> None:
                progress(f"{what}, {reading}", done, total)

            grid = GridSettings(
                models=models,
                counts=counts,
                seeds=tuple(range(s.seeds)),
                catalogue=s.catalogue,
                reading=reading,  # type: ignore[arg-type]
            )
            lines = run_grid(
                folder / f"grid-{reading}.jsonl", grid,
                workers=workers, cluster=cluster, device=device, precision=precision,
                progress=told,
            )  # fmt: skip
            table = grid_table(lines)
            draw_accuracy(table, folder / f"accuracy-{reading}", reading)
            write_json(folder / f"accuracy-{reading}.json", {"reading": reading, "rows": table})

        return work

    def latent(folder: Path, progress: Progress) -> None:
        from demospec.experiments.paper._pictures import draw_latent
        from demospec.specification import validity_map

        data, models = set_of(folder), {n: model_of(folder, n) for n in MODELS}
        first = {"seen": "train", "unseen": "test"}
        parts = {which: data.of_split(split).scenes[0] for which, split in first.items()}
        maps: dict[str, Any] = {}
        for done, (which, scene) in enumerate(parts.items()):
            progress("validity maps", done, len(parts))
            for name, model in models.items():
                view = model.see(scene)
                for type_ in model.types:
                    maps.setdefault(which, {}).setdefault(name, {})[type_] = validity_map(
                        view, type_
                    )
        draw_latent(parts, maps, folder / "latent")
        shares = {
            which: {m: {t: round(v.valid_share, 4) for t, v in ts.items()} for m, ts in ms.items()}
            for which, ms in maps.items()
        }
        agreement = {
            which: {m: {t: _agreement(v, ms["truth"][t]) for t, v in ts.items()}
                    for m, ts in ms.items()}
            for which, ms in maps.items()
        }  # fmt: skip
        document = {"valid_share_of_the_plane": shares, "agrees_with_truth": agreement}
        write_json(folder / "latent.json", document)

    def repairs(folder: Path, progress: Progress) -> None:
        from demospec.experiments.paper._pictures import draw_repairs

        particles = (1, s.particles)
        out = repairs_by_model(folder, s.starts, particles, s.seed, workers, progress)
        for model in MODELS:
            draw_repairs(set_of(folder), out[model]["1"], folder / f"repairs-{model}.png")
        write_json(folder / "repairs.json", out)

    def causes(folder: Path, progress: Progress) -> None:
        from demospec.experiments.paper._pictures_solutions import draw_boundaries

        found = causes_by_model(folder, s.boundary_scenes, s.rejected, s.seed, workers, progress)
        draw_boundaries(set_of(folder), MODELS, folder, s.seed)
        write_json(folder / "causes.json", found)

    def solutions(folder: Path, progress: Progress) -> None:
        from demospec.experiments.paper._pictures_solutions import draw_identification
        from demospec.experiments.paper._solutions import solutions_by_model

        found = solutions_by_model(
            folder, s.identified, s.boundary_scenes, s.samples, s.seed, workers, progress
        )
        draw_identification(found, folder / "identification")
        write_json(folder / "solutions.json", found)

    def parameters(folder: Path, progress: Progress) -> None:
        from demospec.experiments.paper._participants import participants_study
        from demospec.experiments.paper._transition import transition_study
        from demospec.report import draw_transition

        document = participants_study(s.demonstrations, s.seed, progress)
        document["transition"] = transition_study(s.demonstrations, s.resamples, s.seed, progress)
        for kind in ("png", "svg"):
            draw_transition(document["transition"], folder / f"transition.{kind}")
        write_json(folder / "parameters.json", document)

    def plans(folder: Path, progress: Progress) -> None:
        from demospec.experiments import plan_study
        from demospec.experiments.paper._pictures import draw_plans
        from demospec.experiments.paper._solutions import relevant_plans
        from demospec.rules import learn_rules, rules_document

        data = set_of(folder)
        learned = learn_rules(data.of_split("train"), progress=progress)
        write_json(folder / "rules.json", rules_document(learned))
        scenes = data.of_split("test").scenes
        document = plan_study(learned, scenes, truth_of(folder), progress)
        document["relevance"] = relevant_plans(folder, learned, scenes, progress)
        draw_plans(data, learned, document, folder / "plans.png")
        write_json(folder / "plans.json", document)

    def robot(folder: Path, progress: Progress) -> None:
        progress("robot", 0, 1)
        write_json(folder / "robot.json", _execute(folder))
        progress("robot", 1, 1)

    def page(folder: Path, progress: Progress) -> None:
        from demospec.experiments.paper._page import build_page
        from demospec.experiments.paper._page_models import draw_as_printed
        from demospec.experiments.paper._tables import write_tables
        from demospec.report import write_html

        progress("writing the page", 0, 1)
        draw_as_printed(folder)
        write_tables(folder)
        write_html(build_page(folder, s), folder / "reproduction.html")
        progress("writing the page", 1, 1)

    every = asdict(s)
    grid = {k: every[k] for k in ("seeds", "counts", "clustered_counts", "models", "catalogue")}
    fits = ("model-paper", "model-field")
    mine = {"figure": "3 scenes", "starts": s.starts, "particles": s.particles}
    cause = {"scenes": s.boundary_scenes, "rejected": s.rejected}
    solve = {"scenes": s.boundary_scenes, "identified": s.identified, "samples": s.samples}
    rule = {"demonstrations": s.demonstrations, "resamples": s.resamples, "seed": s.seed}
    code = code_key("demospec.report", "demospec.experiments.paper")
    made = (
        "latent.json", "repairs.json", "causes.json", "solutions.json", "parameters.json",
        "plans.json", "robot.json", *(f"accuracy-{r}.json" for r in READINGS),
    )  # fmt: skip
    drawn = {"c": s.catalogue, "seed": s.seed, "figure": "items"}
    # Weights are about seconds, so that the bar of the whole run tells its time left.
    return (
        Stage("set", "simulate demonstrations", simulate, drawn, (), 5),
        Stage("model-paper", "fit the paper's model", fit("paper"), {}, ("set",), 15),
        Stage("model-field", "fit the field model", fit("field"), {}, ("set",), 5),
        Stage("latent.json", "validity maps", latent, {"beside": "truth"}, ("set", *fits), 3),
        Stage("repairs.json", "repair", repairs, mine, ("set", *fits),
              s.starts * s.particles / 32 / workers),
        Stage("causes.json", "causes", causes, cause, ("set", *fits),
              (25 + 4 * s.boundary_scenes + s.rejected) / workers),
        Stage("solutions.json", "solutions", solutions, solve, ("set", *fits),
              (10 + 2 * s.boundary_scenes) / workers),
        Stage("parameters.json", "rule parameters", parameters, rule, (), 10),
        Stage("plans.json", "plans", plans, {"relevance": 1}, ("set", "causes.json"), 6),
        Stage("robot.json", "robot", robot, {"robot": _has_robot()}, ("set", "plans.json"), 3),
        *(Stage(f"accuracy-{r}.json", f"accuracy, {r}", accuracy(r), grid, (),
                _grid_seconds(s, r) / workers) for r in READINGS),
        Stage("reproduction.html", "write the page", page, {"code": code}, made, 1),
    )  # fmt: skip


def _cells(s: ReproduceSettings, reading: str) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Models and counts of a reading's grid."""
    if reading == "uniform":
        return s.models, s.counts
    return s.models[:1], s.clustered_counts


def _grid_seconds(s: ReproduceSettings, reading: str) -> float:
    models, counts = _cells(s, reading)
    return s.seeds * len(counts) * sum(FIT_S[model] for model in models)


def _agreement(found: Any, truth: Any) -> float:
    """Share of the plane's control points with the truth's verdict."""
    return round(float(((found.logits > 0) == (truth.logits > 0)).mean()), 4)


def _has_robot() -> bool:
    return all(importlib.util.find_spec(name) for name in ("mujoco", "mink"))


def _execute(folder: Path) -> dict[str, Any]:
    """One plan carried out by the PR2, or why not."""
    if not _has_robot():
        return {"skipped": "pip install 'demospec[robot]' brings the robot"}
    from demospec.execution import execute_plan, save_strip
    from demospec.planning import plan_path
    from demospec.rules import read_rules

    rules, scenes = read_rules(folder / "rules.json"), set_of(folder).of_split("test").scenes
    reasons = []
    for scene in scenes[:5]:
        plan = plan_path(rules, scene, "careful", allowance=0.5)
        if not plan.found:
            continue
        rollout = execute_plan(plan, scene, truth_of(folder))
        if rollout.status != "done":
            reasons.append(f"{scene.scene_id}: {rollout.reason}")
            continue
        document = rollout.to_json()
        try:
            save_strip(rollout, plan, scene, folder / "robot.png")
        except DemospecError as error:  # no EGL: the numbers are worth keeping
            document["no_picture"] = str(error)
        return {"rollout": document, "unreachable": reasons}
    return {"skipped": "no plan of five scenes is reachable: " + "; ".join(reasons)}
