"""A model on disk: config.json, weights.safetensors, provenance.json. Never a pickle."""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import DemonstrationSet
from demospec.errors import InputError
from demospec.files import read_bytes, read_json, write_json, writing_folder

FORMAT = "demospec-model"
FORMAT_VERSION = 1
MAX_WEIGHTS_BYTES = 1 << 30

ModelWeights = dict[str, NDArray[np.float32]]


@dataclass(frozen=True)
class ModelFolder:
    """What a model folder holds.

    Args:
        kind: ``paper``, ``irl`` or ``field``.
        types: User types, in the order of the weights.
        settings: How it was fitted; numbers, words, lists.
        weights: Arrays by name.
        provenance: Versions, seed, data hash.
        path: Where it was read, for messages.
    """

    kind: str
    types: tuple[str, ...]
    settings: Mapping[str, Any]
    weights: ModelWeights
    provenance: Mapping[str, Any]
    path: Path | None = None

    def weight(self, name: str, shape: tuple[int | None, ...]) -> NDArray[np.float32]:
        """One array, checked; None in `shape` stands for any length.

        Raises:
            InputError: Absent, of another shape, or not finite.
        """
        file = None if self.path is None else self.path / "weights.safetensors"
        array = self.weights.get(name)
        if array is None:
            raise InputError("an array of that name", "none", file=file, field=name)
        fits = len(shape) == array.ndim and all(
            want is None or want == got for want, got in zip(shape, array.shape, strict=True)
        )
        if not fits:
            want = "x".join("n" if n is None else str(n) for n in shape)
            raise InputError(f"shape {want}", str(array.shape), file=file, field=name)
        if not np.isfinite(array).all():
            raise InputError("finite numbers", "NaN or infinity", file=file, field=name)
        return array


def write_model_folder(
    folder: str | os.PathLike[str],
    *,
    kind: str,
    types: tuple[str, ...],
    settings: Mapping[str, Any],
    weights: Mapping[str, NDArray[Any]],
    provenance: Mapping[str, Any],
    replace: bool = False,
) -> Path:
    """Writes a model folder, whole or not at all; the same model gives the same bytes."""
    from safetensors.numpy import save_file

    config = {
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "kind": kind,
        "types": list(types),
        "settings": dict(settings),
    }
    arrays = {k: np.ascontiguousarray(v, dtype=np.float32) for k, v in weights.items()}
    with writing_folder(folder, replace=replace) as root:
        write_json(root / "config.json", config)
        save_file(arrays, root / "weights.safetensors")
        # The library writes it readable by its owner only; the folder's other files are not.
        (root / "weights.safetensors").chmod((root / "config.json").stat().st_mode & 0o777)
        write_json(root / "provenance.json", dict(provenance))
    return Path(folder)


def read_model_folder(folder: str | os.PathLike[str]) -> ModelFolder:
    """Reads a model folder.

    Raises:
        InputError: Naming the file, the field, what was expected and what came.
    """
    root = Path(folder)
    file = root / "config.json"
    config = read_json(file, limit_bytes=1 << 24)
    if not isinstance(config, dict) or config.get("format") != FORMAT:
        found = config.get("format") if isinstance(config, dict) else type(config).__name__
        raise InputError(f"a model (format {FORMAT})", found, file=file, field="format")
    number = config.get("version")
    if not isinstance(number, int) or number > FORMAT_VERSION:
        expected = f"at most {FORMAT_VERSION} (a newer demospec wrote this model)"
        raise InputError(expected, number, file=file, field="version")
    kind = config.get("kind")
    if not isinstance(kind, str):
        raise InputError("paper, field or irl", kind, file=file, field="kind")
    types = config.get("types")
    if (
        not isinstance(types, list)
        or not types
        or not all(isinstance(t, str) and t for t in types)
        or len(set(types)) != len(types)
    ):
        raise InputError("a list of different type names", types, file=file, field="types")
    settings = config.get("settings", {})
    if not isinstance(settings, dict):
        raise InputError("an object", settings, file=file, field="settings")
    provenance_file = root / "provenance.json"
    provenance = read_json(provenance_file, limit_bytes=1 << 24)
    if not isinstance(provenance, dict):
        raise InputError("an object", type(provenance).__name__, file=provenance_file)
    return ModelFolder(kind, tuple(types), settings, _read_weights(root), provenance, path=root)


def _read_weights(root: Path) -> ModelWeights:
    from safetensors import SafetensorError
    from safetensors.numpy import load

    file = root / "weights.safetensors"
    data = read_bytes(file, limit_bytes=MAX_WEIGHTS_BYTES)
    try:
        arrays = load(data)
    except (SafetensorError, KeyError, ValueError, TypeError) as error:
        raise InputError("safetensors weights", str(error) or "something else", file=file) from None
    return {name: np.asarray(array, dtype=np.float32) for name, array in arrays.items()}


def provenance_of(
    data: DemonstrationSet, *, seed: int, libraries: tuple[str, ...]
) -> dict[str, Any]:
    """Where a model comes from: versions of what computed it, seed, hash of the data."""
    versions = {"python": platform.python_version()}
    for library in ("demospec", "numpy", *libraries):
        try:
            versions[library] = version(library)
        except PackageNotFoundError:
            versions[library] = "absent"
    return {
        "versions": versions,
        "seed": seed,
        "data": {
            "name": data.name,
            "sha256": data_hash(data),
            "scenes": len(data.scenes),
            "demonstrations": len(data.demonstrations),
        },
    }


def data_hash(data: DemonstrationSet) -> str:
    """SHA-256 over everything a model can learn from: pictures, objects, paths, labels."""
    digest = hashlib.sha256()

    def add(*parts: object) -> None:
        for part in parts:
            raw = part if isinstance(part, bytes) else repr(part).encode()
            digest.update(len(raw).to_bytes(8, "little") + raw)

    add(data.types, data.symbols, data.columns, data.units, data.metres_per_unit)
    for scene in data.scenes:
        add(scene.scene_id, scene.start, scene.goal, scene.split)
        add([item.to_json() for item in scene.objects or ()])
        if scene.picture is not None:
            pixels = scene.picture.pixels
            add(pixels.shape, pixels.tobytes())
    d = data.demonstrations
    add(list(d.demo_id), list(d.scene_id), list(d.type), list(d.demonstrator))
    add(d.valid.tobytes(), d.flat.tobytes(), d.offsets.tobytes())
    return digest.hexdigest()
