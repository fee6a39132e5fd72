"""Plans of a run drawn over their scenes, and its videos."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from markupsafe import Markup

from demospec.scene import Scene
from demospec.studio.drawing._scene_svg import marks_svg, scene_svg

SHOWN = 8


def plans(document: dict[str, Any], scenes: Mapping[str, Scene]) -> str:
    """How many plans were found and keep the true rule, and the first few drawn."""
    every = document["plans"]
    found = [p for p in every if p.get("points")]
    judged = [p for p in found if p.get("true_obeys") is not None]
    kept = sum(bool(p["true_obeys"]) for p in judged)
    said = f"Of {len(every)} plans asked for, {len(found)} were found"
    said += f"; {kept} of {len(judged)} keep the demonstrator's true rule." if judged else "."
    # The longest way round first: there the rule has bent the path.
    order = sorted(found, key=lambda p: -float(p["length"]) / max(float(p["straight"]), 1e-9))
    drawn = [p for p in order if p.get("scene") in scenes][:SHOWN]
    figures = "".join(_plan(p, scenes[p["scene"]]) for p in drawn)
    note = f'<p class="soft">The {len(drawn)} that go the longest way round:</p>' if drawn else ""
    return f'<p>{said}</p>{note}<div class="re-plans">{figures}</div>'


def _plan(plan: dict[str, Any], scene: Scene) -> str:
    points = " ".join(f"{float(x):.1f},{float(y):.1f}" for x, y in plan["points"])
    inner = (
        f'<polyline class="re-plan under" points="{points}"/>'
        f'<polyline class="re-plan" points="{points}"/>'
    )
    picture = scene_svg(scene) + marks_svg(scene, Markup(inner))  # noqa: S704  (numbers)
    verdict = {True: "keeps the true rule", False: "breaks the true rule"}.get(
        plan.get("true_obeys"), "not judged"  # type: ignore[arg-type]
    )  # fmt: skip
    longer = 100 * (float(plan["length"]) / max(float(plan["straight"]), 1e-9) - 1)
    return (
        f'<figure><div class="re-over">{picture}</div><figcaption><strong>'
        f"{escape(str(plan['type']))}</strong> in scene {escape(str(plan['scene']))}: "
        f"{longer:.0f}\u00a0% longer than straight, {verdict}</figcaption></figure>"
    )


def videos(files: list[Path]) -> str:
    """Players for GIF and MP4 files, addressed by their number."""
    if not files:
        return (
            '<p class="soft">This run has no video. <code>demospec execute RULES SET --scene ID '
            "--out RUN/execution</code> makes one.</p>"
        )
    parts = []
    for i, file in enumerate(files):
        name = escape(file.name)
        player = (
            f'<img src="/results/media/{i}" alt="Video of the execution {name}">'
            if file.suffix.lower() == ".gif"
            else f'<video src="/results/media/{i}" controls muted loop aria-label="{name}"></video>'
        )
        parts.append(f"<figure>{player}<figcaption>{name}</figcaption></figure>")
    return f'<div class="re-videos">{"".join(parts)}</div>'
