"""Scenes through a model's latent space: reconstructions, and samples like them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet
from demospec.errors import CannotJudgeError, InputError
from demospec.progress import Progress, silent
from demospec.scene import Image, Picture, Scene
from demospec.specification.models.beta_vae._model import LATENT, PaperModel
from demospec.specification.models.beta_vae._training_data import network_image
from demospec.specification.models.perceived_rule._model import FieldModel


@dataclass(frozen=True)
class Reconstruction:
    """A scene's picture after encoder and decoder.

    Args:
        scene_id: Of the scene.
        picture: (h, w, 3) uint8.
        rmse: Root mean squared error of its pixels, 1 = white.
        numbers: Length of the code between the two.
        things: Of the code; None where the code knows of no things.
    """

    scene_id: str
    picture: Image
    rmse: float
    numbers: int
    things: int | None

    @property
    def psnr_db(self) -> float:
        """Peak signal to noise ratio, decibel."""
        return float(-20 * np.log10(max(self.rmse, 1e-9)))

    def to_json(self) -> dict[str, Any]:
        """Everything but the picture."""
        return {
            "scene_id": self.scene_id,
            "rmse": self.rmse,
            "psnr_db": self.psnr_db,
            "numbers": self.numbers,
            "things": self.things,
        }


def reconstruct_scenes(
    model: object, scenes: Sequence[Scene], *, progress: Progress = silent
) -> list[Reconstruction]:
    """Every scene as the model saw it; scenes without a picture are left out.

    The paper's model works on 100 x 100 pixels and is compared with the picture at that size.

    Raises:
        InputError: A model without a decoder.
        CannotJudgeError: No scene has a picture.
    """
    fitted = _with_decoder(model)
    shown = [scene for scene in scenes if scene.picture is not None]
    if not shown:
        raise CannotJudgeError("scenes with pictures", "none", field="scenes")
    out = []
    for done, scene in enumerate(shown):
        if isinstance(fitted, PaperModel):
            picture, numbers, things = fitted.reconstruct(scene), LATENT, None
            true = network_image(scene).transpose(1, 2, 0).astype(np.float64)
        else:
            code = fitted.encode(scene)
            picture, numbers, things = fitted.decode(code), code.numbers, len(code.objects)
            true = scene.pixels() / 255.0
        error = float(np.sqrt(np.mean((picture / 255.0 - true) ** 2)))
        out.append(Reconstruction(scene.scene_id, picture, error, numbers, things))
        progress("reconstructing", done + 1, len(shown))
    return out


def set_of_sampled_scenes(
    model: object, data: DemonstrationSet, n: int, *, seed: int = 0
) -> DemonstrationSet:
    """A set of n new scenes that resemble the training scenes of `data`.

    A `field` model's scenes list what was put in; those of the paper's model list nothing. A
    set needs demonstrations: each scene has a straight line from start to goal that nobody
    judged.

    Raises:
        InputError: A model without a decoder, n below 1.
        CannotJudgeError: No scene of `data` has a picture.
    """
    fitted = _with_decoder(model)
    if n < 1:
        raise InputError("a count of at least 1", n, field="n")
    pictured = [scene for scene in data.scenes if scene.picture is not None]
    like = [scene for scene in pictured if scene.split != "test"] or pictured
    if not like:
        raise CannotJudgeError("scenes with pictures", "none", field="scenes")
    rng = np.random.default_rng(seed)
    if isinstance(fitted, PaperModel):
        pictures = fitted.sample_scenes(n, rng)
        width, height = like[0].shown_picture().size_px
        scale = np.array([pictures.shape[2] / width, pictures.shape[1] / height])
        ends = [tuple((np.array(p[:2]) * scale).tolist()) for p in (like[0].start, like[0].goal)]
        scenes = [
            Scene(f"sampled-{i:04d}", ends[0], ends[1], None, Picture(array=picture))
            for i, picture in enumerate(pictures)
        ]
        metres = None if data.metres_per_unit is None else data.metres_per_unit / float(scale[0])
    else:
        scenes = fitted.sample_scenes(n, rng, like)
        metres = data.metres_per_unit
    lines = [
        Demonstration(f"{s.scene_id}-line", s.scene_id, np.array([s.start[:2], s.goal[:2]]))
        for s in scenes
    ]
    used = {item.symbol for scene in scenes for item in scene.objects or ()}
    return replace(
        data,
        scenes=tuple(scenes),
        demonstrations=Demonstrations.of(lines),
        name=f"{data.name}, sampled",
        metres_per_unit=metres,
        symbols=(*data.symbols, *sorted(used - set(data.symbols))),
        columns=("x", "y"),
        extra=(),
    )


def _with_decoder(model: object) -> FieldModel | PaperModel:
    if not isinstance(model, (FieldModel, PaperModel)):
        found = str(getattr(model, "kind", "a rule"))
        raise InputError("a field or paper model (they have a decoder)", found, field="MODEL")
    return model
