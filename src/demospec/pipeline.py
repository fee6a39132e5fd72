"""The flow, top to bottom: demonstrations → specification model → causes → rules → plans → report.

`run_demo` simulates a set and takes it the whole way. Each stage is one call into one room, and
leaves one artefact in the run folder; a run started again computes only what is missing.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from demospec.experiments import RunRecord, Stage, code_key, run_stages
from demospec.files import write_json, writing_folder
from demospec.progress import Progress, silent


@dataclass(frozen=True)
class DemoSettings:
    """What `run_demo` does.

    Args:
        catalogue: ``builtin``, or ``sweethome3d`` where that Debian package is installed.
        train_scenes, test_scenes: Scenes of each split; test scenes show unseen items.
        demonstrations: Per scene and user type; a fifth of those in training scenes is held
            out, to measure seen scenes with unseen trajectories.
        models: Specification models to fit: ``paper``, ``field``.
        seed: Of everything.
    """

    catalogue: str = "builtin"
    train_scenes: int = 20
    test_scenes: int = 20
    demonstrations: int = 10
    models: tuple[str, ...] = ("paper", "field")
    seed: int = 0


def run_demo(
    folder: Path,
    settings: DemoSettings | None = None,
    *,
    command: str = "demospec demo",
    progress: Progress = silent,
) -> RunRecord:
    """Simulate a tabletop set and take it the whole way to ``folder/report.html``.

    Raises:
        InputError: `folder` holds other things than an earlier run.
        MissingExtraError: torch is absent.
    """
    stages = demo_stages(settings or DemoSettings())
    seed = (settings or DemoSettings()).seed
    return run_stages(folder, stages, command=command, seed=seed, progress=progress)


def demo_stages(s: DemoSettings) -> tuple[Stage, ...]:
    """The stages of `run_demo`, in order."""
    every = asdict(s)
    fits = tuple(f"model-{name}" for name in s.models)

    def simulate(folder: Path, progress: Progress) -> None:
        from demospec.demonstrations import simulate_set, write_set

        data, truth = simulate_set(
            task="tabletop",
            catalogue=s.catalogue,
            train_scenes=s.train_scenes,
            test_scenes=s.test_scenes,
            demonstrations=s.demonstrations,
            seed=s.seed,
            progress=progress,
        )
        write_set(data, folder / "set", replace_existing=True, documents={"truth.json": truth})

    def fit(name: str) -> Any:
        def work(folder: Path, progress: Progress) -> None:
            from demospec.specification import fit_model

            train = _sets(folder)["train"]
            model = fit_model(train, name, seed=s.seed, progress=progress)
            with writing_folder(folder / f"model-{name}", replace=True) as temporary:
                model.save(temporary, replace=True)

        return work

    def accuracy(folder: Path, progress: Progress) -> None:
        from demospec.experiments import accuracy_study

        sets = _sets(folder)
        chosen = {"seen": sets["seen"], "unseen": sets["unseen"]}
        document = accuracy_study(_models(folder, s.models), chosen, _truth(folder), progress)
        write_json(folder / "accuracy.json", document)

    def rules(folder: Path, progress: Progress) -> None:
        from demospec.rules import learn_rules, rules_document

        write_json(
            folder / "rules.json",
            rules_document(learn_rules(_sets(folder)["train"], progress=progress)),
        )

    def audit(folder: Path, progress: Progress) -> None:
        from demospec.specification import audit_set

        write_json(
            folder / "audit.json", audit_set(_sets(folder)["train"], progress=progress).to_json()
        )

    def query(folder: Path, progress: Progress) -> None:
        from demospec.rules import query_set

        train, found = _sets(folder)["train"], {}
        for i, type_ in enumerate(train.types):
            progress("what to ask next", i, len(train.types))
            found[type_] = query_set(train, type=type_, seed=s.seed).to_json()
        write_json(folder / "query.json", found)

    def causes(folder: Path, progress: Progress) -> None:
        from demospec.causal import Settings, find_causes

        sets, found = _sets(folder), {}
        models = {**_models(folder, s.models), "truth": _truth(folder)}
        for name, model in models.items():
            found[name] = find_causes(
                model, sets["train"].scenes, settings=Settings(seed=s.seed), progress=progress
            ).to_json()
        write_json(folder / "causes.json", found)

    def plans(folder: Path, progress: Progress) -> None:
        from demospec.experiments import plan_study
        from demospec.rules import read_rules

        unseen = _sets(folder)["unseen"].scenes
        learned = read_rules(folder / "rules.json")
        write_json(folder / "plans.json", plan_study(learned, unseen, _truth(folder), progress))

    def repairs(folder: Path, progress: Progress) -> None:
        from demospec.experiments import repair_study

        sets, document = _sets(folder), {}
        for name, model in _models(folder, s.models).items():
            document[name] = {
                which: repair_study(
                    model, sets[which].scenes, _truth(folder), seed=s.seed, progress=progress
                )
                for which in ("seen", "unseen")
            }
        write_json(folder / "repairs.json", document)

    def report(folder: Path, progress: Progress) -> None:
        from demospec.report import build_report, write_html

        progress("writing the report", 0, 1)
        write_html(build_report(folder), folder / "report.html")
        progress("writing the report", 1, 1)

    return (
        Stage("set", "simulate demonstrations", simulate, every),
        *(Stage(f"model-{m}", f"fit the {m} model", fit(m), {}, ("set",)) for m in s.models),
        Stage("accuracy.json", "judge held-out demonstrations", accuracy, {}, ("set", *fits)),
        Stage("rules.json", "learn the rules", rules, {}, ("set",)),
        Stage("audit.json", "look for contradictions", audit, {}, ("set",)),
        Stage("query.json", "find what to ask next", query, {}, ("set",)),
        Stage("causes.json", "find the causes", causes, {}, ("set", *fits)),
        Stage("plans.json", "plan in unseen scenes", plans, {}, ("set", "rules.json")),
        Stage("repairs.json", "repair rejected trajectories", repairs, {}, ("set", *fits)),
        Stage("report.html", "write the report", report, {"code": code_key("demospec.report")}, (
            "accuracy.json", "rules.json", "audit.json", "causes.json", "plans.json",
            "repairs.json", "query.json",
        )),
    )  # fmt: skip


def _sets(folder: Path) -> dict[str, Any]:
    """The set's parts: train, seen (held-out trajectories), unseen (scenes and items)."""
    from demospec.demonstrations import pictures_in_memory, read_set
    from demospec.experiments import hold_out

    data = pictures_in_memory(read_set(folder / "set"))
    train, seen = hold_out(data.of_split("train"))
    return {"train": train, "seen": seen, "unseen": data.of_split("test")}


def _models(folder: Path, names: tuple[str, ...]) -> dict[str, Any]:
    """The fitted models, shown pictures only: what they know of objects they have to see."""
    from demospec.experiments import PicturesOnly
    from demospec.specification import load_model

    return {name: PicturesOnly(load_model(folder / f"model-{name}")) for name in names}


def _truth(folder: Path) -> Any:
    from demospec.rules import read_rules

    return read_rules(folder / "set" / "truth.json")
