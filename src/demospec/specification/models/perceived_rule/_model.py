"""The perceived-rule (`field`) model: pretrained perception apart from an inferred specification.

Not in the paper, whose network learns both from the labels at once and forgets scenes it has
not seen. Here a distance network that was pretrained without labels detects objects
(`demospec.perception`), the listed polygons and labels say exactly which symbols matter and
how far (`demospec.rules.fit`), and the rule is read through perception, calibrated
at the fitted clearance.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from demospec.demonstrations import DemonstrationSet
from demospec.errors import CannotJudgeError, InputError
from demospec.perception import (
    CodeLength,
    Observation,
    SceneCode,
    SceneSampler,
    SymbolHead,
    class_probabilities,
    draw_scene_code,
    read_scene_code,
)
from demospec.progress import Progress, silent
from demospec.rules import RuleSet, rules_document
from demospec.scene import Image, Scene
from demospec.specification.models._folder import (
    ModelFolder,
    ModelWeights,
    provenance_of,
    read_model_folder,
    write_model_folder,
)
from demospec.specification.models.beta_vae._stacked import check_device
from demospec.specification.models.perceived_rule._fit import (
    ObservedScene,
    calibrate,
    fit_rules,
    observe_all,
    typical_clearance,
)
from demospec.specification.models.perceived_rule._observation import (
    Calibration,
    list_shape,
    listed_objects,
    observation_of,
    perceived_objects,
    span_of,
)
from demospec.specification.models.perceived_rule._rule import rules_of_settings
from demospec.specification.models.perceived_rule._view import FieldView

if TYPE_CHECKING:
    from demospec.perception import DistanceNet


@dataclass(frozen=True)
class FieldSettings:
    """How a perceived-rule model is fitted and observes.

    Args:
        fine_tune: Tune the network on the training scenes' polygons, mixed with pretraining
            pictures (up to 90 s); else the shipped network is used as it is.
        use_lists: Where a scene lists its objects, believe the list instead of the picture.
        device: Where torch tunes the network: ``cpu``, ``cuda``, … Models observe on the CPU.
    """

    fine_tune: bool = False
    use_lists: bool = True
    device: str = "cpu"


class FieldModel:
    """A fitted perceived-rule model; a `ValidityModel`.

    Args:
        rules: What matters to each type, with beliefs (`rules_of_fit`) about symbols, or about
            generic words where the training set listed no objects.
        head: Appearance → symbols; None where no training scene listed objects with a picture.
        calibration: Of perceived distances.
        scale: Map pixels per set unit, or None: the longer side of each picture becomes what
            the network was trained on.
        network: The distance network, or None for a model that only reads lists.
        settings: How it was fitted.
        provenance: Versions, seed, data hash.
    """

    kind: Final = "field"

    def __init__(
        self,
        rules: RuleSet,
        head: SymbolHead | None,
        calibration: Calibration,
        scale: float | None,
        network: DistanceNet | None,
        settings: FieldSettings,
        provenance: dict[str, Any],
    ) -> None:
        self.rules = rules
        self.head = head
        self.calibration = calibration
        self.scale = scale
        self.network = network
        self.settings = settings
        self.provenance = provenance

    @property
    def types(self) -> tuple[str, ...]:
        """The user types it knows."""
        return tuple(self.rules.rules)

    @classmethod
    def fit(
        cls,
        data: DemonstrationSet,
        *,
        seed: int = 0,
        progress: Progress = silent,
        network: DistanceNet | None = None,
        settings: FieldSettings | None = None,
        **named: Any,
    ) -> FieldModel:
        """Fits to the labelled demonstrations of all scenes of `data`.

        Args:
            network: Another distance network than the shipped one (also by its former name
                ``body``).
            settings: `FieldSettings`; or its fields by name.

        Raises:
            InputError: No labelled demonstrations, an unknown setting.
            CannotJudgeError: Scenes with neither picture nor list.
            MissingExtraError: torch is absent.
        """
        network = named.pop("body", network)
        settings = _settings(settings, named)
        if settings.device != "cpu":
            check_device(settings.device)
        provenance = provenance_of(data, seed=seed, libraries=("torch", "scipy"))
        scenes = list(data.scenes)
        pictured = [s for s in scenes if s.picture is not None]
        listed = any(s.objects for s in scenes)
        if not pictured and not listed:
            raise CannotJudgeError(
                "scenes with pictures or lists of objects", "neither", field="scenes"
            )
        scale = None
        if pictured:
            from demospec.perception import load_network

            network = load_network() if network is None else network
            scale = _common_scale(pictured, network)
        if settings.fine_tune and listed and pictured:
            from demospec.perception import tuned_network

            assert network is not None
            network = tuned_network(
                network, pictured, scale, seed=seed, device=settings.device, progress=progress
            )
        observed = observe_all(pictured, network, scale, progress) if pictured else []
        if not listed:
            _refuse_unfamiliar(observed)
        head = None
        if listed and pictured:
            from demospec.perception import fit_symbol_head

            head = fit_symbol_head(
                pictured, network=network, scale=scale, seed=seed,
                observations=[item.observation for item in observed],
            )  # fmt: skip
        start = Calibration({}, {})
        rules = fit_rules(data, observed, head, start, listed=listed)
        calibration = calibrate(observed, typical_clearance(rules), seed) if listed else start
        return cls(rules, head, calibration, scale, network, settings, provenance)

    def observe(self, scene: Scene) -> Observation:
        """What the network detects in the scene's picture.

        Raises:
            CannotJudgeError: No picture, or the model was fitted without any.
        """
        if self.network is None:
            raise CannotJudgeError(
                "a list of objects (this model was fitted without pictures)",
                "not listed", row=f"scene {scene.scene_id}", field="objects",
            )  # fmt: skip
        return observation_of(scene, self.network, self.scale)

    def unfamiliar(self, scenes: Iterable[Scene]) -> dict[str, str]:
        """Scene → why the network does not know pictures of its kind, of those judged by theirs."""
        lists = self.settings.use_lists and not (self.head is None and self.network is not None)
        found: dict[str, str] = {}
        for scene in scenes:
            if self.network is None or scene.picture is None or (lists and scene.objects):
                continue
            seen = observation_of(scene, self.network, self.scale, turns=(0,)).familiarity
            if seen is not None and not seen.familiar:
                found[scene.scene_id] = seen.reason
        return found

    def see(self, scene: Scene, *, use_lists: bool | None = None) -> FieldView:
        """Observes a scene.

        Args:
            use_lists: Believe the scene's list where there is one; by the settings if None.

        Raises:
            CannotJudgeError: The scene lacks what this model needs.
        """
        lists = self.settings.use_lists if use_lists is None else use_lists
        generic = self.head is None and self.network is not None
        if scene.objects is not None and lists and not generic:
            size = span_of(scene)
            shape = list_shape(size)
            return FieldView(self, scene, listed_objects(scene, size, shape), size, shape)
        observation = self.observe(scene)
        perceived = perceived_objects(observation, self.head, self.calibration)
        size = (float(observation.size_px[0]), float(observation.size_px[1]))
        shape = (observation.grid[1], observation.grid[0])
        return FieldView(self, scene, perceived, size, shape, observation.percent_map_px)

    def encode(self, scene: Scene, *, length: CodeLength | None = None) -> SceneCode:
        """The latent code of the scene's picture: a table, a lamp, and the detected objects.

        Raises:
            CannotJudgeError: As `observe`.
        """
        observation = self.observe(scene)
        classes = class_probabilities(observation.detections, self.head)
        names = {i: max(p, key=lambda name: p[name]) for i, p in enumerate(classes) if p}
        return read_scene_code(observation, pixels=scene.pixels(), length=length, names=names)

    def decode(self, code: SceneCode) -> Image:
        """The picture of a code, (height, width, 3)."""
        return draw_scene_code(code)

    def reconstruct(self, scene: Scene) -> Image:
        """The picture as far as the model detected it: what was missed is missing."""
        return self.decode(self.encode(scene))

    def sample_scenes(self, n: int, rng: np.random.Generator, like: Iterable[Scene]) -> list[Scene]:
        """New scenes with pictures and lists of what was put in, resembling those of `like`."""
        shown = [scene for scene in like if scene.picture is not None]
        codes = tuple(self.encode(scene) for scene in shown)
        sampler = SceneSampler(codes, tuple((scene.start, scene.goal) for scene in shown))
        return [scene for scene, _ in sampler.sample(n, rng)]

    def save(self, folder: str | os.PathLike[str], *, replace: bool = False) -> Path:
        """Writes the model as a folder, network included, so that it never changes."""
        weights: ModelWeights = {}
        if self.head is not None:
            for name in ("center", "scale", "weight", "bias"):
                weights[f"head.{name}"] = getattr(self.head, name)
        network_size = None
        if self.network is not None:
            from demospec.perception import arrays_of

            network_size = asdict(self.network.size)
            for key, value in arrays_of(self.network).items():
                weights[f"body.{key}"] = value.numpy()
        settings = {
            **asdict(self.settings),
            "rules": rules_document(self.rules)["types"],
            "units": self.rules.units,
            "metres_per_unit": self.rules.metres_per_unit,
            "head_classes": None if self.head is None else list(self.head.classes),
            "calibration": asdict(self.calibration),
            "scale": self.scale,
            "body": network_size,
        }
        return write_model_folder(
            folder, kind=self.kind, types=self.types, settings=settings,
            weights=weights, provenance=self.provenance, replace=replace,
        )  # fmt: skip

    @classmethod
    def load(cls, folder: str | os.PathLike[str]) -> FieldModel:
        """Reads what `save` wrote; InputError names what is wrong with it."""
        return cls.of(read_model_folder(folder))

    @classmethod
    def of(cls, stored: ModelFolder) -> FieldModel:
        """The model of a folder that was read."""
        file = None if stored.path is None else stored.path / "config.json"
        s = stored.settings
        try:
            known = {"device": "cpu", **s}  # earlier models do not name one
            settings = FieldSettings(**{f.name: known[f.name] for f in fields(FieldSettings)})
            learned = rules_of_settings(s["rules"], stored.types, "settings.rules")
            rules = RuleSet(learned, s.get("units", "px"), s.get("metres_per_unit"))
            calibration = Calibration(**s["calibration"])
            head_classes = s["head_classes"]
            scale = None if s["scale"] is None else float(s["scale"])
            network_size = s["body"]
        except (KeyError, TypeError, ValueError) as error:
            raise InputError("settings of a field model", repr(error), file=file) from None
        except InputError as error:
            raise error.at(file=file) from None
        head = None
        if head_classes is not None:
            width = len(stored.weight("head.center", (None,)))
            arrays = {
                name: stored.weight(f"head.{name}", shape)
                for name, shape in SymbolHead.shapes(len(head_classes), width).items()
            }
            head = SymbolHead(tuple(head_classes), **arrays)
        network = None
        if network_size is not None:
            from demospec.perception import appearance_count, network_of

            state = {
                key.removeprefix("body."): value
                for key, value in stored.weights.items()
                if key.startswith("body.")
            }
            network = network_of(state, network_size, file=file)
            if head is not None and len(head.center) != appearance_count(network.size):
                raise InputError(
                    f"a head on {appearance_count(network.size)} features (fit the model anew)",
                    len(head.center), file=file, field="head.center",
                )  # fmt: skip
        return cls(rules, head, calibration, scale, network, settings, dict(stored.provenance))


def _refuse_unfamiliar(observed: Sequence[ObservedScene]) -> None:
    """Nothing is learned from pictures alone where the network knows fewer than half of them."""
    known = [item.observation.familiarity for item in observed]
    strange = [f.reason for f in known if f is not None and not f.familiar]
    if 2 * len(strange) > len(known):
        why = max(set(strange), key=strange.count)
        raise CannotJudgeError(
            "lists of the objects, or a --detector of your own",
            f"pictures that the network does not know ({len(strange)} of {len(known)}: {why})",
            field="scenes",
        )


def _settings(settings: FieldSettings | None, named: dict[str, Any]) -> FieldSettings:
    known = [f.name for f in fields(FieldSettings)]
    for name, value in named.items():
        if name not in known:
            raise InputError(f"a setting ({', '.join(known)})", name, field="settings")
        if name == "device":
            if not isinstance(value, str):
                raise InputError("the name of a device", value, field=name)
        elif not isinstance(value, bool):
            raise InputError("true or false", value, field=name)
    if settings is not None and named:
        raise InputError("settings, or their fields by name", "both", field="settings")
    return settings or FieldSettings(**named)


def _common_scale(scenes: list[Scene], network: DistanceNet) -> float | None:
    """Map pixels per picture pixel where all training pictures have one size; else None."""
    sizes = {max(s.size_px) for s in scenes if s.size_px is not None}
    return network.table_width_px / sizes.pop() if len(sizes) == 1 else None
