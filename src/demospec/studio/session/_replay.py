"""What a journal's events make of the demonstrations that were there before."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from demospec.demonstrations import Demonstration, checked_points, object_from_json
from demospec.errors import InputError
from demospec.scene import Picture, Polygon, Relation, Scene, SceneObject
from demospec.studio.session._joining import Joined, joined_of
from demospec.studio.session._journal import Event, effective

UNNAMED = "unnamed "
"""Begins the class word of an object that was found and that nobody has named."""


@dataclass(frozen=True)
class Taught:
    """Scenes and demonstrations as they stand.

    Args:
        scenes: The set's, then those that were added.
        demonstrations: The set's, then those drawn; in the order in which they came.
        unlisted: Ids of scenes that came without a list of objects: people may make it.
        labelled: Demonstration → number of the event that gave it its label; none for the set's.
        kept: Rejected demonstration → number of the event in which a person said that it and
            what contradicted it then are both right.
        renamed: Scene → the name that it came with, where it has another now.
        together: Scene → what it is compared as where it has no scale; see `Joined`.
    """

    scenes: Mapping[str, Scene]
    demonstrations: Mapping[str, Demonstration]
    unlisted: frozenset[str] = frozenset()
    labelled: Mapping[str, int] = field(default_factory=dict)
    kept: Mapping[str, int] = field(default_factory=dict)
    renamed: Mapping[str, str] = field(default_factory=dict)
    together: Mapping[str, str] = field(default_factory=dict)

    def came_as(self, scene_id: str) -> str:
        """The name that a scene came with."""
        return self.renamed.get(scene_id, scene_id)

    def in_scene(self, scene_id: str) -> list[Demonstration]:
        """Those of one scene."""
        return [d for d in self.demonstrations.values() if d.scene_id == scene_id]


def taught(
    scenes: Iterable[Scene],
    before: Iterable[Demonstration],
    events: Sequence[Event],
    parsed: dict[int, Scene | Demonstration | Joined] | None = None,
) -> Taught:
    """Applies the events that stand.

    An event about a demonstration that is gone (another tab took it back) does nothing.

    Args:
        parsed: What events were decoded to before, by number; new ones are added.
    """
    cache = {} if parsed is None else parsed
    all_scenes = {s.scene_id: s for s in scenes}
    demos = {d.demo_id: d for d in before}
    unlisted = {s.scene_id for s in all_scenes.values() if s.objects is None}
    labelled: dict[str, int] = {}
    kept: dict[str, int] = {}
    renamed: dict[str, str] = {}
    together: dict[str, str] = {}
    for event in effective(events):
        body = event.body
        if event.kind == "scene":
            if event.seq not in cache:
                cache[event.seq] = scene_of(body, event.blob)
            scene = cache[event.seq]
            assert isinstance(scene, Scene)
            all_scenes[scene.scene_id] = scene
            if scene.objects is None:
                unlisted.add(scene.scene_id)
        elif event.kind in SCENE_CHANGES:
            known = all_scenes.get(body["scene_id"])
            if known is not None:
                all_scenes[known.scene_id] = SCENE_CHANGES[event.kind](known, body)
        elif event.kind in ("drop_scene", "rename_scene"):
            if body["scene_id"] in all_scenes:
                _reorder_scenes(all_scenes, demos, unlisted, renamed, event)
                if body["scene_id"] in together and "name" in body:
                    together[body["name"]] = together[body["scene_id"]]
        elif event.kind == "merge_scenes":
            if {body["scene_id"], body["into"]} <= set(all_scenes):
                del all_scenes[body["scene_id"]]
                for d in [d for d in demos.values() if d.scene_id == body["scene_id"]]:
                    demos[d.demo_id] = replace(d, scene_id=body["into"])
        elif event.kind == "import":
            if event.seq not in cache:
                cache[event.seq] = joined_of(body, event.blob)
            joined = cache[event.seq]
            assert isinstance(joined, Joined)
            for scene in joined.scenes:
                all_scenes[scene.scene_id] = scene
                together[scene.scene_id] = joined.together
                if scene.objects is None:
                    unlisted.add(scene.scene_id)
            for brought in joined.demonstrations:
                if brought.scene_id in all_scenes:
                    demos[brought.demo_id] = brought
                    labelled[brought.demo_id] = event.seq
        elif event.kind == "keep":
            kept |= dict.fromkeys(body["demo_ids"], event.seq)
        elif event.kind == "add":
            if event.seq not in cache:
                cache[event.seq] = demonstration_of(body)
            demo = cache[event.seq]
            assert isinstance(demo, Demonstration)
            if demo.scene_id in all_scenes:
                demos[demo.demo_id] = demo
                labelled[demo.demo_id] = event.seq
        else:
            _change_demonstrations(demos, labelled, event)
    return Taught(all_scenes, demos, frozenset(unlisted), labelled, kept, renamed, together)


def _reorder_scenes(
    scenes: dict[str, Scene],
    demos: dict[str, Demonstration],
    unlisted: set[str],
    renamed: dict[str, str],
    event: Event,
) -> None:
    """A scene that goes with its demonstrations, or that gets another name."""
    old = event.body["scene_id"]
    if event.kind == "drop_scene":
        del scenes[old]
        for name in [n for n, d in demos.items() if d.scene_id == old]:
            del demos[name]
        return
    new = event.body["name"]
    kept = {new if n == old else n: s for n, s in scenes.items()}
    scenes.clear()
    scenes.update(kept)
    scenes[new] = replace(scenes[new], scene_id=new)
    renamed[new] = renamed.pop(old, old)
    if old in unlisted:
        unlisted.add(new)
    for name, demo in demos.items():
        if demo.scene_id == old:
            demos[name] = replace(demo, scene_id=new)


def _change_demonstrations(
    demos: dict[str, Demonstration], labelled: dict[str, int], event: Event
) -> None:
    """Labels, edits and deletions, of one demonstration or of many."""
    body = event.body
    changes = body.get("changes", {})
    if event.kind == "label":
        changes = {"valid": body["valid"]}
    for name in body["demo_ids"] if event.kind == "many" else (body["demo_id"],):
        if name not in demos:
            continue
        if event.kind == "delete" or body.get("delete"):
            del demos[name]
            continue
        demos[name] = replace(demos[name], **changes)
        if "valid" in changes:
            labelled[name] = event.seq


def _mark(scene: Scene, body: Mapping[str, Any]) -> Scene:
    """The scene with objects that somebody marked in it."""
    added = tuple(object_from_json(o) for o in body["objects"])
    return replace(scene, objects=(*(scene.objects or ()), *added))


def _unmark(scene: Scene, body: Mapping[str, Any]) -> Scene:
    """Without one; none marked: not listed, not an empty table."""
    rest = tuple(o for o in scene.objects or () if o.id != body["id"])
    return replace(scene, objects=rest or None)


def _change_object(scene: Scene, body: Mapping[str, Any]) -> Scene:
    """One object as somebody named or outlined it anew."""
    new = object_from_json(body["object"])
    changed = tuple(new if o.id == body["id"] else o for o in scene.objects or ())
    return replace(scene, objects=changed or None)


def _move_ends(scene: Scene, body: Mapping[str, Any]) -> Scene:
    return replace(scene, start=tuple(body["start"]), goal=tuple(body["goal"]))


def _measure(scene: Scene, body: Mapping[str, Any]) -> Scene:
    return replace(scene, metres_per_unit=body["metres_per_unit"])


SCENE_CHANGES: Mapping[str, Callable[[Scene, Mapping[str, Any]], Scene]] = {
    "mark": _mark, "unmark": _unmark, "object": _change_object, "ends": _move_ends,
    "scale": _measure,
}  # fmt: skip


def demonstration_of(body: Mapping[str, Any]) -> Demonstration:
    """A demonstration from an event or a request; see `demonstration_body`."""
    t = body.get("t")
    return Demonstration(
        demo_id=body["demo_id"],
        scene_id=body["scene_id"],
        points=checked_points(body["points"]),
        type=body.get("type"),
        demonstrator=body.get("demonstrator"),
        valid=body.get("valid"),
        t=None if t is None else np.asarray(t, dtype=np.float64),
    )


def demonstration_body(demo: Demonstration) -> dict[str, Any]:
    """The JSON object of one demonstration."""
    return {
        "demo_id": demo.demo_id,
        "scene_id": demo.scene_id,
        "type": demo.type,
        "demonstrator": demo.demonstrator,
        "valid": demo.valid,
        "points": demo.points.tolist(),
        "t": None if demo.t is None else demo.t.tolist(),
    }


def scene_of(body: Mapping[str, Any], blob: bytes | None) -> Scene:
    """A scene from an event: the picture travels beside it, as PNG."""
    picture = None
    if blob is not None:
        import PIL.Image

        with PIL.Image.open(io.BytesIO(blob), formats=("PNG",)) as image:
            picture = Picture(array=np.asarray(image.convert("RGB")))
    objects = body.get("objects")
    return Scene(
        scene_id=body["scene_id"],
        start=tuple(body["start"]),
        goal=tuple(body["goal"]),
        objects=None if objects is None else tuple(object_from_json(o) for o in objects),
        picture=picture,
        split=body.get("split", "train"),
        metres_per_unit=body.get("metres_per_unit"),
        relations=tuple(
            Relation(str(r["kind"]), (str(r["between"][0]), str(r["between"][1])))
            for r in body.get("relations", ())
        ),
    )


def scene_body(scene: Scene) -> dict[str, Any]:
    """The JSON object of one scene, without its picture."""
    objects = None if scene.objects is None else [o.to_json() for o in scene.objects]
    return {
        "scene_id": scene.scene_id,
        "start": list(scene.start),
        "goal": list(scene.goal),
        "split": scene.split,
        "size_px": None if scene.size_px is None else list(scene.size_px),
        "objects": objects,
        "relations": [r.to_json() for r in scene.relations],
        "metres_per_unit": scene.metres_per_unit,
    }


def object_about(name: str, symbol: str, points: Any, scene: Scene) -> SceneObject:
    """An object whose footprint is the convex hull of points drawn about it, pixels.

    Raises:
        InputError: Not points, outside the picture, or hardly any area.
    """
    from scipy.spatial import ConvexHull, QhullError

    loop = checked_points(points, 2)
    size = scene.size_px
    if size is not None and ((loop < -1).any() or (loop > np.asarray(size) + 1).any()):
        raise InputError("points in the picture", "others", field="outline")
    span = np.ptp(loop, axis=0)
    try:
        corners = loop[ConvexHull(loop).vertices] if span.min() > 0 else loop[:0]
    except QhullError:
        corners = loop[:0]
    if len(corners) < 3 or span.min() < span.max() / 50:
        raise InputError("a loop around the object", "a line", field="outline")
    corners = np.round(corners, 2)
    low, high = corners.min(axis=0), corners.max(axis=0)
    center = (float((low[0] + high[0]) / 2), float((low[1] + high[1]) / 2))
    box = (float(low[0]), float(low[1]), *(float(v) for v in high - low))
    return SceneObject(name, symbol, center, box, Polygon(corners))  # type: ignore[arg-type]


def png_of(scene: Scene) -> bytes | None:
    """The picture as PNG, or None without one."""
    if scene.picture is None:
        return None
    import PIL.Image

    buffer = io.BytesIO()
    PIL.Image.fromarray(np.asarray(scene.pixels())).save(buffer, format="PNG")
    return buffer.getvalue()
