"""The page of a reproduction: each table and figure beside the paper's numbers, and a reading.

Readings are chosen by comparing the numbers; no sentence states a result by itself.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.experiments.paper import _page_models as of_models
from demospec.experiments.paper import _page_rules as of_rules
from demospec.experiments.paper import _page_solutions as of_solutions
from demospec.experiments.paper import _paper as paper
from demospec.experiments.paper._beside import beside_table
from demospec.experiments.paper._readings import (
    causes_agree,
    people_reading,
    percent,
    printed_curve,
    unseen_reading,
)
from demospec.files import read_json
from demospec.report import Block, Report, Section, Table, Text, share

if TYPE_CHECKING:
    from demospec.experiments.paper._stages import ReproduceSettings


UNSEEN = (
    "Unseen scenes show unseen items: further draws of the same parametric families that the "
    "training items come from (in the catalogue sweethome3d: other models of the same classes), on "
    "other tables in other light. No fit of a run sees them; the shipped backbone was developed "
    "with the same catalogues in view. Nothing here is a photograph."
)


def build_page(folder: Path, settings: ReproduceSettings) -> Report:
    """Reads the artefacts of `folder` and lays out the page."""
    record = read_json(folder / "run.json")
    sections = (
        Section("beside", "Beside the paper's numbers", (beside_table(folder),)),
        Section("samples", "What was demonstrated", tuple(_samples(folder))),
        Section("accuracy", "Accuracy against demonstrations", tuple(of_models.accuracy(folder))),
        Section("latent", "Where the control point may lie", tuple(of_models.latent(folder))),
        Section("repair", "Repair", tuple(of_models.repair(folder))),
        Section("causes", "Causes", tuple(of_rules.causes(folder))),
        Section("boundaries", "What an object changes", tuple(of_solutions.boundaries(folder))),
        Section(
            "solutions", "Types found, solutions shared", tuple(of_solutions.solutions(folder))
        ),
        Section(
            "parameters", "Rule parameters", tuple(of_rules.parameters(folder, settings.resamples))
        ),
        Section(
            "plans",
            "Cost maps, plans and the robot",
            (*of_rules.plans(folder), *of_solutions.relevance(folder)),
        ),
        Section("computed", "How this was computed", tuple(_computed(record, settings))),
    )
    return Report(
        title="The paper, measured again",
        subtitle=(
            "Angelov, Hristov, Ramamoorthy 2020. The paper's data are not public: everything here "
            "is measured on simulated demonstrators whose rule is known, and judged by that rule."
        ),
        summary=_summary(folder),
        sections=sections,
    )


def _summary(folder: Path) -> tuple[str, ...]:
    uniform = read_json(folder / "accuracy-uniform.json")["rows"]
    clustered = read_json(folder / "accuracy-clustered.json")["rows"]
    curves = {"uniform": uniform, "clustered": clustered}
    ends = {name: of_models.curve_of_the_paper(rows) for name, rows in curves.items()}
    out = [printed_curve({name: (c[0][1], c[-1][1]) for name, c in ends.items()})]
    out += unseen_reading(uniform)
    repairs = read_json(folder / "repairs.json")
    shares = []
    for model, words in (("paper", "the paper's model"), ("field", "our field model")):
        own = {t: v for t, v in repairs[model]["1"].items() if not v["vacuous"]}
        told = " and ".join(f"{percent(v['repaired_by_truth'])} ({t})" for t, v in own.items())
        shares.append(f"{words} repairs {told}")
    printed = ", ".join(f"{t} {v:.0%}" for t, v in paper.REPAIR.items()).replace("%", "\u00a0%")
    out.append(
        f"Judged by the true rule, with one particle {'; '.join(shares)}. Printed: {printed}."
    )
    found = read_json(folder / "causes.json")
    agree = {m: causes_agree(found[m]) for m in ("paper", "field") if m in found}
    told = "; ".join(
        f"{words} agrees in {agree[m][0]} of {agree[m][1]}"
        for m, words in (("paper", "the paper's model"), ("field", "our field model"))
        if m in agree
    )
    out.append(f"Which object causes rejection, cell by cell of the paper's table: {told}.")
    people = read_json(folder / "parameters.json")["participants"]
    out += people_reading(people)
    made = [p for p in read_json(folder / "plans.json")["plans"] if p["status"] == "found"]
    kept = sum(p["true_obeys"] for p in made)
    out.append(f"{kept} of {len(made)} plans in unseen scenes keep the demonstrator's own rule.")
    return tuple(out)


def _samples(folder: Path) -> list[Block]:
    from demospec.demonstrations import read_set

    data = read_set(folder / "set")
    d = data.demonstrations
    rows = []
    for type_ in data.types:
        valid = d.valid[np.asarray(d.type) == type_]
        printed = paper.CAUSAL.get(type_)
        own = "–" if printed is None else percent(printed[0], 0)
        rows.append((type_, share(int((valid == 1).sum()), len(valid)), own))
    words = (
        "Paths from the circle to the star, a row for each type of demonstrator: accepted ones "
        "are solid and blue, rejected ones dashed and orange. “Careful” keeps clear of everything, "
        "“normal” of glasses, “aggressive” of nothing."
    )
    return [
        Text(words),
        *of_models.figure(folder, "samples.png", "Four training scenes with demonstrations"),
        *of_models.figure(
            folder, "items.png", "Items of training scenes, and unseen items of test scenes"
        ),
        Text(UNSEEN),
        Table(
            ("type", "accepted [95 %]", "accepted in the paper"),
            tuple(rows),
            "Share of random paths that each type accepts",
            "The simulated scenes are drawn so that these shares come near the printed ones.",
        ),
    ]


def _computed(record: dict[str, Any], s: ReproduceSettings) -> list[Block]:
    versions = ", ".join(f"{k} {v}" for k, v in record["versions"].items())
    rows = (
        ("command", record["command"]),
        ("seed", str(record["seed"])),
        ("randomisations of the grid", str(s.seeds)),
        ("trajectories per scene and type", ", ".join(map(str, s.counts))),
        ("the same, clustered reading", ", ".join(map(str, s.clustered_counts))),
        ("rejected paths to repair, per type", f"{s.starts} (fewer where no solution exists)"),
        ("demonstrations per participant", str(s.demonstrations)),
        ("scenes of boundaries and of sampled solutions", str(s.boundary_scenes)),
        ("rejected demonstrations asked object by object, per type", str(s.rejected)),
        ("demonstrators identified, per type and number shown", str(s.identified)),
        ("versions", versions),
        ("python, machine", f"{record['python']}, {record['machine']}"),
    )
    stages = record["stages"].values()
    times = [(stage["title"], f"{stage['seconds']:.1f}") for stage in stages]
    times.append(("together", f"{sum(stage['seconds'] for stage in stages):.1f}"))
    note = "Of an accuracy that was interrupted, the last part only."
    return [
        Table(("what", "value"), rows),
        Table(("stage", "seconds"), tuple(times), "Time of each stage when it ran", note),
        Text(
            "Beside this page: results.csv with every number, a CSV for each table, JSON with all "
            "that was measured, the pictures as PNG (curves and heat maps as SVG, too), the set "
            "with its true rule, and the fitted models."
        ),
    ]
