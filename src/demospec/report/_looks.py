"""Colours and marks, one for each meaning, in every picture of the report and of the studio."""

from __future__ import annotations

ACCEPTED = "#0072b2"
REJECTED = "#d55e00"
NEUTRAL = "#000000"
"""Okabe–Ito blue and vermilion: told apart by colour-blind readers, and by line style in grey."""

RING = "#cc79a7"
"""A clearance about an object."""

INFLUENCE = "#e69f00"
"""The paper's radii about centres."""

_MODELS = {
    "field": ("#0072b2", "o"),
    "paper": ("#d55e00", "D"),
    "full": ("#d55e00", "D"),  # the paper's model by the name that its ablations give it
    "truth": ("#000000", "x"),
    "autoencoder": ("#e69f00", "s"),
    "classifier": ("#009e73", "^"),
    "irl": ("#cc79a7", "v"),
}
_OTHERS = (("#56b4e9", "P"), ("#8c6d31", "*"), ("#666666", "h"))


def look_of(model: str, others: tuple[str, ...] = ()) -> tuple[str, str]:
    """Colour and matplotlib marker of a model, the same wherever it is shown.

    Args:
        others: All models of the picture: those that have no look of their own get one by place.
    """
    if model in _MODELS:
        return _MODELS[model]
    unknown = [name for name in others if name not in _MODELS]
    place = unknown.index(model) if model in unknown else 0
    return _OTHERS[place % len(_OTHERS)]
