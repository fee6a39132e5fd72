"""What the Explore page asks: a path, a scene that somebody rearranged, and what a model says.

All state of a tab comes with its request, so that tabs cannot disturb one another; what is kept
here are only the last scenes a model looked at.
"""

from __future__ import annotations

import hashlib
import itertools
import secrets
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from demospec.causal import editor_for
from demospec.demonstrations import (
    Demonstration,
    ValidityModel,
    View,
    bezier_points,
    fit_bezier,
)
from demospec.errors import CannotJudgeError, DemospecError, InputError
from demospec.frames import FloatArray
from demospec.scene import Editor, Scene, Template
from demospec.specification import plane_bounds

Kept = TypeVar("Kept")
_VIEWS_KEPT = 12
MOST_EDITS = 64
_RUN, _SERIALS = secrets.token_hex(6), itertools.count()
"""A tab may hold an answer of an earlier explorer, even of a studio started earlier."""


class NoPlace(DemospecError):
    """Nothing more fits on the table: a sentence for the person at the page."""


@dataclass(frozen=True)
class Edits:
    """How a tab rearranged a scene.

    Args:
        moved: Object id → new centre, pixels.
        added: (symbol, x, y) of things put down, pixels; they come last in the scene's list.
        removed: Object ids.
    """

    moved: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    added: tuple[tuple[str, float, float], ...] = ()
    removed: tuple[str, ...] = ()

    @property
    def key(self) -> tuple[Any, ...]:
        """Equal for equal edits."""
        return (tuple(sorted(self.moved.items())), self.added, tuple(sorted(self.removed)))

    def without_added(self) -> Edits:
        """The scene as it was before anything was put down."""
        return Edits(self.moved, (), self.removed)


@dataclass(frozen=True)
class Question:
    """One request of the page.

    Args:
        scene_id, model, type: Which of each.
        control: (x, y) of the order-2 curve's control point, pixels.
        edits: How the scene is rearranged.
    """

    scene_id: str
    model: str
    type: str
    control: tuple[float, float]
    edits: Edits = field(default_factory=Edits)

    @classmethod
    def from_json(cls, document: Any) -> Question:
        """From the browser's JSON; InputError names what is wrong with it."""
        if not isinstance(document, dict):
            raise InputError("a JSON object", type(document).__name__)
        moved = document.get("moved") or {}
        added = document.get("added") or []
        removed = document.get("removed") or []
        if not isinstance(moved, dict) or not isinstance(added, list):
            raise InputError("moved as an object, added as a list", "other", field="edits")
        if not isinstance(removed, list) or len(moved) + len(added) + len(removed) > MOST_EDITS:
            raise InputError(f"at most {MOST_EDITS} edits", "more", field="edits")
        things = []
        for entry in added:
            if not isinstance(entry, dict):
                raise InputError("an object with symbol, x, y", entry, field="added")
            x, y = place_of([entry.get("x"), entry.get("y")], "added")
            things.append((_word(entry, "symbol"), x, y))
        return cls(
            scene_id=_word(document, "scene"),
            model=_word(document, "model"),
            type=_word(document, "type"),
            control=place_of(document.get("control"), "control"),
            edits=Edits(
                {str(name): place_of(at, "moved") for name, at in moved.items()},
                tuple(things),
                tuple(str(name) for name in removed),
            ),
        )


def place_of(value: Any, name: str) -> tuple[float, float]:
    """Two finite numbers of a request, pixels."""
    if isinstance(value, (list, tuple)) and len(value) == 2:
        try:
            x, y = float(value[0]), float(value[1])
        except (TypeError, ValueError):
            pass
        else:
            if np.isfinite([x, y]).all() and max(abs(x), abs(y)) < 1e6:
                return (x, y)
    raise InputError("two finite numbers", value, field=name)


def _word(document: dict[str, Any], name: str) -> str:
    value = document.get(name)
    if not isinstance(value, str):
        raise InputError("a word", value, field=name)
    return value


