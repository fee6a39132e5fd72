"""Synthetic training pictures with exact answers: objects, tables, cameras, light."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.perception.synthetic._backgrounds import NoiseBank
    from demospec.perception.synthetic._camera import Camera
    from demospec.perception.synthetic._pictures import CHANNELS, make_picture
    from demospec.perception.synthetic._rendered import render_picture
    from demospec.perception.synthetic._solids import make_solid
    from demospec.perception.synthetic._things import (
        CLEAR_SHARE,
        SyntheticObject,
        kind_shares,
        make_object,
    )

__all__ = [
    "CHANNELS",
    "CLEAR_SHARE",
    "Camera",
    "NoiseBank",
    "SyntheticObject",
    "kind_shares",
    "make_object",
    "make_picture",
    "make_solid",
    "render_picture",
]

_HOME = {
    "CHANNELS": "_pictures",
    "CLEAR_SHARE": "_things",
    "Camera": "_camera",
    "NoiseBank": "_backgrounds",
    "SyntheticObject": "_things",
    "kind_shares": "_things",
    "make_object": "_things",
    "make_picture": "_pictures",
    "make_solid": "_solids",
    "render_picture": "_rendered",
}


__getattr__ = names_of(__name__, _HOME)
