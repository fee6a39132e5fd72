"""Fitting the field model: looks → classes, outlines → calibration, labels → rules."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet, bezier_points
from demospec.frames import FloatArray
from demospec.perception import KINDS, Sight, SymbolHead, read_map
from demospec.perception.heads._symbols import NOTHING, match_slots
from demospec.progress import Progress, silent
from demospec.rules import RuleSet, evidence_of, fit, nearest_approach
from demospec.scene import Scene
from demospec.specification.models.beta_vae._training_data import labelled_rows
from demospec.specification.models.perceived_rule._observation import (
    Calibration,
    PictureObserver,
    sight_of,
)
from demospec.specification.models.perceived_rule._rule import rules_of_fit

if TYPE_CHECKING:
    from demospec.perception import Body

_TURNS = (1, 2, 3, 4, 5, 6, 7)
_NEAR = 1.5  # calibration uses paths this close to the clearance, hundredths of the table


@dataclass(frozen=True)
class Looked:
    """A training scene with its sight and, where listed, who is who."""

    scene: Scene
    sight: Sight


def look_at_all(
    scenes: list[Scene], body: Body | None, scale: float | None, progress: Progress = silent
) -> list[Looked]:
    """Looks at every scene with a picture."""
    out = []
    for i, scene in enumerate(scenes):
        if scene.picture is not None:
            out.append(Looked(scene, sight_of(scene, body, scale)))
        progress("looking at the scenes", i + 1, len(scenes))
    return out


def fit_head(
    looked: list[Looked], body: Body | None, scale: float | None, seed: int
) -> SymbolHead | None:
    """The symbol head from listed scenes; None where none lists an object.

    Every scene is also seen turned, mirrored and recoloured: that changes the looks a little
    and, unlike for distances, does no harm here. All looks of one object count as one.
    """
    listed = [item for item in looked if item.scene.objects]
    if not listed:
        return None
    rng = np.random.default_rng([seed, 77])
    looks: list[NDArray[np.float32]] = []
    names: list[str] = []
    weights: list[float] = []
    for item in listed:
        _add_looks(item.scene, item.sight, looks, names, weights)
        for turn in rng.permutation(_TURNS)[:3]:
            turned = _turned_scene(item.scene, int(turn), rng)
            sight = sight_of(turned, body, scale, turns=(0,))
            _add_looks(turned, sight, looks, names, weights)
    if not any(name != NOTHING for name in names):
        return None
    # A ridge of 1 tells unseen items apart better than 3: log-loss 0.14 against 0.17.
    return SymbolHead.fit(np.stack(looks), names, np.array(weights) / 4.0, ridge=1.0)


def _add_looks(
    scene: Scene,
    sight: Sight,
    looks: list[NDArray[np.float32]],
    names: list[str],
    weights: list[float],
) -> None:
    objects = scene.objects or ()
    owner, largest = match_slots(sight, objects)
    for i, slot in enumerate(sight.slots):
        looks.append(slot.looks)
        names.append(objects[owner[i]].symbol if owner[i] >= 0 else NOTHING)
        # Fragments are seen at test time too, but the whole thing counts more.
        whole = owner[i] < 0 or largest[owner[i]] == i
        weights.append(1.0 if whole else 0.5)


def _turned_scene(scene: Scene, turn: int, rng: np.random.Generator) -> Scene:
    """The scene turned with its outlines (as polygons) and slightly recoloured."""
    from demospec.perception.inference._observe import turned_array
    from demospec.scene import Picture

    pixels = scene.pixels()
    height, width = pixels.shape[:2]
    planes = turned_array(pixels.transpose(2, 0, 1), turn).transpose(1, 2, 0)
    gain = rng.uniform(0.85, 1.15) * rng.uniform(0.94, 1.06, 3)
    painted = np.clip((planes / 255.0) ** rng.uniform(0.85, 1.2) * gain * 255, 0, 255)

    def moved(p: FloatArray) -> FloatArray:
        x, y = p[:, 0], p[:, 1]
        w, h = width, height
        for _ in range(turn % 4):  # a quarter turn as np.rot90 does it
            x, y = y, w - x
            w, h = h, w
        if turn >= 4:
            x = w - x
        return np.stack([x, y], axis=1)

    corner = moved(np.zeros((1, 2)))[0]
    matrix = (moved(np.eye(2)) - corner).T
    objects = tuple(item.mapped(matrix, corner) for item in scene.objects or ())
    picture = Picture(array=painted.astype(np.uint8))
    return scene.with_changes(objects=objects, picture=picture)


def random_curves(scene: Scene, count: int, rng: np.random.Generator) -> FloatArray:
    """(count, 60, 2) Bézier curves from start to goal, control points about the picture."""
    assert scene.size_px is not None
    size = np.array(scene.size_px, dtype=np.float64)
    control = rng.uniform(-0.2, 1.2, (count, 2)) * size
    return bezier_points(scene.start[:2], scene.goal[:2], control[:, None, :], 60)


def calibrate(looked: list[Looked], clearance: float | None, seed: int) -> Calibration:
    """Seen against listed nearest approaches of random curves, near the clearance.

    Args:
        clearance: Where the distance matters, set units; by default 3 % of the picture.

    A class's own median is drawn towards that of all classes as if by 40 further curves. The
    spread is that of the gaps over what the body doubts where the curve comes nearest.
    """
    rng = np.random.default_rng([seed, 78])
    gaps: dict[str, list[FloatArray]] = {}
    doubts: dict[str, list[FloatArray]] = {}
    for item in looked:
        objects, sight = item.scene.objects, item.sight
        if not objects:
            continue
        unit = sight.hundredth
        keep = 0.03 * max(sight.size_px) if clearance is None else clearance
        curves = random_curves(item.scene, 150, rng)
        _, largest = match_slots(sight, objects)
        for thing, row in zip(objects, largest, strict=True):
            if row < 0:
                continue
            alone = item.scene.with_changes(objects=(thing,), picture=None)
            exact = nearest_approach(alone, curves, (thing.symbol,))[:, 0]
            close = np.abs(exact - keep) < _NEAR * unit
            if close.any():
                along = read_map(sight.slots[row].distance, curves[close], sight.size_px)
                nearest = np.arange(len(along)), along.argmin(axis=1)
                gaps.setdefault(thing.symbol, []).append((along[nearest] - exact[close]) / unit)
                doubt = read_map(sight.doubt, curves[close][nearest], sight.size_px)
                doubts.setdefault(thing.symbol, []).append(doubt)
    if not gaps:
        return Calibration({}, {})
    every, doubted = (
        {name: np.concatenate(parts) for name, parts in found.items()} for found in (gaps, doubts)
    )
    whole, beside = (np.concatenate(list(v.values())) for v in (every, doubted))
    middle = float(np.median(whole))
    error = _robust_spread((whole - middle) / beside)
    bias, errors = {}, {}
    for name, mine in every.items():
        share = len(mine) / (len(mine) + 40.0)
        bias[name] = share * float(np.median(mine)) + (1 - share) * middle
        own = _robust_spread((mine - float(np.median(mine))) / doubted[name])
        errors[name] = max(0.15, share * own + (1 - share) * error)
    return Calibration(bias, errors, middle, max(0.15, error))


def _robust_spread(values: FloatArray) -> float:
    return float(1.4826 * np.median(np.abs(values - np.median(values))) + 0.05)


def fit_rules(
    data: DemonstrationSet,
    looked: list[Looked],
    head: SymbolHead | None,
    calibration: Calibration,
    *,
    listed: bool,
) -> RuleSet:
    """Which classes matter to every type and how far, from all labelled demonstrations.

    Where scenes list their objects the distances are exact; a scene that does not is seen.

    Raises:
        InputError: No demonstration has both a type and a label.
    """
    labelled_rows(data)
    observations = {item.scene.scene_id: item.sight for item in looked}
    symbols = data.symbols if listed else KINDS
    observer = PictureObserver(symbols, head, calibration, observations)
    found = fit(evidence_of(data, split=None, observer=observer))
    order = [t for t in data.types if t in found.people]
    rules = {name: rules_of_fit(found, name) for name in order}
    return RuleSet(rules, data.units, data.metres_per_unit, found.evidence.notes)


def typical_clearance(rules: RuleSet) -> float | None:
    """Mean clearance of the classes that matter, set units; None where nothing does."""
    kept = [
        c for rule in rules.rules.values() if rule.clearance for c in rule.clearance.value.values()
    ]
    return float(np.mean(kept)) if kept else None
