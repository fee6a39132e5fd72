"""Fitting the perceived-rule model: outlines → calibration, labels → rules."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from demospec.demonstrations import DemonstrationSet, bezier_points
from demospec.frames import FloatArray
from demospec.geometry import read_map
from demospec.perception import KINDS, Observation, SymbolHead, match_detections
from demospec.progress import Progress, silent
from demospec.rules import RuleSet, evidence_of, fit, nearest_approach
from demospec.scene import Scene
from demospec.specification.models.beta_vae._training_data import labelled_rows
from demospec.specification.models.perceived_rule._observation import (
    Calibration,
    PictureObserver,
    observation_of,
)
from demospec.specification.models.perceived_rule._rule import rules_of_fit

if TYPE_CHECKING:
    from demospec.perception import DistanceNet

_NEAR = 1.5  # calibration uses paths this close to the clearance, percent of the table


@dataclass(frozen=True)
class ObservedScene:
    """A training scene with its observation."""

    scene: Scene
    observation: Observation


def observe_all(
    scenes: list[Scene],
    network: DistanceNet | None,
    scale: float | None,
    progress: Progress = silent,
) -> list[ObservedScene]:
    """Observes every scene with a picture."""
    out = []
    for i, scene in enumerate(scenes):
        if scene.picture is not None:
            out.append(ObservedScene(scene, observation_of(scene, network, scale)))
        progress("observing the scenes", i + 1, len(scenes))
    return out


def random_curves(scene: Scene, count: int, rng: np.random.Generator) -> FloatArray:
    """(count, 60, 2) Bézier curves from start to goal, control points about the picture."""
    assert scene.size_px is not None
    size = np.array(scene.size_px, dtype=np.float64)
    control = rng.uniform(-0.2, 1.2, (count, 2)) * size
    return bezier_points(scene.start[:2], scene.goal[:2], control[:, None, :], 60)


def calibrate(observed: list[ObservedScene], clearance: float | None, seed: int) -> Calibration:
    """Perceived against listed nearest approaches of random curves, near the clearance.

    Args:
        clearance: Where the distance matters, set units; by default 3 % of the picture.

    A class's own median is drawn towards that of all classes as if by 40 further curves. The
    spread is that of the gaps over the uncertainty where the curve comes nearest.
    """
    rng = np.random.default_rng([seed, 78])
    gaps: dict[str, list[FloatArray]] = {}
    deviations: dict[str, list[FloatArray]] = {}
    for item in observed:
        objects, observation = item.scene.objects, item.observation
        if not objects:
            continue
        unit = observation.percent_px
        keep = 0.03 * max(observation.size_px) if clearance is None else clearance
        curves = random_curves(item.scene, 150, rng)
        _, largest = match_detections(observation, objects)
        for thing, row in zip(objects, largest, strict=True):
            if row < 0:
                continue
            alone = item.scene.with_changes(objects=(thing,), picture=None)
            exact = nearest_approach(alone, curves, (thing.symbol,))[:, 0]
            close = np.abs(exact - keep) < _NEAR * unit
            if close.any():
                own = observation.detections[row].distance
                along = read_map(own, curves[close], observation.size_px)
                nearest = np.arange(len(along)), along.argmin(axis=1)
                gaps.setdefault(thing.symbol, []).append((along[nearest] - exact[close]) / unit)
                there = curves[close][nearest]
                ratio = read_map(observation.uncertainty, there, observation.size_px)
                deviations.setdefault(thing.symbol, []).append(ratio)
    if not gaps:
        return Calibration({}, {})
    every, usual = (
        {name: np.concatenate(parts) for name, parts in found.items()}
        for found in (gaps, deviations)
    )
    whole, beside = (np.concatenate(list(v.values())) for v in (every, usual))
    middle = float(np.median(whole))
    error = _robust_spread((whole - middle) / beside)
    bias, errors = {}, {}
    for name, mine in every.items():
        share = len(mine) / (len(mine) + 40.0)
        bias[name] = share * float(np.median(mine)) + (1 - share) * middle
        own = _robust_spread((mine - float(np.median(mine))) / usual[name])
        errors[name] = max(0.15, share * own + (1 - share) * error)
    return Calibration(bias, errors, middle, max(0.15, error))


def _robust_spread(values: FloatArray) -> float:
    return float(1.4826 * np.median(np.abs(values - np.median(values))) + 0.05)


def fit_rules(
    data: DemonstrationSet,
    observed: list[ObservedScene],
    head: SymbolHead | None,
    calibration: Calibration,
    *,
    listed: bool,
) -> RuleSet:
    """Which classes matter to every type and how far, from all labelled demonstrations.

    Where scenes list their objects the distances are exact; a scene that does not is observed.

    Raises:
        InputError: No demonstration has both a type and a label.
    """
    labelled_rows(data)
    observations = {item.scene.scene_id: item.observation for item in observed}
    symbols = data.symbols if listed else KINDS
    observer = PictureObserver(symbols, head, calibration, observations)
    found = fit(evidence_of(data, split=None, observer=observer))
    order = [t for t in data.types if t in found.people]
    rules = {name: rules_of_fit(found, name, data) for name in order}
    return RuleSet(rules, data.units, data.metres_per_unit, found.evidence.notes)


def typical_clearance(rules: RuleSet) -> float | None:
    """Mean clearance of the classes that matter, set units; None where nothing does."""
    kept = [
        c for rule in rules.rules.values() if rule.clearance for c in rule.clearance.value.values()
    ]
    return float(np.mean(kept)) if kept else None
