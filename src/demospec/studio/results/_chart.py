"""Balanced accuracy with intervals as an SVG picture that follows the page's colours."""

from __future__ import annotations

from html import escape
from typing import Any

_LEFT, _ROW, _WIDTH, _GAP = 92.0, 17.0, 240.0, 48.0
_PANELS = {"seen": "seen scenes, held-out paths", "unseen": "unseen scenes and items"}


def accuracy_chart(document: dict[str, Any]) -> str:
    """A dot with its interval for each model and type; a panel for each kind of scenes.

    Types that cannot be scored (one class) are named so. The line at 50 % is guessing.
    """
    models = list(document)
    panels = list(dict.fromkeys(which for sets in document.values() for which in sets))
    kinds = list(
        dict.fromkeys(k for sets in document.values() for types in sets.values() for k in types)
    )
    if not panels or not kinds:
        return ""
    group = _ROW * len(models) + 10
    height = 30 + group * len(kinds) + 30
    width = _LEFT + len(panels) * (_WIDTH + _GAP)
    parts = [
        f'<svg class="re-chart" viewBox="0 0 {width:g} {height:g}" role="img" '
        'aria-label="Balanced accuracy of each model and type; the table below has the numbers">'
    ]
    for p, which in enumerate(panels):
        left = _LEFT + p * (_WIDTH + _GAP)
        parts.append(_axis(left, height, _PANELS.get(which, which)))
        for k, kind in enumerate(kinds):
            top = 30 + k * group
            if p == 0:
                middle = top + _ROW * len(models) / 2 + 4
                parts.append(
                    f'<text x="{_LEFT - 12}" y="{middle:g}" class="name">{escape(kind)}</text>'
                )
            for m, model in enumerate(models):
                score = document[model].get(which, {}).get(kind)
                if score is not None:
                    parts.append(_dot(left, top + _ROW * (m + 0.5), m, model, score))
    parts.append("</svg>")
    keys = "".join(
        f'<span><i class="m{m % 4}"></i>{escape(model)}</span>' for m, model in enumerate(models)
    )
    return f'<div class="re-keys">{keys}</div>{"".join(parts)}'


def _x(left: float, share: float) -> float:
    return left + _WIDTH * min(max(share, 0.0), 1.0)


def _axis(left: float, height: float, title: str) -> str:
    parts = [f'<text x="{left + _WIDTH / 2:g}" y="16" class="title">{escape(title)}</text>']
    for tick in (0.0, 0.25, 0.5, 0.75, 1.0):
        x = _x(left, tick)
        mark = "guess" if tick == 0.5 else "grid"
        words = f"{100 * tick:.0f} %"
        parts.append(f'<line x1="{x:g}" x2="{x:g}" y1="26" y2="{height - 28:g}" class="{mark}"/>')
        parts.append(f'<text x="{x:g}" y="{height - 13:g}" class="tick">{words}</text>')
    return "".join(parts)


def _dot(left: float, y: float, m: int, model: str, score: dict[str, Any]) -> str:
    balanced = score.get("balanced_accuracy")
    if balanced is None:
        if m:
            return ""
        return f'<text x="{left + 6:g}" y="{y + 12:g}" class="none">undefined: one class</text>'
    low, high = (_x(left, float(v)) for v in score["interval"])
    x = _x(left, float(balanced))
    shape = (
        f'<circle cx="{x:g}" cy="{y:g}" r="5"/>'
        if m % 2 == 0
        else f'<rect x="{x - 4.6:g}" y="{y - 4.6:g}" width="9.2" height="9.2"/>'
    )
    said = f"{escape(model)}: {100 * float(balanced):.0f} % of balanced accuracy"
    return (
        f'<g class="m{m % 4}"><title>{said}</title>'
        f'<line x1="{low:g}" x2="{high:g}" y1="{y:g}" y2="{y:g}"/>{shape}</g>'
    )
