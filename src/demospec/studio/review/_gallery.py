"""All paths of all scenes as small pictures: filtered, a page at a time; and who did what."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from demospec.demonstrations import Demonstration
from demospec.report import short_name
from demospec.scene import Scene
from demospec.studio.session._journal import Event, effective
from demospec.studio.session._workspace import Workbench
from demospec.studio.table._endpoints import corners

A_PAGE = 48
MOST_POINTS = 40
"""Points of a path in a small picture."""

VERDICTS = {"accepted": True, "rejected": False, "unsaid": None}

_DID = {
    "add": "drew {what}", "label": "judged {what}", "edit": "changed {what}",
    "delete": "deleted {what}", "many": "changed {count} paths", "keep": "kept {what}",
    "scene": "added the scene {scene}", "mark": "marked {objects} in {scene}",
    "unmark": "took {object} off the list of {scene}", "object": "changed {object} in {scene}",
    "ends": "moved start and goal of {scene}", "scale": "measured {scene}",
    "rename_scene": "renamed {scene} to {name}", "drop_scene": "took {scene} away",
    "merge_scenes": "gave the paths of {scene} to {into}",
    "import": "took in {count} paths from {source}",
}  # fmt: skip


def small(demo: Demonstration) -> dict[str, Any]:
    """A path for a small picture."""
    xy = np.asarray(demo.xy)
    if len(xy) > MOST_POINTS:
        xy = xy[np.linspace(0, len(xy) - 1, MOST_POINTS).round().astype(int)]
    return {
        "demo_id": demo.demo_id,
        "name": short_name(demo.demo_id),
        "scene_id": demo.scene_id,
        "type": demo.type,
        "demonstrator": demo.demonstrator,
        "valid": demo.valid,
        "points": [[float(f"{v:.5g}") for v in p] for p in xy],
    }


def frames(bench: Workbench, scene_ids: Collection[str]) -> dict[str, Any]:
    """Scene → what a small picture of it needs."""
    found = {}
    for name in scene_ids:
        found[name] = frame_of(bench.scene(name))
    return found


def frame_of(scene: Scene) -> dict[str, Any]:
    """What a small picture of a scene needs."""
    return {
        "size": scene.size_px,
        "bounds": list(scene.bounds),
        "picture": scene.picture is not None,
        "start": list(scene.start[:2]),
        "goal": list(scene.goal[:2]),
        # A picture shows what stands there.
        "outlines": [] if scene.picture else [corners(o.outline) for o in scene.objects or ()],
    }


def gallery(
    bench: Workbench,
    *,
    type: str = "",
    verdict: str = "",
    scene_id: str = "",
    among: Collection[str] | None = None,
    page: int = 0,
) -> dict[str, Any]:
    """One page of the paths that pass the filters.

    Args:
        verdict: ``accepted``, ``rejected``, ``unsaid``, or nothing: all.
        among: Only these; None: all.
    """
    every = bench.demonstrations
    chosen = [
        d for d in every
        if type in ("", d.type or "")
        and (verdict not in VERDICTS or d.valid is VERDICTS[verdict])
        and scene_id in ("", d.scene_id)
        and (among is None or d.demo_id in among)
    ]  # fmt: skip
    pages = max(1, -(-len(chosen) // A_PAGE))
    page = min(max(page, 0), pages - 1)
    shown = chosen[page * A_PAGE : (page + 1) * A_PAGE]
    return {
        "demonstrations": [small(d) for d in shown],
        "scenes": frames(bench, dict.fromkeys(d.scene_id for d in shown)),
        "count": len(chosen),
        "all": len(every),
        "page": page,
        "pages": pages,
        "types": list(bench.types),
        "scene_ids": [s.scene_id for s in bench.scenes],
        "version": bench.version,
    }


def history(bench: Workbench, actor: str, most: int = 60) -> list[dict[str, Any]]:
    """Who did what, the last thing first; what was undone is said to be."""
    events = bench.journal.events()
    stands = {e.seq for e in effective(events)}
    acts = [e for e in events if e.kind in _DID and e.actor != "studio"]
    return [
        {
            "at": e.at,
            "who": "you, in this tab" if e.actor == actor else _who(e.actor),
            "what": _what(e),
            "undone": e.seq not in stands,
        }
        for e in reversed(acts[-most:])
    ]


def _who(actor: str) -> str:
    return "a program" if actor == "api" else f"another tab ({actor.removeprefix('tab-')[:6]})"


def _what(event: Event) -> str:
    body = event.body
    names: Sequence[str] = list(body.get("demo_ids") or ()) or [str(body.get("demo_id"))]
    objects = body.get("objects") or []
    said = {
        "what": ", ".join(short_name(str(n)) for n in names[:3]) + (" …" if len(names) > 3 else ""),
        "count": len(names),
        "scene": body.get("scene_id"),
        "name": body.get("name"),
        "into": body.get("into"),
        "source": body.get("source"),
        "object": body.get("id"),
        "objects": ", ".join(str(o.get("symbol")) for o in objects[:3]),
    }
    words = _DID[event.kind].format(**said)
    if event.kind in ("label", "add") and body.get("valid") is not None:
        words += " (accepted)" if body["valid"] else " (rejected)"
    if body.get("delete"):
        words = words.replace("changed", "deleted")
    return words
