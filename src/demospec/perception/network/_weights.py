"""Weights of distance networks: safetensors with the recipe inside, never a pickle."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from demospec.errors import InputError, MissingExtraError
from demospec.files import read_bytes, writing_file

if TYPE_CHECKING:
    from demospec.perception.network._distance_net import DistanceNet

SHIPPED = Path(__file__).parents[1] / "weights" / "body.safetensors"
"""The network that comes with the package; `demospec pretrain` made it."""


def need_torch(what: str) -> None:
    """MissingExtraError where torch is absent."""
    try:
        import torch  # noqa: F401
    except ImportError as error:
        raise MissingExtraError("torch", "vision", what) from error


def save_network(out: Path, network: DistanceNet, recipe: dict[str, Any]) -> None:
    """Folds, rounds to float16 and writes `out` and its recipe beside it as ``.json``."""
    from safetensors.torch import save_file

    from demospec.perception.network._distance_net import folded

    state = {k: v.half().contiguous() for k, v in arrays_of(folded(network)).items()}
    with writing_file(out) as temporary:
        save_file(state, str(temporary), metadata={"recipe": json.dumps(recipe)})
    with writing_file(out.with_suffix(".json")) as temporary:
        temporary.write_text(json.dumps(recipe, indent=1) + "\n", encoding="utf-8")


def load_network(path: str | os.PathLike[str] | None = None) -> Any:
    """The network of a weights file (the shipped one by default), ready for inference.

    Returns:
        `DistanceNet`, batch norms folded, float32. Shared by all callers:
        copy it before training it.

    Raises:
        InputError: Not weights of a distance network.
        MissingExtraError: torch is absent.
    """
    need_torch("looking at pictures")
    file = SHIPPED if path is None else Path(path)
    if path is None and not file.is_file():
        raise InputError("the package's weights (run demospec pretrain)", "no file", file=file)
    read_bytes(file, limit_bytes=1 << 28)
    return _loaded(str(file), file.stat().st_mtime_ns)


@lru_cache(maxsize=4)
def _loaded(name: str, changed: int) -> Any:
    del changed  # part of the key only
    from safetensors import SafetensorError, safe_open

    file = Path(name)
    try:
        with safe_open(name, framework="pt") as stored:
            metadata = stored.metadata() or {}
            names = list(stored.keys())  # it is no dict
            state = {key: stored.get_tensor(key).float() for key in names}
        recipe = json.loads(metadata.get("recipe", "null"))
    except (SafetensorError, ValueError, OSError) as error:
        raise InputError(
            "weights of a distance network (safetensors)", str(error), file=file
        ) from None
    if not isinstance(recipe, dict) or "settings" not in recipe:
        raise InputError(
            "weights of a distance network with their recipe", "none", file=file, field="recipe"
        )
    return network_of(state, recipe["settings"].get("body", {}), file=file)


_ON_DISK = (
    ("judge_", "objectness_"),
    ("joiner_", "merging_"),
    ("doubt.", "uncertainty."),
    ("familiarity_", "familiarity_"),
)
"""First words of the arrays of the heads in files, and in a `DistanceNet`."""

_HEADS = tuple(name for _, name in _ON_DISK)


def arrays_of(network: DistanceNet) -> dict[str, Any]:
    """The tensors of a network by their names in files."""
    return {_renamed(key, to_file=True): value for key, value in network.state_dict().items()}


def _renamed(key: str, *, to_file: bool) -> str:
    for in_file, in_network in _ON_DISK:
        old, new = (in_network, in_file) if to_file else (in_file, in_network)
        if key.startswith(old):
            return new + key.removeprefix(old)
    if key == "table_px":
        return key
    return key.removeprefix("backbone.") if to_file else f"backbone.{key}"


def network_of(
    arrays: Mapping[str, Any], size: Mapping[str, Any], *, file: Path | None = None
) -> DistanceNet:
    """A folded network from its tensors (or NumPy arrays), as `arrays_of` names them.

    Raises:
        InputError: They do not fit.
        MissingExtraError: torch is absent.
    """
    need_torch("a distance network")
    import numpy as np
    import torch

    from demospec.perception.network._distance_net import empty_folded, size_from

    try:
        network = empty_folded(size_from(size))
        # Files of before there were heads: these then know nothing. Those of before tables had a
        # width were trained on tables of 100 pixels.
        neutral = {k: v for k, v in network.state_dict().items() if k.startswith(_HEADS)}
        neutral["table_px"] = network.state_dict()["table_px"].new_full((1,), 100.0)
        given = {
            _renamed(key, to_file=False): torch.from_numpy(np.array(value))
            if isinstance(value, np.ndarray)
            else value
            for key, value in arrays.items()
        }
        network.load_state_dict({**neutral, **given})
    except (RuntimeError, KeyError, TypeError, ValueError) as error:
        raise InputError("weights of a distance network", str(error), file=file) from None
    return network.eval()


def recipe_of(path: str | os.PathLike[str] | None = None) -> dict[str, Any]:
    """The recipe saved in a weights file."""
    from safetensors import safe_open

    with safe_open(str(SHIPPED if path is None else path), framework="np") as stored:
        document: dict[str, Any] = json.loads((stored.metadata() or {})["recipe"])
    return document
