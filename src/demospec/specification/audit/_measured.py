"""The evidence of an audit: distances by the scenes' lists, else by what their pictures show."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError, MissingExtraError
from demospec.progress import Progress, silent
from demospec.rules import Evidence, Observer, evidence_of

if TYPE_CHECKING:
    from demospec.perception import Observation
    from demospec.scene import Scene


def audit_evidence(
    data: DemonstrationSet,
    labelled: NDArray[np.bool_],
    *,
    needed: bool = True,
    seed: int = 0,
    progress: Progress = silent,
) -> tuple[Evidence | None, str | None]:
    """All splits and everybody, also who has no type, and why pictures were not observed.

    Args:
        labelled: (n,) which demonstrations have a label.
        needed: Whether there is no other witness: then no evidence is refused.

    Raises:
        InputError: Neither lists nor pictures, and needed.
        MissingExtraError: No lists, needed, and what observes pictures is not installed.
    """
    used = set(data.demonstrations.scene_id[labelled].tolist())
    scenes = [scene for scene in data.scenes if scene.scene_id in used]
    listed = any(scene.objects is not None for scene in scenes)
    unlisted = [s for s in scenes if s.objects is None and s.picture is not None]
    observer, why_not = None, None
    if unlisted:
        try:
            observer = _observer(data, unlisted, seed, progress)
        except MissingExtraError as error:
            why_not = str(error)
    if not listed and observer is None:
        if needed and why_not is not None:
            raise MissingExtraError("torch", "vision", "auditing by pictures alone")
        if needed:
            expected = "scenes that list their objects, or pictures that show them"
            raise InputError(expected, "neither", field="objects")
        return None, why_not
    return evidence_of(data, split=None, untyped=True, observer=observer), why_not


def _observer(
    data: DemonstrationSet, unlisted: list[Scene], seed: int, progress: Progress
) -> Observer | None:
    """Who measures in pictures; where some scenes list objects, things are given those names."""
    from demospec.perception import KINDS, fit_symbol_head, load_network
    from demospec.specification.models.perceived_rule._fit import calibrate, observe_all
    from demospec.specification.models.perceived_rule._observation import (
        Calibration,
        PictureObserver,
    )

    network = load_network()
    symbols: tuple[str, ...] = KINDS
    head, calibration = None, Calibration({}, {})
    if any(scene.objects is not None for scene in data.scenes):
        examples = [s for s in data.scenes if s.objects and s.picture is not None]
        observed = observe_all(examples, network, None)
        head = fit_symbol_head(
            examples, network=network, seed=seed,
            observations=[item.observation for item in observed],
        )  # fmt: skip
        calibration = calibrate(observed, None, seed)
        symbols = data.symbols
        if head is None:
            return None  # nobody could say what the things in the pictures are called
    observations: Mapping[str, Observation] = {
        item.scene.scene_id: item.observation
        for item in observe_all(unlisted, network, None, progress)
    }
    return PictureObserver(symbols, head, calibration, observations)
