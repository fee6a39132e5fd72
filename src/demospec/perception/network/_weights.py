"""Reading and writing bodies: safetensors with the recipe inside, never a pickle."""

from __future__ import annotations

import json
import os
from functools import lru_cache
from pathlib import Path
from typing import Any

from demospec.errors import InputError, MissingExtraError
from demospec.files import read_bytes, writing_file

SHIPPED = Path(__file__).parents[1] / "weights" / "body.safetensors"
"""The body that comes with the package; `demospec pretrain` made it."""


def need_torch(what: str) -> None:
    """MissingExtraError where torch is absent."""
    try:
        import torch  # noqa: F401
    except ImportError as error:
        raise MissingExtraError("torch", "vision", what) from error


def save_body(out: Path, body: Any, recipe: dict[str, Any]) -> None:
    """Folds, rounds to float16 and writes `out` and its recipe beside it as ``.json``."""
    from safetensors.torch import save_file

    from demospec.perception.network._distance_net import folded

    state = {k: v.half().contiguous() for k, v in folded(body).state_dict().items()}
    with writing_file(out) as temporary:
        save_file(state, str(temporary), metadata={"recipe": json.dumps(recipe)})
    with writing_file(out.with_suffix(".json")) as temporary:
        temporary.write_text(json.dumps(recipe, indent=1) + "\n", encoding="utf-8")


def load_body(path: str | os.PathLike[str] | None = None) -> Any:
    """The body of a weights file (the shipped one by default), ready for inference.

    Returns:
        `Body`, batch norms folded, float32. Shared by all callers:
        copy it before training it.

    Raises:
        InputError: Not weights of a body.
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
        raise InputError("weights of a body (safetensors)", str(error), file=file) from None
    if not isinstance(recipe, dict) or "settings" not in recipe:
        raise InputError("weights of a body with their recipe", "none", file=file, field="recipe")
    return body_from(state, recipe["settings"].get("body", {}), file=file)


def body_from(state: dict[str, Any], size: dict[str, Any], *, file: Path | None = None) -> Any:
    """A folded body from its arrays; InputError where they do not fit."""
    from demospec.perception.network._distance_net import empty_folded, size_from

    try:
        body = empty_folded(size_from(size))
        # Weights of before there was a judge, a joiner or doubt: these then know nothing. Those of
        # before tables had a width were trained on tables of 100 pixels.
        neutral = {
            k: v
            for k, v in body.state_dict().items()
            if k.startswith(("judge_", "joiner_", "doubt."))
        }
        neutral["table_px"] = body.state_dict()["table_px"].new_full((1,), 100.0)
        body.load_state_dict({**neutral, **state})
    except (RuntimeError, KeyError, TypeError, ValueError) as error:
        raise InputError("weights of a body", str(error), file=file) from None
    return body.eval()


def recipe_of(path: str | os.PathLike[str] | None = None) -> dict[str, Any]:
    """The recipe saved in a weights file."""
    from safetensors import safe_open

    with safe_open(str(SHIPPED if path is None else path), framework="np") as stored:
        document: dict[str, Any] = json.loads((stored.metadata() or {})["recipe"])
    return document
