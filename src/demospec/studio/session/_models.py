"""The models that the studio can ask: files that were given or found, and what was just taught.

Loading and learning take long, and hold none of the table's locks: who draws does not wait.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from demospec.demonstrations import DemonstrationSet, ValidityModel
from demospec.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from demospec.rules import RuleSet

SO_FAR = "understood so far"
"""Name, among the models, of the rules learned from what is on the table."""


class ModelFiles:
    """Models on the disk, by name, each loaded once.

    Args:
        model: A model folder or rule file that was asked for by name: it must load. Others are
            left out where they cannot (their library is absent).
        run: A run folder, with models and rules in it.
        set_folder: A set, maybe with the rule that made its labels.
    """

    def __init__(self, model: Path | None, run: Path | None, set_folder: Path | None) -> None:
        self._asked_for = model
        self._where = (model, run, set_folder)
        self._lock = threading.Lock()
        self._loaded: dict[str, ValidityModel | None] = {}

    def all(self) -> dict[str, ValidityModel]:
        """Every model that can be loaded."""
        return self._of(_places_of(*self._where))

    def rule_files(self) -> dict[str, RuleSet]:
        """Those that are rule files; no network is loaded for them."""
        from demospec.rules import RuleSet

        files = {name: place for name, place in _places_of(*self._where).items() if place.is_file()}
        return {n: m for n, m in self._of(files).items() if isinstance(m, RuleSet)}

    def _of(self, places: Mapping[str, Path]) -> dict[str, ValidityModel]:
        with self._lock:
            for name, place in places.items():
                if name not in self._loaded:
                    self._loaded[name] = self._load(place)
            found = {name: self._loaded[name] for name in places}
        return {name: model for name, model in found.items() if model is not None}

    def _load(self, place: Path) -> ValidityModel | None:
        from demospec.specification import load_model

        try:
            model: ValidityModel = load_model(place)
        except (MissingExtraError, InputError):
            if place == self._asked_for:
                raise
            return None
        return model


def _places_of(model: Path | None, run: Path | None, set_folder: Path | None) -> dict[str, Path]:
    """Name → model folder or rule file."""
    places: dict[str, Path] = {}
    if model is not None:
        places[model.stem] = model
    if run is not None:
        for config in sorted(run.glob("*/config.json")):
            places.setdefault(config.parent.name, config.parent)
        if (run / "rules.json").is_file():
            places.setdefault("rules", run / "rules.json")
    if set_folder is not None and (set_folder / "truth.json").is_file():
        places.setdefault("truth", set_folder / "truth.json")
    return places


class RulesSoFar:
    """Clearance rules of all types, learned when asked for and something has changed."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._known: tuple[int, RuleSet | None] | None = None

    def of(self, version: int, data: Callable[[], DemonstrationSet | None]) -> RuleSet | None:
        """The rules of that version; None while there is nothing to learn from."""
        with self._lock:
            if self._known is None or self._known[0] != version:
                self._known = (version, _learned(data()))
            return self._known[1]


def _learned(data: DemonstrationSet | None) -> RuleSet | None:
    from demospec.rules import learn_rules
    from demospec.studio.session._distance_cache import fits, near, passing

    if data is None:
        return None
    try:
        return learn_rules(
            data, split=None, influence=False, measure=near, passing=passing, memory=fits
        )
    except InputError:  # no label yet, or no scene that lists its objects
        return None
