"""Effect map: the effect of adding an object, per place of one scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from demospec.causal._find import editor_for
from demospec.causal._paths import draw_controls, paths_of, region_of, region_of_scene
from demospec.causal._scene_trials import CLEAR_ENDS, GAP
from demospec.causal._statistics import stable_seed
from demospec.demonstrations import ValidityModel
from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.progress import Progress, silent
from demospec.scene import Editor, Scene, Template, room_around


@dataclass(frozen=True)
class EffectMap:
    """Change of E[p(v)] by adding a symbol at every place of a grid.

    Args:
        x, y: (k,) centres of the grid's columns and rows, pixels.
        effect: (rows, columns); NaN where there is no room.
        source: Which item was put there.
    """

    scene_id: str
    type: str
    symbol: str
    x: FloatArray
    y: FloatArray
    effect: FloatArray
    source: str

    @property
    def strongest(self) -> tuple[float, float] | None:
        """The place where adding it changes most, pixels; None without any room."""
        if np.isnan(self.effect).all():
            return None
        row, column = np.unravel_index(np.nanargmax(np.abs(self.effect)), self.effect.shape)
        return float(self.x[column]), float(self.y[row])


def effect_map(
    model: ValidityModel,
    scene: Scene,
    symbol: str,
    type: str,
    *,
    grid: int = 15,
    draws: int = 100,
    seed: int = 0,
    editor: Editor | None = None,
    template: Template | None = None,
    progress: Progress = silent,
) -> EffectMap:
    """Adds the same item, unturned, at every free place of a grid.

    Args:
        grid: Places along each axis.
        draws: Random paths judged at every place, the same ones.
        editor: By default `editor_for` this scene (for lists and cut-outs: of its own objects).
        template: Which item; by default one that `seed` draws.

    Raises:
        InputError: Nothing of that symbol can be added.
    """
    editor = editor or editor_for([scene])
    rng = np.random.default_rng(stable_seed(seed, scene.scene_id, "map", symbol))
    if template is None:
        templates = editor.templates(symbol, scene)
        if not templates:
            expected = "a symbol that the scene or the catalogue has"
            raise InputError(expected, symbol, field="symbol")
        template = templates[int(rng.integers(len(templates)))]
    area = region_of_scene(scene, region_of([scene]))
    paths = paths_of(scene, draw_controls(area, draws, rng))
    before = float(model.see(scene).p_valid(paths, type).mean())
    width, height = area[2] - area[0], area[3] - area[1]
    steps = np.arange(grid, dtype=np.float64) + 0.5
    x, y = area[0] + steps * (width / grid), area[1] + steps * (height / grid)
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    room = room_around(
        editor.listed(scene), places, gap_px=GAP * width, end_gap_px=CLEAR_ENDS * width,
        bounds=area,
    )  # fmt: skip
    effect = np.full(len(places), np.nan)
    free = np.flatnonzero(room >= template.radius_px(scene))
    for k, i in enumerate(free):
        progress(f"places for {symbol}", k, len(free))
        after = template.put(scene, (float(places[i, 0]), float(places[i, 1])), 0.0)
        effect[i] = float(model.see(after).p_valid(paths, type).mean()) - before
    progress(f"places for {symbol}", 1, 1)
    return EffectMap(scene.scene_id, type, symbol, x, y, effect.reshape(grid, grid), template.name)
