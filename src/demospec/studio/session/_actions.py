"""What people do in a session: every action is checked, kept in the journal, and can be undone."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    checked_points,
)
from demospec.errors import InputError
from demospec.geometry import Polygon
from demospec.scene import Scene
from demospec.studio.session._joining import free, in_session, packed
from demospec.studio.session._journal import Event, Journal
from demospec.studio.session._replay import (
    Taught,
    demonstration_body,
    object_about,
    png_of,
    scene_body,
)

MAX_STROKE_POINTS = 5000
"""Longest stroke that is taken from a browser or a request."""

SMALLEST_M, LARGEST_M = 1e-6, 10.0
"""Metres that one pixel of a picture can be wide."""


class Actions:
    """The actions. `actor` is the browser tab (or ``api``): undo undoes one's own."""

    journal: Journal
    _lock: threading.RLock
    _listeners: list[Callable[[], None]]

    @property
    def standing(self) -> Taught:
        raise NotImplementedError

    @property
    def units(self) -> str:
        raise NotImplementedError

    @property
    def metres_per_unit(self) -> float | None:
        raise NotImplementedError

    @property
    def columns(self) -> tuple[str, ...]:
        raise NotImplementedError

    @property
    def y(self) -> str:
        raise NotImplementedError

    @property
    def symbols(self) -> tuple[str, ...]:
        raise NotImplementedError

    def basis_of(self, scene_id: str) -> str:
        raise NotImplementedError

    def scene(self, scene_id: str) -> Scene:
        """The scene of that id; InputError where there is none."""
        found = self.standing.scenes.get(scene_id)
        if found is None:
            known = ", ".join(list(self.standing.scenes)[:8])
            raise InputError(f"a scene ({known}, …)", scene_id, field="scene_id")
        return found

    def draw(
        self,
        scene_id: str,
        points: Any,
        *,
        actor: str,
        type: str | None = None,
        demonstrator: str | None = None,
        valid: bool | None = None,
        t: Sequence[float] | None = None,
    ) -> Demonstration:
        """Keeps a new demonstration and returns it under its new id.

        Raises:
            InputError: No such scene; not a path; outside the picture.
        """
        scene = self.scene(scene_id)
        path = checked_points(points, 2)
        if not 2 <= len(path) <= MAX_STROKE_POINTS:
            found = f"{len(path)} points"
            raise InputError(f"2 to {MAX_STROKE_POINTS} points", found, field="points")
        if t is not None and len(t) != len(path):
            raise InputError(f"{len(path)} times", len(t), field="t")
        with self._lock, self.journal.alone():
            demo = Demonstration(
                self.next_id(), scene.scene_id, path, _word(type, "type"),
                _word(demonstrator, "demonstrator"), valid,
                None if t is None else _times(t),
            )  # fmt: skip
            # The set that this would make is checked before anything is kept.
            DemonstrationSet(
                (scene,), Demonstrations.of([demo]), units=self.units, symbols=self.symbols,
                types=(demo.type,) if demo.type else (),
            )  # fmt: skip
            self.journal.append_within("add", demonstration_body(demo), actor=actor)
        self._changed()
        return demo

    def next_id(self) -> str:
        """The id that the next demonstration will have, unless another process draws first."""
        taken = self._taken_ids()
        number = 1
        while f"drawn-{number:04d}" in taken:
            number += 1
        return f"drawn-{number:04d}"

    def _taken_ids(self) -> set[str]:
        """Ids of demonstrations that stand, stood, or may stand again."""
        taken = set(self.standing.demonstrations)
        for event in self.journal.events():
            if event.kind == "import":
                taken |= set(event.body["demo_ids"].values())
            elif "demo_id" in event.body:
                taken.add(str(event.body["demo_id"]))
        return taken

    def fitted(
        self, data: DemonstrationSet, onto: str = ""
    ) -> tuple[DemonstrationSet, tuple[str, ...]]:
        """A set as it would join this session, and in words what changes.

        Args:
            onto: The scene here that its paths would go to; nothing: its own scenes come too.

        Raises:
            InputError: Its lengths cannot be said in the unit of this session or scene.
        """
        fitted, said = in_session(
            data, units=self.units, y=self.y, scale=self.metres_per_unit, columns=self.columns
        )
        if onto:
            scene = self.scene(onto)
            if data.units != self.units:
                expected = f"paths in {self.units}, as this table"
                found = f"{data.units}: nobody has said where its origin lies on this table"
                raise InputError(expected, found, field="onto")
            demos = [replace(d, scene_id=onto) for d in fitted.demonstrations]
            replace(
                fitted, scenes=(replace(scene, metres_per_unit=None),),
                demonstrations=Demonstrations.of(demos, len(self.columns)),
                symbols=self.symbols,
            )  # fmt: skip
        return fitted, said

    def take_in(
        self, data: DemonstrationSet, *, actor: str, source: str, onto: str = ""
    ) -> tuple[str, ...]:
        """Takes a whole set into the session; returns the ids that its paths have here.

        Args:
            source: Where it came from, for the history.
            onto: As of `fitted`.
        """
        fitted, _ = self.fitted(data, onto)
        blob = packed(fitted)
        with self._lock, self.journal.alone():
            scenes = set(self.standing.scenes)
            names: dict[str, str] = {}
            for scene in fitted.scenes:
                names[scene.scene_id] = free(scene.scene_id, scenes)
                scenes.add(names[scene.scene_id])
            taken, ids = self._taken_ids(), {}
            for demo in fitted.demonstrations:
                ids[demo.demo_id] = free(demo.demo_id, taken)
                taken.add(ids[demo.demo_id])
            body = {
                "source": source[:60], "scenes": names, "demo_ids": ids, "onto": onto or None,
                "together": free(f"scenes of {source[:60]}", self._togethers()),
            }  # fmt: skip
            self.journal.append_within("import", body, actor=actor, blob=blob)
        self._changed()
        return tuple(ids.values())

    def _togethers(self) -> set[str]:
        return {str(e.body["together"]) for e in self.journal.events() if e.kind == "import"}

    def label(self, demo_id: str, valid: bool | None, *, actor: str) -> None:
        """Accepts (True), rejects (False) or takes back the verdict (None)."""
        self._must_stand(demo_id)
        self.journal.append("label", {"demo_id": demo_id, "valid": valid}, actor=actor)
        self._changed()

    def edit(self, demo_id: str, *, actor: str, **changes: str | None) -> None:
        """Changes ``type`` or ``demonstrator``."""
        self._must_stand(demo_id)
        for key, word in changes.items():
            if key not in ("type", "demonstrator"):
                raise InputError("type or demonstrator", key, field="changes")
            _word(word, key)
        self.journal.append("edit", {"demo_id": demo_id, "changes": changes}, actor=actor)
        self._changed()

    def delete(self, demo_id: str, *, actor: str) -> None:
        """Takes a demonstration away; undo brings it back."""
        self._must_stand(demo_id)
        self.journal.append("delete", {"demo_id": demo_id}, actor=actor)
        self._changed()

    def add_scene(self, scene: Scene, *, actor: str) -> None:
        """Adds a scene; its id must be new."""
        if scene.scene_id in self.standing.scenes:
            raise InputError("a new scene id", scene.scene_id, field="scene_id")
        self.journal.append("scene", scene_body(scene), actor=actor, blob=png_of(scene))
        self._changed()

    def may_mark(self, scene_id: str) -> bool:
        """Whether people may list this scene's objects: where the set does not."""
        return scene_id in self.standing.unlisted

    def mark(
        self, scene_id: str, found: Sequence[tuple[str, Any]], *, actor: str
    ) -> tuple[str, ...]:
        """Lists objects of a scene; returns their new ids.

        Args:
            found: Class word and points about the object, (n, 2) pixels; their convex hull is
                its footprint.

        Raises:
            InputError: The set lists this scene's objects; not a word; not a loop.
        """
        scene = self.scene(scene_id)
        if not self.may_mark(scene_id):
            raise InputError("a scene whose objects are not listed", scene_id, field="scene_id")
        with self._lock, self.journal.alone():
            taken = {o.id for o in self.standing.scenes[scene_id].objects or ()}
            things = []
            for word, points in found:
                symbol = _word(word, "symbol")
                if symbol is None:
                    raise InputError("a word for the object", "none", field="symbol")
                number = 0
                while f"{symbol}-{number}" in taken:
                    number += 1
                taken.add(f"{symbol}-{number}")
                things.append(object_about(f"{symbol}-{number}", symbol, points, scene))
            body = {"scene_id": scene_id, "objects": [o.to_json() for o in things]}
            self.journal.append_within("mark", body, actor=actor)
        self._changed()
        return tuple(o.id for o in things)

    def unmark(self, scene_id: str, object_id: str, *, actor: str) -> None:
        """Takes a marked object off the list."""
        listed = {o.id for o in self.scene(scene_id).objects or ()}
        if not self.may_mark(scene_id) or object_id not in listed:
            raise InputError("an object that was marked", object_id, field="id")
        body = {"scene_id": scene_id, "id": object_id}
        self.journal.append("unmark", body, actor=actor)
        self._changed()

    def keep(self, demo_ids: Sequence[str], *, actor: str) -> None:
        """Says of demonstrations that they and what contradicts them are right."""
        for name in demo_ids:
            self._must_stand(name)
        self.journal.append("keep", {"demo_ids": list(demo_ids)}, actor=actor)
        self._changed()

    def change(self, demo_ids: Sequence[str], changes: Mapping[str, Any], *, actor: str) -> None:
        """Changes ``valid``, ``type`` or ``demonstrator`` of many demonstrations at once."""
        for name in demo_ids:
            self._must_stand(name)
        kept: dict[str, Any] = {}
        for key, value in changes.items():
            if key == "valid" and (value is None or isinstance(value, bool)):
                kept[key] = value
            elif key in ("type", "demonstrator") and (value is None or isinstance(value, str)):
                kept[key] = _word(value, key)
            else:
                raise InputError("valid, type or demonstrator", {key: value}, field="changes")
        if not demo_ids or not kept:
            raise InputError("demonstrations and what to change", "none", field="demo_ids")
        self._append("many", {"demo_ids": list(demo_ids), "changes": kept}, actor)

    def delete_many(self, demo_ids: Sequence[str], *, actor: str) -> None:
        """Takes many demonstrations away at once; undo brings them back."""
        for name in demo_ids:
            self._must_stand(name)
        if not demo_ids:
            raise InputError("demonstrations", "none", field="demo_ids")
        self._append("many", {"demo_ids": list(demo_ids), "delete": True}, actor)

    def change_object(
        self,
        scene_id: str,
        object_id: str,
        *,
        actor: str,
        symbol: str | None = None,
        outline: Any = None,
        heading_deg: float | None = None,
    ) -> None:
        """Names or outlines a marked object anew.

        Args:
            outline: (n, 2) corners, pixels; taken as they are.
            heading_deg: The direction that it faces, from +x towards +y.

        Raises:
            InputError: Not a marked object; not a word; not an outline inside the picture.
        """
        scene = self._marked(scene_id, object_id)
        item = next(o for o in scene.objects or () if o.id == object_id)
        if symbol is not None:
            item = replace(item, symbol=_word(symbol, "symbol") or item.symbol)
        if outline is not None:
            corners = checked_points(outline, 2)
            inside_picture(corners, scene)
            shape = Polygon(np.round(corners, 3))
            x0, y0, x1, y1 = (float(v) for v in shape.bounds)
            item = replace(
                item, footprint=shape, center=((x0 + x1) / 2, (y0 + y1) / 2),
                bbox=(x0, y0, x1 - x0, y1 - y0),
            )  # fmt: skip
        if heading_deg is not None:
            item = replace(item, heading_deg=float(heading_deg) % 360.0)
        body = {"scene_id": scene_id, "id": object_id, "object": item.to_json()}
        self._append("object", body, actor)

    def move_ends(
        self, scene_id: str, start: Sequence[float], goal: Sequence[float], *, actor: str
    ) -> None:
        """Puts start and goal elsewhere on the table."""
        scene = self.scene(scene_id)
        ends = checked_points([start, goal], 2)
        inside_picture(ends, scene)
        if np.allclose(ends[0], ends[1]):
            raise InputError("a goal elsewhere than the start", list(goal), field="goal")
        rest = scene.start[2:], scene.goal[2:]
        body = {
            "scene_id": scene_id,
            "start": [*(float(v) for v in ends[0]), *rest[0]],
            "goal": [*(float(v) for v in ends[1]), *rest[1]],
        }
        self._append("ends", body, actor)

    def measure(self, scene_id: str, metres_per_unit: float | None, *, actor: str) -> None:
        """Says how wide a pixel of a scene's picture is on the table, or takes that back.

        Raises:
            InputError: Not a picture, or no such width.
        """
        if self.scene(scene_id).picture is None:
            raise InputError("a scene with a picture", "none", field="scene_id")
        if metres_per_unit is not None:
            wide = float(metres_per_unit)
            if not SMALLEST_M <= wide <= LARGEST_M:  # also not a number
                expected = f"a pixel between {SMALLEST_M:g} m and {LARGEST_M:g} m wide"
                raise InputError(expected, metres_per_unit, field="metres_per_unit")
        body = {"scene_id": scene_id, "metres_per_unit": metres_per_unit}
        self._append("scale", body, actor)

    def drop_scene(self, scene_id: str, *, actor: str) -> None:
        """Takes a scene away, with its demonstrations; undo brings them back."""
        self.scene(scene_id)
        if len(self.standing.scenes) == 1:
            raise InputError("a scene that is left", "the only one", field="scene_id")
        self._append("drop_scene", {"scene_id": scene_id}, actor)

    def rename_scene(self, scene_id: str, name: str, *, actor: str) -> None:
        """Gives a scene another name."""
        self.scene(scene_id)
        word = _word(name, "name")
        if word is None or word in self.standing.scenes:
            raise InputError("a name that no scene has", name, field="name")
        self._append("rename_scene", {"scene_id": scene_id, "name": word}, actor)

    def merge_scenes(self, scene_id: str, into: str, *, actor: str) -> None:
        """Gives all paths of a scene to another, and takes the scene away.

        Raises:
            InputError: No such scenes; lengths on the two are not the same; a path would lie
                off the other table.
        """
        one, other = self.scene(scene_id), self.scene(into)
        if scene_id == into:
            raise InputError("two scenes", "one", field="into")
        same = self.basis_of(scene_id) == self.basis_of(into)
        if not same or one.metres_per_unit != other.metres_per_unit:
            raise InputError("two pictures of one scale", "others", field="into")
        for demo in self.standing.in_scene(scene_id):
            inside_picture(demo.xy, other)
        self._append("merge_scenes", {"scene_id": scene_id, "into": into}, actor)

    def undo(self, actor: str) -> Event | None:
        """Takes back the actor's last action; what it was, or None."""
        event = self.journal.undo(actor)
        self._changed()
        return event

    def redo(self, actor: str) -> Event | None:
        """Does it again; what it was, or None."""
        event = self.journal.redo(actor)
        self._changed()
        return event

    def _append(self, kind: str, body: Mapping[str, Any], actor: str) -> None:
        self.journal.append(kind, body, actor=actor)
        self._changed()

    def _marked(self, scene_id: str, object_id: str) -> Scene:
        scene = self.scene(scene_id)
        if not self.may_mark(scene_id) or all(o.id != object_id for o in scene.objects or ()):
            raise InputError("an object that was marked", object_id, field="id")
        return scene

    def _must_stand(self, demo_id: str) -> None:
        if demo_id not in self.standing.demonstrations:
            raise InputError("a demonstration that is there", demo_id, field="demo_id")

    def _changed(self) -> None:
        for listener in list(self._listeners):
            listener()


def inside_picture(points: Any, scene: Scene) -> None:
    """InputError where points lie outside the picture."""
    size = scene.size_px
    if size is not None and ((points < -1).any() or (points > np.asarray(size) + 1).any()):
        raise InputError("points in the picture", "others", field="points")


def _word(word: str | None, field: str) -> str | None:
    if word is None or word == "":
        return None
    if len(word) > 60 or not word.isprintable():
        raise InputError("a name of at most 60 printable characters", word, field=field)
    return word


def _times(t: Sequence[float]) -> Any:
    import numpy as np

    stamps = np.asarray(t, dtype=np.float64)
    if not np.isfinite(stamps).all() or (np.diff(stamps) < 0).any():
        raise InputError("finite times that do not fall", "others", field="t")
    return stamps
