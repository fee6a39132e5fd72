"""Training: pretraining of the network and its heads, fine-tuning, symbol heads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.perception.training._familiarity import fit_familiarity_head
    from demospec.perception.training._heads import (
        HeadPictures,
        fit_merging_head,
        fit_objectness_head,
        fit_uncertainty_head,
        label_of,
    )
    from demospec.perception.training._pretrain import PretrainSettings, pretrain
    from demospec.perception.training._symbol_head import fit_symbol_head
    from demospec.perception.training._synthetic_set import paint
    from demospec.perception.training._tune import TuneSettings, tuned_network

__all__ = [
    "HeadPictures",
    "PretrainSettings",
    "TuneSettings",
    "fit_familiarity_head",
    "fit_merging_head",
    "fit_objectness_head",
    "fit_symbol_head",
    "fit_uncertainty_head",
    "label_of",
    "paint",
    "pretrain",
    "tuned_network",
]

_HOME = {
    "HeadPictures": "_heads",
    "PretrainSettings": "_pretrain",
    "TuneSettings": "_tune",
    "fit_familiarity_head": "_familiarity",
    "fit_merging_head": "_heads",
    "fit_objectness_head": "_heads",
    "fit_symbol_head": "_symbol_head",
    "fit_uncertainty_head": "_heads",
    "label_of": "_heads",
    "paint": "_synthetic_set",
    "pretrain": "_pretrain",
    "tuned_network": "_tune",
}


__getattr__ = names_of(__name__, _HOME)
