"""Every table and figure of the paper, measured again, beside the paper's own numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.experiments.paper._stages import ReproduceSettings, reproduce

__all__ = ["ReproduceSettings", "reproduce"]


__getattr__ = names_of(__name__, {"ReproduceSettings": "_stages", "reproduce": "_stages"})
