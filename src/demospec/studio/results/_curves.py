"""Accuracy against the number of demonstrations, as `demospec reproduce` measures it, in SVG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

_W, _H, _LEFT, _TOP = 200.0, 130.0, 46.0, 26.0
_STEP_X, _STEP_Y = _W + 44.0, _H + 62.0
_LOW, _HIGH = 0.4, 1.0


def curve_files(run: Path | None) -> list[str]:
    """Names, without ``.json``, of the run's documents that hold such curves."""
    return [] if run is None else sorted(p.stem for p in run.glob("accuracy-*.json"))


def curves(document: Mapping[str, Any]) -> str:
    """A panel for each type, seen and unseen scenes; types of one class are left out."""
    rows: Sequence[Mapping[str, Any]] = document["rows"]
    types = [
        t for t in dict.fromkeys(r["type"] for r in rows)
        if any(r["type"] == t and r["bacc_seen"] is not None for r in rows)
    ]  # fmt: skip
    models = list(dict.fromkeys(r["model"] for r in rows))
    if not types:
        return "<p>No type has both accepted and rejected paths: nothing to draw.</p>"
    most = max(int(r["n"]) for r in rows)
    width, height = _LEFT + len(types) * _STEP_X, _TOP + 2 * _STEP_Y - 24
    parts = [
        f'<svg class="re-chart" viewBox="0 0 {width:g} {height:g}" role="img" aria-label="Balanced '
        'accuracy against demonstrations per scene and type; the table below has the numbers">'
    ]
    for i, kind in enumerate(types):
        for j, where in enumerate(("seen", "unseen")):
            left, top = _LEFT + i * _STEP_X, _TOP + j * _STEP_Y
            parts.append(_axes(left, top, most, f"{kind}, {where} scenes", first=i == 0))
            for m, model in enumerate(models):
                mine = sorted(
                    (int(r["n"]), float(r[f"bacc_{where}"])) for r in rows
                    if (r["model"], r["type"]) == (model, kind) and r[f"bacc_{where}"] is not None
                )  # fmt: skip
                parts.append(_line(left, top, most, mine, m))
    keys = "".join(
        f'<span><i class="m{m % 5}"></i>{escape(str(n))}</span>' for m, n in enumerate(models)
    )
    return f'<div class="re-keys">{keys}</div>{"".join(parts)}</svg>'


def _place(left: float, top: float, most: int, n: float, share: float) -> tuple[float, float]:
    up = (min(max(share, _LOW), _HIGH) - _LOW) / (_HIGH - _LOW)
    return left + _W * n / max(most, 1), top + _H * (1 - up)


def _axes(left: float, top: float, most: int, title: str, *, first: bool) -> str:
    parts = [f'<text x="{left + _W / 2:g}" y="{top - 9:g}" class="title">{escape(title)}</text>']
    for share in (0.5, 0.75, 1.0):
        _, y = _place(left, top, most, 0, share)
        mark = "guess" if share == 0.5 else "grid"
        parts.append(
            f'<line x1="{left:g}" x2="{left + _W:g}" y1="{y:g}" y2="{y:g}" class="{mark}"/>'
        )
        if first:
            words = f"{100 * share:.0f} %"
            parts.append(f'<text x="{left - 22:g}" y="{y + 4:g}" class="tick">{words}</text>')
    for n in sorted({0, most // 2, most}):
        x, y = _place(left, top, most, n, _LOW)
        parts.append(f'<text x="{x:g}" y="{y + 14:g}" class="tick">{n}</text>')
    return "".join(parts)


def _line(left: float, top: float, most: int, points: list[tuple[int, float]], m: int) -> str:
    at = [_place(left, top, most, n, share) for n, share in points]
    if not at:
        return ""
    drawn = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
    dots = "".join(
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3"/>' if m % 2 == 0
        else f'<rect x="{x - 2.8:.1f}" y="{y - 2.8:.1f}" width="5.6" height="5.6"/>'
        for x, y in at
    )  # fmt: skip
    return f'<g class="m{m % 5} curve"><polyline points="{drawn}"/>{dots}</g>'
