"""But-for counterfactual: one trajectory, judged again without each object.

Source: the counterfactual reading of Angelov et al. 2020's structural causal model; the paper
adds objects only ("we do not have the ability" to remove them).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from demospec.causal._find import editor_for
from demospec.demonstrations import ValidityModel, checked_points
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
    editor = editor or editor_for([scene])
    points = checked_points(path)[:, :2]
    objects = scene.listed_objects()

    def ask(changed: Scene) -> float:
        return float(model.see(changed).p_valid([points], type)[0])

    now = ask(scene)
    without = []
    for item in objects:
        p = ask(editor.remove(scene, item.id))
        without.append(Without(item.id, item.symbol, p, (p > 0.5) != (now > 0.5)))
    without.sort(key=lambda w: -abs(w.p_valid - now))
    empty = None
    if objects:
        bare = scene
        for item in objects:
            bare = editor.remove(bare, item.id)
        empty = ask(bare)
    sentence = _sentence(type, now, without, empty)
    return Counterfactual(scene.scene_id, type, now, tuple(without), empty, sentence)


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
