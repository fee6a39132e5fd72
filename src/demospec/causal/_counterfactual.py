"""But-for counterfactual: one trajectory, judged again without each object.

Source: the counterfactual reading of Angelov et al. 2020's structural causal model; the paper
adds objects only ("we do not have the ability" to remove them).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from demospec.causal._find import editor_for
from demospec.demonstrations import DemonstrationSet, ValidityModel, View, checked_points
from demospec.frames import FloatArray
from demospec.progress import Progress, silent
from demospec.scene import Editor, Scene


@dataclass(frozen=True)
class Without:
    """The same path with one object gone.

    Args:
        object_id, symbol: What was taken away.
        p_valid: Of the path without it.
        flips: Whether the verdict (p > 0.5) changes.
    """

    object_id: str
    symbol: str
    p_valid: float
    flips: bool


@dataclass(frozen=True)
class Counterfactual:
    """One trajectory of one type in one scene, as it is and without each object.

    Args:
        p_valid: As the scene is.
        without: One per object, the largest change first.
        empty_p_valid: With every object gone; None where the scene lists none.
        sentence: In words.
    """

    scene_id: str
    type: str
    p_valid: float
    without: tuple[Without, ...]
    empty_p_valid: float | None
    sentence: str

    @property
    def causes(self) -> tuple[str, ...]:
        """Ids of the objects without any one of which the verdict would be another."""
        return tuple(w.object_id for w in self.without if w.flips)

    def to_json(self) -> dict[str, Any]:
        """As a JSON document."""
        return {**asdict(self), "causes": list(self.causes)}


def but_for(
    model: ValidityModel,
    scene: Scene,
    path: ArrayLike,
    type: str,
    *,
    editor: Editor | None = None,
) -> Counterfactual:
    """Takes every object away in turn and asks the model again.

    Args:
        scene: Must list its objects.
        path: (n, d) points, x and y first, pixels.
        type: User type.

    Raises:
        CannotJudgeError: Objects not listed.
    """
    points = checked_points(path)[:, :2]
    return _Absences(model, scene, editor or editor_for([scene])).judged(points, type)


class _Absences:
    """A scene as it is, without each object, and empty: the model looks at each once."""

    def __init__(self, model: ValidityModel, scene: Scene, editor: Editor) -> None:
        self.scene, self.objects = scene, scene.listed_objects()
        self.now = model.see(scene)
        self.without = [model.see(editor.remove(scene, item.id)) for item in self.objects]
        bare = scene
        for item in self.objects:
            bare = editor.remove(bare, item.id)
        self.empty = model.see(bare) if self.objects else None

    def judged(self, points: FloatArray, type_: str) -> Counterfactual:
        """One path (n, 2) in all of them."""

        def ask(view: View) -> float:
            return float(view.p_valid([points], type_)[0])

        now = ask(self.now)
        without = []
        for item, view in zip(self.objects, self.without, strict=True):
            p = ask(view)
            without.append(Without(item.id, item.symbol, p, (p > 0.5) != (now > 0.5)))
        without.sort(key=lambda w: -abs(w.p_valid - now))
        empty = None if self.empty is None else ask(self.empty)
        sentence = _sentence(type_, now, without, empty)
        return Counterfactual(self.scene.scene_id, type_, now, tuple(without), empty, sentence)


def but_for_rejected(
    model: ValidityModel,
    data: DemonstrationSet,
    n: int,
    *,
    types: Sequence[str] | None = None,
    progress: Progress = silent,
) -> tuple[RejectedPath, ...]:
    """But-for counterfactuals of demonstrations that their demonstrators rejected.

    The first rejected demonstration of each type in each scene, then the second ones, until
    there are `n` of a type. Those that the model accepts are asked, too.

    Args:
        n: Of each type, at most.
        types: All of the set that the model knows by default.

    Raises:
        CannotJudgeError: A scene lists no objects, or the model cannot judge it.
    """
    d = data.demonstrations
    wanted = [t for t in (data.types if types is None else types) if t in model.types]
    by_scene: dict[str, list[int]] = {}
    for type_ in wanted:
        own: dict[str, list[int]] = {}
        for row in np.flatnonzero((d.valid == 0) & (d.type == type_)):
            own.setdefault(d.scene_id[row], []).append(int(row))
        turns = [(turn, s, i) for s, rows in own.items() for turn, i in enumerate(rows)]
        for _, scene_id, i in sorted(turns, key=lambda t: t[0])[:n]:
            by_scene.setdefault(scene_id, []).append(i)
    editor = editor_for(data.scenes, metres_per_unit=data.metres_per_unit)
    out = []
    for done, (scene_id, rows) in enumerate(by_scene.items()):
        progress("counterfactuals", done, len(by_scene))
        absences = _Absences(model, data.scene(scene_id), editor)
        for i in sorted(rows):
            found = absences.judged(d.points(i)[:, :2], str(d.type[i]))
            out.append(RejectedPath(str(d.demo_id[i]), found))
    progress("counterfactuals", len(by_scene), len(by_scene))
    return tuple(out)


@dataclass(frozen=True)
class RejectedPath:
    """A demonstration that its demonstrator rejected, and the model's counterfactuals."""

    demo_id: str
    found: Counterfactual

    @property
    def kind(self) -> Literal["accepted", "one", "together", "none"]:
        """What the model says of it.

        ``accepted``: the model does not reject it. ``one``: without some single object it would
        be accepted. ``together``: only the empty table would. ``none``: not even that.
        """
        if self.found.p_valid > 0.5:
            return "accepted"
        if self.found.causes:
            return "one"
        empty = self.found.empty_p_valid
        return "together" if empty is not None and empty > 0.5 else "none"

    def to_json(self) -> dict[str, Any]:
        """As a JSON document."""
        return {"demo_id": self.demo_id, "kind": self.kind, **self.found.to_json()}


def _sentence(type_: str, now: float, without: list[Without], empty: float | None) -> str:
    verdict = "accepts" if now > 0.5 else "rejects"
    other = "reject" if now > 0.5 else "accept"
    start = f"{type_} {verdict} this path (p = {now:.2f})"
    flips = [w for w in without if w.flips]
    if flips:
        each = "; ".join(
            f"had {w.object_id} not been there, {type_} would {other} it (p = {w.p_valid:.2f})"
            for w in flips
        )
        return f"{start}; {each}."
    if not without:
        return f"{start}; there is no object to take away."
    if empty is not None and (empty > 0.5) != (now > 0.5):
        return (
            f"{start}; no single object decides it, all together do: on the empty table "
            f"{type_} would {other} it (p = {empty:.2f})."
        )
    largest = float(np.max([abs(w.p_valid - now) for w in without]))
    return f"{start}; taking away any object changes p by at most {largest:.2f}."
