"""Sections of the page that ask a specification model: accuracy, validity maps, repair."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from demospec.experiments.paper import _paper as paper
from demospec.experiments.paper._readings import (
    NBSP,
    WHOSE,
    ablation_reading,
    accuracy_reading,
    latent_reading,
    percent,
    repair_reading,
)
from demospec.files import read_json
from demospec.report import Block, Figure, Lines, Table, Text, share

Curve = list[tuple[int, float, float, float]]

_READINGS = (
    "The paper does not say how its held-out trajectories relate to the ones that were shown. "
    "Two readings are measured. “Uniform”: both are random paths. “Clustered”: a demonstrator "
    "repeats a few paths of a scene, and the held-out ones are near copies of the same."
)
_MODELS = (
    "Models: “full” is the paper's; “autoencoder” is without its KL term, “classifier” without "
    "reconstruction too; “irl” is its baseline, a maximum-entropy reward; “field” is ours. All "
    f"are shown pictures only. 50{NBSP}% is guessing."
)
_LIFTED = (
    "The mean over three types is lifted by the type that accepts everything, which no learning is "
    "needed for; the tables below keep types apart, and unseen scenes apart from seen ones."
)


def figure(folder: Path, name: str, caption: str) -> list[Block]:
    """The picture, where it was made."""
    file = folder / name
    return [Figure(file.read_bytes(), caption, caption)] if file.is_file() else []


def curve_of_the_paper(rows: list[dict[str, Any]], model: str = "full") -> Curve:
    """(n, mean, quartiles) of a model's plain accuracy in seen scenes, the mean of all types."""
    full = [r for r in rows if r["model"] == model]
    out = []
    for n in sorted({r["n"] for r in full}):
        # As in the paper: the type that accepts everything is in the mean.
        by_fit = np.mean([r["accuracies_seen"] for r in full if r["n"] == n], axis=0)
        low, high = np.quantile(by_fit, (0.25, 0.75))
        out.append((n, float(by_fit.mean()), float(low), float(high)))
    return out


def draw_as_printed(folder: Path) -> None:
    """Draws every model's curve as the paper counts it, and the paper's two ends."""
    from demospec.experiments.paper._pictures import draw_curves

    curves = {}
    for reading in ("uniform", "clustered"):
        rows = read_json(folder / f"accuracy-{reading}.json")["rows"]
        models = dict.fromkeys(r["model"] for r in rows)
        curves[reading] = {model: curve_of_the_paper(rows, model) for model in models}
    draw_curves(curves, paper.ACCURACY, folder / "accuracy-as-printed")


def accuracy(folder: Path) -> list[Block]:
    """The paper's curve, then models by type and by seen and unseen scenes."""
    every = {r: read_json(folder / f"accuracy-{r}.json")["rows"] for r in ("uniform", "clustered")}
    curves = {reading: curve_of_the_paper(rows) for reading, rows in every.items()}
    means = {r: (c[0][1], c[-1][1]) for r, c in curves.items()}
    blocks: list[Block] = [
        Text(_READINGS),
        *figure(
            folder,
            "accuracy-as-printed.png",
            "As the paper counts: plain accuracy, mean of three types, held-out paths in scenes "
            "that were trained on; mean and quartiles over randomisations. In black what the "
            "paper prints for the fewest and the most trajectories",
        ),
        _beside_the_paper(curves),
        Text(accuracy_reading(means, _LIFTED)),
        Text(_MODELS),
    ]
    for reading, rows in every.items():
        blocks += figure(
            folder,
            f"accuracy-{reading}.png",
            f"Balanced accuracy against trajectories shown, {reading} reading: mean and quartiles",
        )
        blocks.append(_balanced(rows, reading))
        if reading == "uniform":
            blocks.append(Lines(tuple(ablation_reading(rows))))
            blocks.append(_plain(rows))
    return blocks


def _beside_the_paper(curves: dict[str, Curve]) -> Table:
    rows = [
        (
            "printed in the paper",
            *(_middle(*paper.ACCURACY[end]) for end in ("first", "last")),
        )
    ]
    for reading, curve in curves.items():
        rows.append((f"ours, {reading}", *(_middle(*point[1:]) for point in (curve[0], curve[-1]))))
    some = next(iter(curves.values()))
    note = (
        f"Fewest and most are n{NBSP}={NBSP}{some[0][0]} and {some[-1][0]} trajectories per scene "
        "and type here. Mean [quartiles over randomisations]."
    )
    return Table(
        ("whose", "fewest shown", "most shown"),
        tuple(rows),
        "The full model in this picture",
        note,
    )


def _balanced(rows: list[dict[str, Any]], reading: str) -> Table:
    """A row for each model and n; a pair of columns for each type that has two classes."""
    types = _two_classes(rows)
    known = {(r["model"], r["n"], r["type"]): r for r in rows}
    cells = []
    for model in dict.fromkeys(r["model"] for r in rows):
        for n in sorted(_some([r["n"] for r in rows])):
            mine = [known[model, n, t] for t in types if (model, n, t) in known]
            pairs = (_spread(r, where) for r in mine for where in ("seen", "unseen"))
            cells.append((model, str(n), *pairs))
    header = ("model", "n", *(f"{t}, {where}" for t in types for where in ("seen", "unseen")))
    left = [t for t in dict.fromkeys(r["type"] for r in rows) if t not in types]
    fits = max(r["fits"] for r in rows)
    note = (
        f"n: trajectories per scene and type. Mean [quartiles] of {fits} fits, on held-out paths. "
        f"{_one_class(left)}"
        f"Every n, and paths far from the boundary apart: accuracy-{reading}.csv."
    )
    return Table(header, tuple(cells), f"Balanced accuracy in per cent, {reading} reading", note)


