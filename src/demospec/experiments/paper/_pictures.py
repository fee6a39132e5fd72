"""The paper's figures, drawn from our own results. Okabe-Ito colours, units on axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.files import writing_file
from demospec.report import look_of

VALID, INVALID = "#0072b2", "#d55e00"


def save(figure: Any, *paths: Path) -> None:
    """Writes a figure under every name, whole or not at all."""
    for path in paths:
        kind = path.suffix[1:]
        stamp: dict[str, Any] = {"Software": None} if kind == "png" else {"Date": None}
        with writing_file(path) as temporary:
            figure.savefig(temporary, format=kind, dpi=130, metadata=stamp)


def panels(rows: int, columns: int, width: float = 3.2, height: float = 3.2) -> tuple[Any, Any]:
    """A figure and its axes (rows, columns)."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False)


def show_scene(ax: Any, scene: Any, *, faded: bool = False) -> None:
    """The picture in its own pixels; start and goal marked. Faded: for lines of many shades."""
    width, height = scene.size_px
    alpha = 0.4 if faded else 1.0
    ax.imshow(scene.picture.pixels, extent=(0, width, height, 0), alpha=alpha)
    ax.plot(*scene.start[:2], "o", color="white", mec="black", ms=5)
    ax.plot(*scene.goal[:2], "*", color="white", mec="black", ms=9)
    ax.set(xticks=[], yticks=[], xlim=(0, width), ylim=(height, 0))


def draw_samples(data: DemonstrationSet, path: Path, count: int = 4) -> None:
    """Some training scenes, a row a type: accepted blue, rejected dashed orange."""
    from matplotlib.patheffects import withStroke

    scenes = data.of_split("train").scenes[:count]
    figure, axes = panels(len(data.types), len(scenes), 2.4, 2.4)
    # A white halo keeps the lines readable on every table.
    halo = [withStroke(linewidth=2.6, foreground="white", alpha=0.7)]
    d = data.demonstrations
    for row, type_ in zip(axes, data.types, strict=True):
        for ax, scene in zip(row, scenes, strict=True):
            show_scene(ax, scene)
            for i in np.flatnonzero((d.scene_id == scene.scene_id) & (d.type == type_)):
                good = d.valid[i] == 1
                ax.plot(
                    *d.points(int(i))[:, :2].T, lw=1.2, path_effects=halo,
                    color=VALID if good else INVALID, ls="-" if good else "--",
                )  # fmt: skip
        row[0].set_ylabel(type_)
    save(figure, path)


def draw_accuracy(rows: Sequence[Mapping[str, Any]], stem: Path, reading: str) -> None:
    """Balanced accuracy against trajectories per scene: types by seen, unseen scenes."""
    types = [t for t in dict.fromkeys(r["type"] for r in rows) if _defined(rows, t)]
    figure, axes = panels(2, max(len(types), 1), 3.9, 2.6)
    every = sorted({r["n"] for r in rows})
    for row, where in zip(axes, ("seen", "unseen"), strict=True):
        for ax, type_ in zip(row, types, strict=True):
            for model in dict.fromkeys(r["model"] for r in rows):
                mine = [r for r in rows if r["model"] == model and r["type"] == type_]
                mine = [r for r in mine if r[f"bacc_{where}"] is not None]
                x = [r["n"] for r in mine]
                y = [r[f"bacc_{where}"] for r in mine]
                low, high = np.array([r[f"quartiles_{where}"] for r in mine]).reshape(-1, 2).T
                ax.fill_between(x, low, high, color=look_of(model)[0], alpha=0.15, lw=0)
                ax.plot(x, y, marker=look_of(model)[1], color=look_of(model)[0], label=model, ms=4)
            ax.axhline(0.5, color="0.6", lw=0.8, ls=":")
            ax.set_ylim(0.4, 1.02)
            ax.set_title(f"{type_}, {where} scenes, {reading} reading", fontsize=9)
            _count_axis(ax, every)
        row[0].set_ylabel("balanced accuracy", fontsize=8)
    _legend_below(figure, axes[0][0])
    save(figure, stem.with_suffix(".png"), stem.with_suffix(".svg"))


