"""What the studio has on its table: scenes, demonstrations, models. No page, no server."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    ValidityModel,
    checked_points,
    read_set,
    simulate_set,
    write_set,
)
from demospec.errors import InputError, OutputError
from demospec.scene import Scene
from demospec.studio.session._journal import Event, Journal
from demospec.studio.session._models import SO_FAR, ModelFiles, RulesSoFar
from demospec.studio.session._replay import (
    Taught,
    demonstration_body,
    object_about,
    png_of,
    scene_body,
    taught,
)

if TYPE_CHECKING:
    from demospec.rules import RuleSet

MAX_STROKE_POINTS = 5000
"""Longest stroke that is taken from a browser or a request."""

TYPES = ("me",)
"""User types offered where the set names none."""


class Workbench:
    """Everything the pages and the API share; safe to use from any thread.

    Args:
        set_folder: The set to start from; it is never changed. None: new simulated scenes.
        model: A model folder or a rule file to explore with, or None.
        run: A run folder of ``demo`` or ``reproduce``, or None.
        out: The set to write. By default beside the set, its name with ``-taught``; without
            a set, ``taught`` in the current folder. Its journal is ``OUT.journal``.
        scenes_only: Leave the set's demonstrations aside and start teaching anew.

    Raises:
        InputError: The set cannot be read, or the journal is about another set.
        OutputError: `out` exists and no journal of ours is beside it.
    """

    def __init__(
        self,
        set_folder: Path | None = None,
        model: Path | None = None,
        run: Path | None = None,
        *,
        out: Path | None = None,
        scenes_only: bool = False,
    ) -> None:
        if run is not None and not run.is_dir():
            raise InputError("a run folder of demo or reproduce", "no such folder", file=run)
        if model is not None and not model.exists():
            raise InputError("a model folder or rule file", "nothing there", file=model)
        if set_folder is None and run is not None and (run / "set" / "dataset.json").is_file():
            set_folder = run / "set"
        self.set_folder = set_folder
        self.run_folder = run
        self.original = None if set_folder is None else read_set(set_folder)
        """The set as it was read, or None."""
        self.out = out or _beside(set_folder)
        file = self.out.with_name(self.out.name + ".journal")
        if not file.exists() and self.out.exists() and any(self.out.iterdir()):
            raise OutputError(f"{self.out}: exists without a journal (choose another --out)")
        self._lock = threading.RLock()
        self._parsed: dict[int, Scene | Demonstration] = {}
        self._standing: tuple[int, Taught] | None = None
        self._models = ModelFiles(model, run, set_folder)
        self._rules = RulesSoFar()
        self._listeners: list[Callable[[], None]] = []
        before = () if scenes_only or self.original is None else self.original.demonstrations
        self.before: tuple[Demonstration, ...] = tuple(before)
        """The demonstrations that the set came with."""
        self.journal = Journal(file, _digest(self.original, scenes_only))
        try:
            if not self.scenes:  # a damaged journal is refused here, in one line
                self._lay_new_scenes()
        except InputError:
            self.journal.close()
            raise

    @property
    def name(self) -> str:
        """The name of the set."""
        return self.original.name if self.original is not None else self.out.name

    @property
    def units(self) -> str:
        return "px" if self.original is None else self.original.units

    @property
    def metres_per_unit(self) -> float | None:
        return None if self.original is None else self.original.metres_per_unit

    def scale_of(self, scene_id: str) -> float | None:
        """Metres per unit of one scene, or None where nobody has said it."""
        self.scene(scene_id)
        return self.metres_per_unit

    @property
    def standing(self) -> Taught:
        """Scenes and demonstrations as they stand, also after other processes' events."""
        with self._lock:
            events = self.journal.events()
            if self._standing is None or self._standing[0] != len(events):
                scenes = () if self.original is None else self.original.scenes
                try:
                    now = taught(scenes, self.before, events, self._parsed)
                except (KeyError, TypeError, ValueError, IndexError, OSError) as error:
                    found = f"{type(error).__name__} {error}"
                    expected = "events as the studio writes them"
                    raise InputError(expected, found, file=self.journal.file) from error
                self._standing = (len(events), now)
            return self._standing[1]

    @property
    def version(self) -> int:
        """Grows with every event, whoever wrote it."""
        return len(self.journal.events())

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """All scenes, in order."""
        return tuple(self.standing.scenes.values())

    def scene(self, scene_id: str) -> Scene:
        """The scene of that id; InputError where there is none."""
        found = self.standing.scenes.get(scene_id)
        if found is None:
            known = ", ".join(list(self.standing.scenes)[:8])
            raise InputError(f"a scene ({known}, …)", scene_id, field="scene_id")
        return found

    @property
    def demonstrations(self) -> tuple[Demonstration, ...]:
        """All demonstrations, in the order in which they came; maybe none."""
        return tuple(self.standing.demonstrations.values())

    @property
    def types(self) -> tuple[str, ...]:
        """User types: the set's, then those that people named."""
        first = TYPES if self.original is None else self.original.types
        return tuple(dict.fromkeys([*first, *(d.type for d in self.demonstrations if d.type)]))

    @property
    def symbols(self) -> tuple[str, ...]:
        """Class words: the set's, then those of scenes that were added."""
        first = () if self.original is None else self.original.symbols
        found = (o.symbol for s in self.scenes for o in s.objects or ())
        return tuple(dict.fromkeys([*first, *found]))

    def data(self, *instead: Demonstration) -> DemonstrationSet | None:
        """The set as it stands, or None while there is no demonstration.

        Args:
            instead: As if these stood in it too, in the place of those of the same id.
        """
        now = self.standing
        shown = {**now.demonstrations, **{d.demo_id: d for d in instead}}
        if not shown:
            return None
        columns = ("x", "y") if self.original is None else self.original.columns
        demos = [_padded(d, len(columns)) for d in shown.values()]
        return DemonstrationSet(
            scenes=tuple(now.scenes.values()),
            demonstrations=Demonstrations.of(demos, len(columns)),
            name=self.name,
            units=self.units,
            metres_per_unit=self.metres_per_unit,
            symbols=self.symbols,
            types=self.types,
            columns=columns,
            extra=() if self.original is None else self.original.extra,
        )

    # What people do. `actor` is the browser tab (or ``api``): undo undoes one's own.

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
        taken = set(self.standing.demonstrations) | {
            str(e.body.get("demo_id")) for e in self.journal.events()
        }
        number = 1
        while f"drawn-{number:04d}" in taken:
            number += 1
        return f"drawn-{number:04d}"

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
        """Says of rejected demonstrations that they and what contradicts them are right."""
        for name in demo_ids:
            self._must_stand(name)
        self.journal.append("keep", {"demo_ids": list(demo_ids)}, actor=actor)
        self._changed()

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

    def on_change(self, listener: Callable[[], None]) -> None:
        """Calls `listener`, from any thread, after every change made in this process."""
        self._listeners.append(listener)

    def write(self) -> Path:
        """Writes the set as it stands to `out`, whole or not at all.

        Raises:
            InputError: There is no demonstration yet.
        """
        # Two processes must not write the folder at once. Nobody who draws or looks waits for
        # that: no lock of theirs is held meanwhile.
        with self.journal.turn():
            data = self.data()
            if data is None:
                raise InputError("at least one demonstration", "none", field="demonstrations")
            return write_set(data, self.out, replace_existing=True)

    def models(self) -> Mapping[str, ValidityModel]:
        """Name → model: what was understood so far, the given model, those of the run, truth.

        Loaded once; the rules understood so far are as they stand now. A model whose library
        is absent is left out.
        """
        so_far = self.rules()
        found = self._models.all()
        return found if so_far is None else {SO_FAR: so_far, **found}

    def rule_sets(self) -> Mapping[str, RuleSet]:
        """The `models` that are rule files; no network is loaded for them."""
        so_far = self.rules()
        found = self._models.rule_files()
        return found if so_far is None else {SO_FAR: so_far, **found}

    def rules(self) -> RuleSet | None:
        """Clearance rules from what stands, or None while there is nothing to learn from."""
        return self._rules.of(self.version, self.data)

    def close(self) -> None:
        self.journal.close()

    def _must_stand(self, demo_id: str) -> None:
        if demo_id not in self.standing.demonstrations:
            raise InputError("a demonstration that is there", demo_id, field="demo_id")

    def _changed(self) -> None:
        for listener in list(self._listeners):
            listener()

    def _lay_new_scenes(self) -> None:
        data, _ = simulate_set(train_scenes=12, test_scenes=1, demonstrations=1, seed=0)
        for scene in data.scenes[:12]:
            self.journal.append("scene", scene_body(scene), actor="studio", blob=png_of(scene))


def _beside(set_folder: Path | None) -> Path:
    if set_folder is None:
        return Path("taught")
    whole = set_folder.resolve()
    return whole.with_name(whole.name + "-taught")


def _digest(data: DemonstrationSet | None, scenes_only: bool) -> str:
    """What a journal is about: its events mean nothing beside another set."""
    if data is None:
        return "new scenes"
    names = [s.scene_id for s in data.scenes]
    if not scenes_only:
        names += list(data.demonstrations.demo_id)
    return hashlib.sha256("\n".join(names).encode()).hexdigest()


def _padded(demo: Demonstration, columns: int) -> Demonstration:
    """A path drawn in the plane, for a set whose points have further columns: they are 0."""
    missing = columns - demo.points.shape[1]
    if missing == 0:
        return demo
    import numpy as np

    return replace(demo, points=np.pad(demo.points, ((0, 0), (0, missing))))


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