class Explorer:
    """Scenes, the models that can be asked about them, and the editor that rearranges them.

    Args:
        scenes: What is explored.
        models: Name → model.
        demonstrations: Of these scenes; a rejected one is where a tab begins.
        truth: Name of the model among them that made the labels, where there is one: it judges
            what other models repaired or sampled.
        units: Of the scenes.
        metres_per_unit: Of the scenes, for what is added; None where unknown.
        scale_of: Scene → its metres per unit; by default `metres_per_unit` of all.
        at: (model's name, scene) → the model as it may look at that scene; raises what is said
            to the person where it may not. By default the model itself.
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        models: Mapping[str, ValidityModel],
        demonstrations: Sequence[Demonstration] = (),
        *,
        truth: str | None = None,
        units: str = "px",
        metres_per_unit: float | None = None,
        scale_of: Callable[[str], float | None] | None = None,
        at: Callable[[str, str], ValidityModel] | None = None,
    ) -> None:
        self._serial = f"{_RUN}-{next(_SERIALS)}"
        self.scenes = {scene.scene_id: scene for scene in scenes}
        self.models = dict(models)
        self.truth = truth if truth in models else None
        self.units = units
        self.metres_per_unit = metres_per_unit
        self.scale_of = scale_of or (lambda scene_id: metres_per_unit)
        self._at = at or (lambda name, scene_id: self.models[name])
        self._adapted: OrderedDict[tuple[str, str], ValidityModel] = OrderedDict()
        self.lock = threading.RLock()  # models and drawing are not made for several threads
        self._demonstrations = demonstrations
        self._editor: Editor | None = None
        self._views: OrderedDict[tuple[Any, ...], View] = OrderedDict()
        self._edited: OrderedDict[tuple[Any, ...], Scene] = OrderedDict()

    @property
    def editor(self) -> Editor:
        """Adds, moves and removes objects, and detects those that nobody listed."""
        if self._editor is None:
            scenes = tuple(self.scenes.values())
            self._editor = editor_for(scenes, metres_per_unit=self.metres_per_unit)
        return self._editor

    def model(self, name: str) -> ValidityModel:
        """The model of that name; InputError lists the names there are."""
        if name not in self.models:
            raise InputError(f"one of {', '.join(self.models) or 'no models'}", name, field="model")
        return self.models[name]

    def original(self, scene_id: str) -> Scene:
        """The scene as the set has it; InputError where there is none."""
        if scene_id not in self.scenes:
            raise InputError("a scene of the set", scene_id, field="scene")
        return self.scenes[scene_id]

    def key(self, question: Question) -> str:
        """Equal for questions whose scene, model, type and edits are equal: their maps are."""
        about = (self._serial, question.scene_id, question.model, question.type)
        return hashlib.sha256(repr((about, question.edits.key)).encode()).hexdigest()[:24]

    def scene(self, scene_id: str, edits: Edits) -> Scene:
        """The scene as the tab rearranged it; objects are listed where anybody knows them."""
        key = (scene_id, edits.key)
        if key in self._edited:
            self._edited.move_to_end(key)
            return self._edited[key]
        scene = self.editor.listed(self.original(scene_id))
        scene = self.editor.rearranged(scene, edits.removed, edits.moved)
        for symbol, x, y in edits.added:
            scene = self._put(scene, symbol, (x, y))
        return _kept(self._edited, key, scene)

    def view(self, question: Question, edits: Edits | None = None) -> View:
        """A model that has looked at the rearranged scene.

        Raises:
            InputError: Unknown scene, model or type.
            CannotJudgeError: The model lacks what it needs (a list, or a picture).
        """
        model = self.model(question.model)
        if question.type not in model.types:
            raise InputError(f"one of {', '.join(model.types)}", question.type, field="type")
        chosen = question.edits if edits is None else edits
        key = (question.model, question.scene_id, chosen.key)
        if key in self._views:
            self._views.move_to_end(key)
            return self._views[key]
        at = (question.model, question.scene_id)
        if at not in self._adapted:
            _kept(self._adapted, at, self._at(*at))
        seen = self._adapted[at].see(self.scene(question.scene_id, chosen))
        return _kept(self._views, key, seen)

    def true_view(self, question: Question) -> View | None:
        """The rule that made the labels, looking at the same scene; None where unknown."""
        if self.truth is None or question.type not in self.model(self.truth).types:
            return None
        asked = Question(question.scene_id, self.truth, question.type, question.control)
        try:
            return self.view(asked, question.edits)
        except CannotJudgeError:
            return None

    def first_control(self, scene_id: str, type: str) -> tuple[float, float]:
        """Where to begin: a rejected demonstration's control point, else the middle."""
        scene = self.original(scene_id)
        for demo in self._demonstrations:
            rejected = demo.scene_id == scene_id and demo.type == type and demo.valid is False
            if rejected and len(demo.xy) > 2:
                x, y = fit_bezier(demo.xy, 2)[0]
                x0, y0, x1, y1 = plane_bounds(scene)
                return (float(np.clip(x, x0, x1)), float(np.clip(y, y0, y1)))
        middle = (np.asarray(scene.start[:2]) + np.asarray(scene.goal[:2])) / 2
        return (float(middle[0]), float(middle[1]))

    def free_place(self, question: Question, symbol: str) -> tuple[float, float]:
        """The free place nearest to the middle of the path, where `symbol` fits.

        Raises:
            InputError: Nothing of that symbol can be put down.
            NoPlace: There is no room.
        """
        scene = self.scene(question.scene_id, question.edits)
        radius = self._template(scene, symbol).radius_px(scene)
        places = self._free(scene, radius)
        if not len(places):
            raise NoPlace(f"There is no free place for another {symbol} here.")
        path = path_of(scene, question.control)
        middle = path[len(path) // 2]
        best = places[int(np.hypot(*(places - middle).T).argmin())]
        return (float(best[0]), float(best[1]))

    def fits(self, scene_id: str, symbol: str) -> bool:
        """Whether one more of that symbol has a free place in a scene of the set."""
        scene = self.scene(scene_id, Edits())
        radius = self._template(scene, symbol).radius_px(scene)
        return len(self._free(scene, radius)) > 0

    def _free(self, scene: Scene, radius: float) -> FloatArray:
        """Free places for a disc: in the picture, else about what is listed."""
        bounds = None if scene.size_px is not None else plane_bounds(scene)
        rng = np.random.default_rng(0)
        return self.editor.free_places(scene, radius, 200, rng, bounds=bounds)

    def _template(self, scene: Scene, symbol: str) -> Template:
        templates = self.editor.templates(symbol, scene)
        if not templates:
            raise InputError("a symbol that can be put down", symbol, field="symbol")
        return templates[0]

    def _put(self, scene: Scene, symbol: str, at: tuple[float, float]) -> Scene:
        return self._template(scene, symbol).put(scene, at, 0.0)


def path_of(scene: Scene, control: tuple[float, float], points: int = 100) -> FloatArray:
    """Bz⁻¹ of the control point between the scene's start and goal, (points, 2), pixels."""
    start, goal = (np.asarray(p[:2], dtype=np.float64) for p in (scene.start, scene.goal))
    one = np.asarray(control, dtype=np.float64).reshape(1, 1, 2)
    return np.asarray(bezier_points(start[None], goal, one, points)[0])


def _kept(cache: OrderedDict[tuple[Any, ...], Kept], key: tuple[Any, ...], value: Kept) -> Kept:
    cache[key] = value
    while len(cache) > _VIEWS_KEPT:
        cache.popitem(last=False)
    return value