def draw_curves(
    curves: Mapping[str, Mapping[str, Sequence[tuple[int, float, float, float]]]],
    printed: Mapping[str, tuple[float, float, float]],
    stem: Path,
) -> None:
    """Plain accuracy as the paper counts it, a panel a reading, and the paper's two ends.

    Args:
        curves: Reading → model → (n, mean, lower and upper quartile).
        printed: ``first`` and ``last``: mean, lower and upper quartile.
        stem: Name without its ending.
    """
    figure, axes = panels(1, len(curves), 3.9, 2.9)
    for ax, (reading, models) in zip(axes[0], curves.items(), strict=True):
        for model, curve in models.items():
            x, y, low, high = zip(*curve, strict=True)
            ax.fill_between(x, low, high, color=look_of(model)[0], alpha=0.15, lw=0)
            ax.plot(x, y, marker=look_of(model)[1], color=look_of(model)[0], label=model, ms=4)
        every = sorted({point[0] for curve in models.values() for point in curve})
        ends = [(every[0], *printed["first"]), (every[-1], *printed["last"])]
        for k, (n, mean, first, third) in enumerate(ends):
            ax.errorbar(n, mean, [[mean - first], [third - mean]], fmt="*", color="black", ms=8,
                        capsize=4, lw=1.2, label=None if k else "printed in the paper")  # fmt: skip
        ax.set_ylim(0.6, 1.02)
        ax.set_title(f"{reading} reading", fontsize=9)
        _count_axis(ax, every)
    axes[0][0].set_ylabel("accuracy, mean of three types", fontsize=8)
    _legend_below(figure, axes[0][0])
    save(figure, stem.with_suffix(".png"), stem.with_suffix(".svg"))


def _count_axis(ax: Any, every: Sequence[int]) -> None:
    """Ticks where something was measured."""
    ax.set_xticks(every)
    ax.tick_params(labelsize=8)
    ax.set_xlabel("trajectories per scene and type [number]", fontsize=8)


