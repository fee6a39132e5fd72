"""Every table and figure of the paper, measured again, beside the paper's own numbers."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from demospec.reproduction._stages import ReproduceSettings, reproduce

__all__ = ["ReproduceSettings", "reproduce"]


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(importlib.import_module("demospec.reproduction._stages"), name)
    raise AttributeError(f"module 'demospec.reproduction' has no attribute {name!r}")
