"""The distance network (a small U-Net with heads) and its weights."""

from __future__ import annotations

from typing import TYPE_CHECKING

from demospec._lazy import names_of

if TYPE_CHECKING:
    from demospec.perception.network._backbone import Backbone, NetworkSize
    from demospec.perception.network._distance_net import DistanceNet
    from demospec.perception.network._weights import (
        SHIPPED,
        arrays_of,
        load_network,
        network_of,
        recipe_of,
        save_network,
    )

__all__ = [
    "SHIPPED",
    "Backbone",
    "DistanceNet",
    "NetworkSize",
    "arrays_of",
    "load_network",
    "network_of",
    "recipe_of",
    "save_network",
]

_HOME = {
    "SHIPPED": "_weights",
    "Backbone": "_backbone",
    "DistanceNet": "_distance_net",
    "NetworkSize": "_backbone",
    "arrays_of": "_weights",
    "load_network": "_weights",
    "network_of": "_weights",
    "recipe_of": "_weights",
    "save_network": "_weights",
}


__getattr__ = names_of(__name__, _HOME)
