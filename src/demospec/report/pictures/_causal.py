"""Causal findings as a picture: effects with intervals, and the graph S, Z_I, Z_θ → V."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from demospec.files import writing_file

if TYPE_CHECKING:
    from demospec.causal import CausalFindings, SymbolEffect

# Okabe–Ito: told apart by colour-blind people too.
_CAUSAL, _UNDECIDED, _NONE, _PLACEBO = "#D55E00", "#E69F00", "#0072B2", "#009E73"
_COLOUR = {"causal": _CAUSAL, "undecided": _UNDECIDED, "none": _NONE}
_MARK = {"causal": "D", "undecided": "s", "none": "o"}


def draw_causal_picture(findings: CausalFindings) -> Any:
    """A matplotlib figure: per type a panel of effects above, its causal graph below."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    n = len(findings.types)
    rows = max(len(findings.symbols), 1)
    width = max(3.6 * n, 5.0)
    heights = [0.42 * rows + 1.1, 0.5 * max(rows, 3) + 0.9]
    figure = Figure(figsize=(width, sum(heights) + 0.5), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(2, n, squeeze=False, height_ratios=heights, sharex="row")
    limits = _limits(findings)
    for k, type_ in enumerate(findings.types):
        _effects(grid[0][k], findings, type_, limits, first=k == 0)
        _graph(grid[1][k], findings, type_)
    handles = _legend(findings)
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=8,
                  frameon=False)  # fmt: skip
    return figure


def save_causal_picture(findings: CausalFindings, path: str | os.PathLike[str]) -> None:
    """Writes `draw_causal_picture` as PNG."""
    figure = draw_causal_picture(findings)
    with writing_file(path) as temporary:
        figure.savefig(temporary, format="png")


def _limits(findings: CausalFindings) -> tuple[float, float]:
    ends = [0.0, -findings.settings.minimum_effect, findings.settings.minimum_effect]
    for cell in findings.effects:
        if cell.n_scenes:
            ends += [cell.effect, *(cell.interval or ())]
    for patch in findings.placebo:
        if patch.n_scenes:
            ends += [patch.effect, *(patch.interval or ())]
    low, high = min(ends), max(ends)
    pad = 0.08 * (high - low) + 0.01
    return low - pad, high + pad


def _effects(
    axes: Any, findings: CausalFindings, type_: str, limits: tuple[float, float], *, first: bool
) -> None:
    cells = [c for c in findings.effects if c.type == type_]
    least = findings.settings.minimum_effect
    axes.axvspan(-least, least, color="0.92", zorder=0)
    axes.axvline(0.0, color="0.4", lw=0.8, zorder=1)
    for y, cell in enumerate(cells):
        if cell.n_scenes:
            _bar(axes, y, cell.effect, cell.interval, _COLOUR[cell.verdict], _MARK[cell.verdict])
        else:
            axes.text(0, y, "no room", fontsize=8, va="center", ha="center", color="0.3")
    patch = next((p for p in findings.placebo if p.type == type_), None)
    if patch is not None and patch.n_scenes:
        _bar(axes, len(cells), patch.effect, patch.interval, _PLACEBO, "^")
    names = [c.symbol for c in cells] + ["placebo"]
    axes.set_yticks(range(len(names)), names if first else [""] * len(names))
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xlim(limits)
    base = findings.base[type_]
    axes.set_title(f"{type_}: E[p(v)] = {base.mean:.2f} as the scenes are", fontsize=9)
    axes.set_xlabel("change of E[p(v)] when one is added", fontsize=8)
    axes.tick_params(labelsize=8)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _bar(
    axes: Any,
    y: float,
    value: float,
    interval: tuple[float, float] | None,
    colour: str,
    mark: str,
) -> None:
    if interval is not None:
        axes.plot(interval, [y, y], color=colour, lw=2.2, solid_capstyle="butt", zorder=2)
    axes.plot(value, y, mark, color=colour, ms=6.5, mec="white", mew=0.8, zorder=3)


