"""Hands that move objects of a picture as fast as a person drags them.

A picture that nobody composed loses an object by painting over it, which takes a tenth of a
second; an object that is dragged leaves the same hole under every move of the hand.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import replace

from demospec.causal import Editor, PictureEditor, Thing
from demospec.scene import Scene

_KEPT = 64


class Hands:
    """Takes things off scenes and puts them elsewhere; remembers the tables underneath.

    Args:
        editor: Of the set: it changes what was composed, and lists without pictures.
    """

    def __init__(self, editor: Editor) -> None:
        self.editor = editor
        self._cut: dict[str, Mapping[str, Thing]] = {}
        self._without: OrderedDict[tuple[str, tuple[str, ...]], Scene] = OrderedDict()

    def rearranged(
        self, scene: Scene, removed: Sequence[str], moved: Mapping[str, tuple[float, float]]
    ) -> Scene:
        """A scene of the set without some objects (ids), and with others elsewhere (pixels).

        Every moved object is cut out of the picture as the set has it, and laid down on the
        table without any of them: in which order a person moved them makes no difference.
        """
        there = {name: at for name, at in moved.items() if name not in removed}
        cut = self._cut_outs(scene)
        lifted = sorted(name for name in there if name in cut)
        scene = self._taken_off(scene, (*sorted(removed), *lifted))
        known = {o.id for o in scene.objects or ()}
        for name, at in sorted(there.items()):
            if name in cut:
                scene = _named_last(cut[name].put(scene, at, 0.0), name)
            elif name in known:
                scene = self.editor.move(scene, name, at)
        return scene

    def _taken_off(self, scene: Scene, names: tuple[str, ...]) -> Scene:
        if not names:
            return scene
        key = (scene.scene_id, names)
        if key not in self._without:
            before = self._taken_off(scene, names[:-1])
            self._without[key] = self.editor.remove(before, names[-1])
            while len(self._without) > _KEPT:
                self._without.popitem(last=False)
        self._without.move_to_end(key)
        return self._without[key]

    def _cut_outs(self, scene: Scene) -> Mapping[str, Thing]:
        """Object id → what is cut out of the scene's own picture; none of a composed scene."""
        if scene.scene_id not in self._cut:
            found: dict[str, Thing] = {}
            if scene.picture is not None and scene.recipe is None:
                own = PictureEditor([scene], source="cutouts")
                shaped = [o for o in scene.listed_objects() if o.footprint is not None]
                for symbol in {o.symbol for o in shaped}:
                    names = [o.id for o in shaped if o.symbol == symbol]
                    found |= zip(names, own.things(symbol, scene), strict=True)
            self._cut[scene.scene_id] = found
        return self._cut[scene.scene_id]


def _named_last(scene: Scene, name: str) -> Scene:
    """The scene whose last object, just put down, has its old id."""
    *rest, last = scene.listed_objects()
    return scene.with_changes(objects=(*rest, replace(last, id=name)), picture=scene.picture)
