"""Effect of adding an object against how near a path passes it, with its band."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from demospec.frames import describe_length

if TYPE_CHECKING:
    from demospec.causal import CausalFindings, DosePoint

# Okabe–Ito, and a mark each: told apart without colours too.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_MARKS = "osD^vP*"


def draw_dose_response(
    findings: CausalFindings, units: str, metres_per_unit: float | None = None
) -> Any:
    """A matplotlib figure: a panel a type, a curve a symbol.

    Each point stands in the middle of its bin; the last, which has no end, at its beginning.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    types = [t for t in findings.types if any(c.type == t for c in findings.dose)]
    figure = Figure(figsize=(max(3.6 * len(types), 5.0), 3.4), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, max(len(types), 1), squeeze=False, sharey=True)[0]
    for axes, type_ in zip(panels, types, strict=False):
        axes.axhline(0.0, color="0.4", lw=0.8)
        for curve in findings.dose:
            if curve.type != type_:
                continue
            k = findings.symbols.index(curve.symbol)
            x = [_middle(p) for p in curve.points]
            colour = _COLOURS[k % len(_COLOURS)]
            axes.plot(x, [p.effect for p in curve.points], color=colour, lw=1.4, ms=4,
                      marker=_MARKS[k % len(_MARKS)], label=curve.symbol)  # fmt: skip
            ends = [p.interval or (p.effect, p.effect) for p in curve.points]
            axes.fill_between(x, [e[0] for e in ends], [e[1] for e in ends], color=colour,
                              alpha=0.15, lw=0)  # fmt: skip
        axes.set_title(type_, fontsize=9)
        axes.tick_params(labelsize=8)
        ticks = [t for t in axes.get_xticks() if axes.get_xlim()[0] <= t <= axes.get_xlim()[1]]
        words = ["0" if t == 0 else describe_length(t, metres_per_unit, units) for t in ticks]
        axes.set_xticks(ticks, words, fontsize=7)
        axes.set_xlabel("nearest the path comes to it", fontsize=8)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
    panels[0].set_ylabel("change of E[p(v)]", fontsize=8)
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=max(len(names), 1), fontsize=8,
                  frameon=False)  # fmt: skip
    return figure


def _middle(point: DosePoint) -> float:
    """Where in its bin a point is drawn."""
    if point.low is None:
        return 0.0 if point.high is None else point.high
    return point.low if point.high is None else (point.low + point.high) / 2