def _graph(axes: Any, findings: CausalFindings, type_: str) -> None:
    """Symbols → Z_I → V ← S, Z_θ: thick where the effect is claimed, dotted where open."""
    cells = [c for c in findings.effects if c.type == type_]
    n = max(len(cells), 1)
    seen, verdict = (0.56, 0.5), (0.93, 0.5)
    differs = any(t.differ for t in findings.type_effects if type_ in (t.from_type, t.to_type))
    for k, cell in enumerate(cells):
        at = (0.17, 1 - (k + 0.5) / n)
        # Every arrow leaves at the right of its box, whatever its slope.
        _edge(axes, (at[0] + 0.13, at[1]), seen, cell.verdict, 0.0)
        _node(axes, at, cell.symbol, bold=cell.causal)
    reaches = _strongest(cells)
    _edge(axes, seen, verdict, reaches, 0.07)
    _edge(axes, (0.93, 0.93), verdict, "causal" if differs else "none", 0.08)
    _edge(axes, (0.93, 0.07), verdict, "given", 0.08)
    _node(axes, seen, "$Z_I$")
    _node(axes, verdict, "$V$")
    _node(axes, (0.93, 0.93), f"S = {type_}" if len(type_) < 9 else f"S = {type_[:10]}", right=True)
    _node(axes, (0.93, 0.07), r"$Z_\theta$")
    axes.set_xlim(0, 1.04)
    axes.set_ylim(-0.03, 1.03)
    axes.axis("off")


def _strongest(cells: list[SymbolEffect]) -> str:
    verdicts = {c.verdict for c in cells}
    return next((v for v in ("causal", "undecided") if v in verdicts), "none")


_STROKE: dict[str, dict[str, Any]] = {
    "causal": {"lw": 3.2, "color": _CAUSAL, "ls": "-"},
    "undecided": {"lw": 1.2, "color": _UNDECIDED, "ls": ":"},
    "none": {"lw": 0.7, "color": "0.75", "ls": "-"},
    "given": {"lw": 1.4, "color": "0.25", "ls": "-"},
}


def _edge(
    axes: Any, start: tuple[float, float], end: tuple[float, float], verdict: str, gap: float
) -> None:
    stroke = _STROKE[verdict]
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = (dx * dx + dy * dy) ** 0.5
    tail = (start[0] + dx * gap / length, start[1] + dy * gap / length)
    head = (end[0] - dx * 0.07 / length, end[1] - dy * 0.07 / length)
    head_size = "-|>,head_length=0.5,head_width=0.28"
    axes.annotate("", head, tail, arrowprops={"arrowstyle": head_size, **stroke})


def _node(
    axes: Any, at: tuple[float, float], text: str, *, bold: bool = False, right: bool = False
) -> None:
    axes.text(
        *(at if not right else (1.03, at[1])),
        text,
        ha="right" if right else "center",
        va="center",
        fontsize=9,
        fontweight="bold" if bold else "normal",
        bbox={"boxstyle": "round,pad=0.25", "fc": "white", "ec": "0.5", "lw": 0.8},
    )


def _legend(findings: CausalFindings) -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    least = findings.settings.minimum_effect
    level = f"{100 * findings.settings.level:g} % interval over scenes"
    shown = [("causal", "causal"), ("undecided", "undecided"), ("none", "no effect")]
    present = {c.verdict for c in findings.effects}
    out: list[Any] = [
        Line2D([], [], color=_COLOUR[v], marker=_MARK[v], lw=2.2, label=f"{name} ({level})"
               if i == 0 else name)
        for i, (v, name) in enumerate(p for p in shown if p[0] in present)
    ]  # fmt: skip
    out.append(Line2D([], [], color=_PLACEBO, marker="^", lw=2.2, label="placebo"))
    out.append(Patch(color="0.92", label=f"below the minimum effect ({least:g})"))
    return out
