"""``torchvision:``: a detection model of torchvision with weights that lie on this machine."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from demospec.errors import InputError, MissingExtraError
from demospec.perception.detectors._onnx import names_beside
from demospec.perception.detectors._protocol import Finding
from demospec.scene import Image

_HEADS = ("roi_heads.box_predictor.cls_score.weight",)
"""Where a weight file of the R-CNN family says how many classes it has."""


def torchvision_detector(argument: str) -> TorchvisionDetector:
    """``NAME`` or ``NAME:WEIGHTS.pth``."""
    model, _, weights = argument.partition(":")
    return TorchvisionDetector(model, weights or None)


class TorchvisionDetector:
    """A model of ``torchvision.models.detection``, such as ``maskrcnn_resnet50_fpn``.

    Nothing is downloaded: the weights are the file given, else those of the model that torch's
    own cache already holds. The file is read as weights only. Names are those in a file beside it
    (`names_beside`), else COCO's, which the weights of torchvision have.

    Raises:
        MissingExtraError: torchvision is not installed.
        InputError: No model of that name, no weights, or weights of another model.
    """

    def __init__(self, model: str, weights: str | os.PathLike[str] | None = None) -> None:
        try:
            import torch
            from torchvision.models import detection as module
            from torchvision.models import get_model, get_model_weights, list_models
        except ImportError as error:
            raise MissingExtraError("torchvision", "vision", "its detectors") from error
        known = list_models(module=module)
        if model not in known:
            raise InputError(f"one of {', '.join(known)}", model, field="--detector torchvision")
        shipped = next(iter(get_model_weights(model)))
        file = _weights(shipped.url, weights, torch.hub.get_dir())
        try:
            state = torch.load(file, map_location="cpu", weights_only=True)
        except Exception as error:  # a broken archive, or a pickle of more than weights
            line = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise InputError("a file of weights alone", line, file=file) from error
        if isinstance(state, dict) and isinstance(state.get("model"), dict):
            state = state["model"]  # as torchvision's own training script saves it
        heads = [state[k] for k in _HEADS if isinstance(state, dict) and k in state]
        classes = {"num_classes": int(heads[0].shape[0])} if heads else {}
        self._model: Any = get_model(model, weights=None, weights_backbone=None, **classes)
        try:
            self._model.load_state_dict(state)
        except (RuntimeError, TypeError, AttributeError) as error:
            line = str(error).splitlines()[0]
            raise InputError(f"weights of {model}", line, file=file) from error
        self._model.eval()
        self._model_name, self._file = model, Path(file)
        self.classes = names_beside(self._file)
        said = shipped.meta["categories"]
        if not self.classes and (not heads or len(said) == heads[0].shape[0]):
            self.classes = dict(enumerate(said))

    @property
    def name(self) -> str:
        """``torchvision:``, the model, and the file of its weights."""
        return f"torchvision:{self._model_name}:{self._file.name}"

    def detect(self, pixels: Image, names: Sequence[str] = ()) -> list[Finding]:
        """The things in a picture."""
        import torch

        del names
        picture = torch.from_numpy(np.ascontiguousarray(pixels.transpose(2, 0, 1))).float() / 255
        with torch.inference_mode():
            found = self._model([picture])[0]
        corners = found["boxes"].double().numpy()
        scores, labels = found["scores"].numpy(), found["labels"].numpy()
        masks = found["masks"][:, 0].numpy() > 0.5 if "masks" in found else None
        out = []
        for i, (left, top, right, low) in enumerate(corners.tolist()):
            mask = None if masks is None or not masks[i].any() else masks[i]
            symbol = self.classes.get(int(labels[i]), str(int(labels[i])))
            sides = (left, top, right - left, low - top)
            out.append(Finding(symbol, float(min(scores[i], 1.0)), bbox=sides, mask=mask))
        return out


def _weights(url: str, given: str | os.PathLike[str] | None, cache: str) -> Path:
    if given is not None:
        file = Path(given)
        if not file.is_file():
            raise InputError("a file of weights", "nothing there", file=file)
        return file
    file = Path(cache) / "checkpoints" / url.rsplit("/", 1)[-1]
    if not file.is_file():
        raise InputError(f"torchvision:NAME:WEIGHTS.pth (nothing is downloaded; {file.name} is "
                         "not in torch's cache)", "no weights", field="--detector")  # fmt: skip
    return file