def _legend_below(figure: Any, ax: Any) -> None:
    """One legend under all panels: inside a panel it hides curves."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=8,
                  frameon=False)  # fmt: skip


def _defined(rows: Sequence[Mapping[str, Any]], type_: str) -> bool:
    return any(r["type"] == type_ and r["bacc_seen"] is not None for r in rows)


def draw_latent(parts: Mapping[str, Any], maps: Mapping[str, Any], stem: Path) -> None:
    """The z_θ plane of a seen and an unseen scene for each model and type; light: accepted."""
    models = list(next(iter(maps.values())))
    types = list(maps["seen"][models[0]])
    figure, axes = panels(2 * len(models), len(types) + 1, 2.2, 2.2)
    r = 0
    for which, scene in parts.items():
        for model in models:
            show_scene(axes[r][0], scene)
            axes[r][0].set_ylabel(f"{model}\n{which} scene")
            for ax, type_ in zip(axes[r][1:], types, strict=True):
                found = maps[which][model][type_]
                extent = (found.x[0], found.x[-1], found.y[-1], found.y[0])
                ax.imshow(found.p_valid, cmap="cividis", vmin=0, vmax=1, extent=extent)
                ax.set(xticks=[], yticks=[])
                if r == 0:
                    ax.set_title(type_)
            r += 1
    save(figure, stem.with_suffix(".png"))


def draw_repairs(data: DemonstrationSet, study: Mapping[str, Any], path: Path) -> None:
    """One model's repairs, three unseen scenes × every type, from dark to light.

    Args:
        study: Of one particle: type → `repair_study`.
        path: Of the picture.
    """
    from matplotlib import colormaps

    types = list(study)
    scenes = _common_scenes(study)
    figure, axes = panels(max(len(scenes), 1), len(types), 2.8, 2.9)
    blues = colormaps["Blues_r"]
    for row, scene in zip(axes, scenes, strict=False):
        for ax, type_ in zip(row, types, strict=True):
            show_scene(ax, data.scene(scene), faded=True)
            found = [e for e in study[type_]["examples"] if e["scene"] == scene]
            if not found:
                why = "rejects nothing" if study[type_]["vacuous"] else "nothing to repair here"
                ax.set_title(f"{type_}: {why}", fontsize=9)
                continue
            steps = found[0]["steps"]
            for k, curve in list(enumerate(steps))[1:-1]:  # the ends are drawn below
                colour = blues(0.05 + 0.6 * k / max(len(steps) - 1, 1))
                ax.plot(*np.array(curve).T, color=colour, lw=1.4)
            ax.plot(*np.array(steps[0]).T, color="black", lw=1.4, ls=":")
            good = found[0]["rule_valid"]
            ax.plot(*np.array(steps[-1]).T, color=VALID if good else INVALID, lw=2.4)
            verdict = "accepts" if good else "rejects"
            ax.set_title(f"{type_}: true rule {verdict}", fontsize=9)
    save(figure, path)


def _common_scenes(study: Mapping[str, Any], count: int = 3) -> list[str]:
    """Scenes of the examples: those that most types have one in come first."""
    names = [e["scene"] for v in study.values() for e in v["examples"]]
    return sorted(dict.fromkeys(names), key=lambda s: (-names.count(s), s))[:count]


ITEMS_SHOWN = 6
"""Items of a symbol in the figure of items, of each part."""


def draw_items(symbols: Sequence[str], catalogue: str, path: Path) -> None:
    """Training items and unseen items side by side, a row a symbol, on one table in one light."""
    from demospec.scene import Light, Placement, TableTop, compose_scene, load_catalogue

    parts = {"train": "in training scenes", "test": "unseen"}
    figure, axes = panels(len(symbols), 2, 3.0, 2.05)
    size, side = 240, 240 / 3
    for column, (part, words) in enumerate(parts.items()):
        items = load_catalogue(catalogue, part)  # type: ignore[arg-type]
        for ax, symbol in zip(axes[:, column], symbols, strict=True):
            places = [
                Placement(item, ((k % 3 + 0.5) * side, (k // 3 + 0.5) * side), np.pi / 4)
                for k, item in enumerate(items.of_symbol(symbol)[:ITEMS_SHOWN])
            ]
            scene = compose_scene("items", places, table=TableTop("stone", 3), light=Light(),
                                  size_px=size)  # fmt: skip
            ax.imshow(scene.pixels()[: size * 2 // 3])
            ax.set(xticks=[], yticks=[])
            if ax is axes[0, column]:
                ax.set_title(words, fontsize=9)
            if column == 0:
                ax.set_ylabel(symbol, fontsize=9)
    save(figure, path)


def draw_plans(
    data: DemonstrationSet, rules: Any, document: Mapping[str, Any], path: Path, count: int = 2
) -> None:
    """Cost map and plan of every type in some unseen scenes."""
    from demospec.planning import cost_map

    scenes = data.of_split("test").scenes[:count]
    figure, axes = panels(len(scenes), len(rules.types), 3.0, 3.0)
    for row, scene in zip(axes, scenes, strict=True):
        for ax, type_ in zip(row, rules.types, strict=True):
            show_scene(ax, scene)
            prices = cost_map(rules, scene, type_)
            extra = np.ma.masked_less_equal(np.asarray(prices.array, dtype=float), 1.0)
            width, height = scene.size_px or extra.shape[::-1]
            extent = (0, width, height, 0)
            if extra.count():  # somebody may keep clear of nothing
                ax.imshow(extra, cmap="Oranges", alpha=0.6, vmin=1.0, extent=extent)
            for plan in document["plans"]:
                mine = plan["scene"] == scene.scene_id and plan["type"] == type_
                if mine and plan["status"] == "found":
                    line = np.array(plan["points"])[:, :2].T
                    ax.plot(*line, color="white", lw=4, solid_capstyle="round")
                    ax.plot(*line, color=VALID, lw=2.2)
            ax.set_title(f"{type_}, scene {scene.scene_id}", fontsize=9)
    save(figure, path)