def _one_class(types: list[str]) -> str:
    if not types:
        return ""
    names = " and ".join(f"“{t}”" for t in types)
    return f"{names}: one label only, no balanced accuracy. "


def _plain(rows: list[dict[str, Any]]) -> Table:
    """Plain accuracy beside the majority class at the most trajectories, seen and unseen."""
    most = max(r["n"] for r in rows)
    types = list(dict.fromkeys(r["type"] for r in rows))
    known = {(r["model"], r["type"]): r for r in rows if r["n"] == most}
    cells = []
    for model in dict.fromkeys(r["model"] for r in rows):
        mine = [known[model, t] for t in types]
        pairs = (_over_fits(r[f"accuracies_{w}"]) for r in mine for w in ("seen", "unseen"))
        cells.append((model, *pairs))
    some = [known[cells[0][0], t] for t in types]
    majority = (r[f"majority_{w}"] for r in some for w in ("seen", "unseen"))
    fits = max(r["fits"] for r in rows)
    cells.append(("always the commoner label", *(_number(v) for v in majority)))
    return Table(
        ("model", *(f"{t}, {w}" for t in types for w in ("seen", "unseen"))),
        tuple(cells),
        f"Plain accuracy in per cent, n = {most}, uniform reading",
        f"Mean [quartiles] of {fits} fits. The last row is what needs no learning.",
    )


def _two_classes(rows: list[dict[str, Any]]) -> list[str]:
    found = dict.fromkeys(r["type"] for r in rows)
    return [t for t in found if any(r["type"] == t and r["bacc_seen"] is not None for r in rows)]


def _some(counts: list[int]) -> set[int]:
    """The fewest, the middle and the most."""
    every = sorted(set(counts))
    return {every[0], every[(len(every) - 1) // 2], every[-1]}


def _middle(mean: float, low: float, high: float) -> str:
    return f"{percent(mean)} [{100 * low:.1f},{NBSP}{100 * high:.1f}]"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{100 * value:.1f}"


def _over_fits(values: list[float]) -> str:
    """Mean and quartiles, per cent."""
    if not values:
        return "–"
    low, high = np.quantile(values, (0.25, 0.75))
    return f"{_number(float(np.mean(values)))} [{100 * low:.0f},{NBSP}{100 * high:.0f}]"


def _spread(row: dict[str, Any], where: str) -> str:
    """Mean and quartiles over fits, per cent."""
    ends = row.get(f"quartiles_{where}")
    mean = _number(row[f"bacc_{where}"])
    return mean if not ends else f"{mean} [{100 * ends[0]:.0f},{NBSP}{100 * ends[1]:.0f}]"


def latent(folder: Path) -> list[Block]:
    """Validity over the control point; the truth beside the networks."""
    document = read_json(folder / "latent.json")
    shares, agreement = document["valid_share_of_the_plane"], document["agrees_with_truth"]
    types = list(next(iter(shares["seen"].values())))
    rows = []
    for where, models in shares.items():
        for model, by in models.items():
            rows.append((where, WHOSE[model], *(percent(by[t]) for t in types)))
    header = ("scene", "model", *types)
    words = (
        "Each square is the plane of control points: where it is light (yellow), the curve from "
        "the circle to the star over that control point is accepted. The paper has such pictures "
        "for its own scenes; only their look can be compared. Here the true rule stands below."
    )
    return [
        Text(words),
        *figure(
            folder,
            "latent.png",
            "Validity over the control point, by model and type: dark rejected, light accepted; "
            "above a training scene, below a scene with items that no model has seen",
        ),
        Table(
            header,
            tuple(rows),
            "Share of control points that are accepted",
            "One scene of each kind, the whole plane on a grid: nothing is sampled, and no "
            "interval is given. Another scene gives other shares.",
        ),
        Text("Control points judged as the true rule judges them:"),
        Lines(tuple(latent_reading(agreement))),
    ]


def repair(folder: Path) -> list[Block]:
    """Repairs judged by the truth, beside the printed shares."""
    results = read_json(folder / "repairs.json")
    rows = []
    vacuous: dict[str, None] = {}
    for model, by in results.items():
        for particles, types in by.items():
            for type_, v in types.items():
                if v["vacuous"]:
                    vacuous[type_] = None
                    continue
                own = percent(paper.REPAIR.get(type_), 0) if particles == "1" else "–"
                rows.append(
                    (
                        WHOSE.get(model, model), particles, type_,
                        share(round(v["n"] * v["repaired_by_truth"]), v["n"]),
                        percent(v["accepted_by_model"]), f"{v['moved_px']:.1f}{NBSP}px", own,
                    )
                )  # fmt: skip
    header = (
        "model", "particles", "type", "true rule accepts [95 %]", "model believes",
        "control point moved", "printed",
    )  # fmt: skip
    note = (
        "Unseen scenes that have a valid solution. The paper does not say who judged its repairs; "
        "ours are judged by the rule that made the labels, and what the model itself believes "
        "stands beside. Intervals as if the starts of one scene were independent. "
    )
    for type_ in vacuous:
        printed = percent(paper.REPAIR.get(type_), 0)
        note += f"“{type_}” rejects nothing: nothing to repair (the paper prints {printed})."
    return [
        *(
            block
            for model in results
            for block in figure(
                folder,
                f"repairs-{model}.png",
                f"Repair by {WHOSE.get(model, model)} in three unseen scenes, one particle: dotted "
                "the rejected path, then each step from dark to light, thick the last (blue where "
                "the true rule accepts it, else orange)",
            )
        ),
        Table(header, tuple(rows), "Rejected paths after at most 30 gradient steps", note),
        Lines(tuple(repair_reading(results))),
    ]
