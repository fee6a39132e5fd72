"""What the studio has on its table: scenes, demonstrations, models. No page, no server."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.demonstrations import (
    Demonstration,
    Demonstrations,
    DemonstrationSet,
    ValidityModel,
    read_set,
    simulate_set,
    write_set,
)
from demospec.errors import InputError, OutputError
from demospec.frames import FloatArray
from demospec.scene import Scene
from demospec.studio.session._actions import Actions
from demospec.studio.session._joining import Joined
from demospec.studio.session._journal import Journal
from demospec.studio.session._models import SO_FAR, ModelFiles, RulesSoFar
from demospec.studio.session._replay import Taught, png_of, scene_body, taught
from demospec.studio.session._scales import (
    METRES,
    OtherScale,
    basis_of,
    comparable,
    rules_at,
)

if TYPE_CHECKING:
    from demospec.rules import RuleSet

TYPES = ("me",)
"""User types offered where the set names none."""


class Workbench(Actions):
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
        self._parsed: dict[int, Scene | Demonstration | Joined] = {}
        self._standing: tuple[int, Taught] | None = None
        self._models = ModelFiles(model, run, set_folder)
        self._rules: dict[str, RulesSoFar] = {}
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
        scene = self.scene(scene_id)
        if scene.metres_per_unit is not None or not self.of_set(scene_id):
            return scene.metres_per_unit
        return self.metres_per_unit

    def of_set(self, scene_id: str) -> bool:
        """Whether the scene came with the set that the studio was started with."""
        return self.original is not None and self.standing.came_as(scene_id) in (
            self.original.scene_index
        )

    def basis_of(self, scene_id: str) -> str:
        """What a scene's lengths are compared with; see `comparable`."""
        scale = self.scale_of(scene_id)
        if scale is None and scene_id in self.standing.together:
            return self.standing.together[scene_id]
        return basis_of(self.scene(scene_id), scale, self.of_set(scene_id))

    @property
    def columns(self) -> tuple[str, ...]:
        """What a point holds."""
        return ("x", "y") if self.original is None else self.original.columns

    @property
    def y(self) -> str:
        """Where y points, seen from above: ``up`` or ``down``."""
        return "down" if self.original is None else self.original.axes.y

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
        columns = self.columns
        demos = [_padded(d, len(columns)) for d in shown.values()]
        scales = {name: self.scale_of(name) for name in now.scenes}
        common = self.metres_per_unit
        if self.original is None and len(set(scales.values())) == 1:
            common = next(iter(scales.values()))
        return DemonstrationSet(
            # A scene says its own scale where it is not the set's.
            scenes=tuple(
                replace(s, metres_per_unit=None if scales[name] == common else scales[name])
                for name, s in now.scenes.items()
            ),
            demonstrations=Demonstrations.of(demos, len(columns)),
            name=self.name,
            units=self.units,
            metres_per_unit=common,
            symbols=self.symbols,
            types=self.types,
            columns=columns,
            extra=() if self.original is None else self.original.extra,
            frame=None if self.original is None else self.original.frame,
        )

    def comparable(self, basis: str, *instead: Demonstration) -> DemonstrationSet | None:
        """What is learned from together; None while it has no demonstration.

        Args:
            basis: As of `basis_of`.
            instead: As of `data`.
        """
        data = self.data(*instead)
        bases = {s.scene_id: self.basis_of(s.scene_id) for s in self.scenes}
        return None if data is None else comparable(data, basis, bases)

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
        return {**self._so_far(), **self._models.all()}

    def rule_sets(self) -> Mapping[str, RuleSet]:
        """The `models` that are rule files; no network is loaded for them."""
        return {**self._so_far(), **self._models.rule_files()}

    def model_at(self, name: str, scene_id: str) -> ValidityModel:
        """A model that may look at a scene; rules in the units of that scene.

        Raises:
            InputError: No such model or scene.
            OtherScale: It was made for pictures of another scale, and nobody knows how they
                compare.
        """
        from demospec.rules import RuleSet

        known = self.models()
        if name not in known:
            raise InputError(f"one of {', '.join(known) or 'no models'}", name, field="model")
        model, mine = known[name], self.of_set(scene_id)
        if not isinstance(model, RuleSet):
            if not mine:
                raise OtherScale(f"{name} was fitted to pictures of another table and scale.")
            return model
        basis = self._learned_on(name)
        scale = self.scale_of(scene_id)
        # A rule file speaks of the set's pixels where a scale is missing, and of no others.
        same = basis not in (None, METRES) and basis == self.basis_of(scene_id)
        same |= basis is None and mine and None in (model.metres_per_unit, scale)
        return rules_at(model, self.units, scale, same)

    def rules_of(self, basis: str, scene_id: str) -> RuleSet:
        """The rules of a basis in the units of one of its scenes.

        Raises:
            InputError: There are none.
            OtherScale: The scene is on another basis.
        """
        rules = self.rules(basis)
        if rules is None:
            raise InputError("an accepted or rejected path", "none", field="rules")
        same = basis != METRES and basis == self.basis_of(scene_id)
        return rules_at(rules, self.units, self.scale_of(scene_id), same)

    def in_scene(self, data: DemonstrationSet, scene_id: str, points: Any) -> FloatArray:
        """Points of a set that is learned from (`comparable`) in the units of their scene."""
        scale = self.scale_of(scene_id)
        xy = np.asarray(points, dtype=np.float64)
        if scale is None or data.metres_per_unit is None:
            return xy
        return xy * (data.metres_per_unit / scale)

    def rules(self, basis: str = METRES) -> RuleSet | None:
        """Clearance rules from what stands, or None while there is nothing to learn from.

        Args:
            basis: Of which scenes, as of `basis_of`.
        """
        with self._lock:
            found = self._rules.setdefault(basis, RulesSoFar())
        return found.of(self.version, lambda: self.comparable(basis))

    def bases(self) -> list[str]:
        """Those on which something was shown; scenes of known scale come first."""
        shown = {d.scene_id for d in self.demonstrations}
        found = dict.fromkeys(self.basis_of(s) for s in self.standing.scenes if s in shown)
        return sorted(found, key=lambda basis: basis != METRES)

    def _so_far(self) -> dict[str, RuleSet]:
        learned = {basis: self.rules(basis) for basis in self.bases()}
        return {
            SO_FAR if i == 0 else f"{SO_FAR}, {basis}": rules
            for i, (basis, rules) in enumerate(learned.items())
            if rules is not None
        }

    def _learned_on(self, name: str) -> str | None:
        """The basis of rules that were learned here; None of a file."""
        named = {SO_FAR if i == 0 else f"{SO_FAR}, {b}": b for i, b in enumerate(self.bases())}
        return named.get(name)

    def close(self) -> None:
        self.journal.close()

    def _lay_new_scenes(self) -> None:
        data, _ = simulate_set(train_scenes=12, test_scenes=1, demonstrations=1, seed=0)
        for scene in data.scenes[:12]:
            scaled = replace(scene, metres_per_unit=data.metres_per_unit)
            self.journal.append("scene", scene_body(scaled), actor="studio", blob=png_of(scene))


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
    return replace(demo, points=np.pad(demo.points, ((0, 0), (0, missing))))
