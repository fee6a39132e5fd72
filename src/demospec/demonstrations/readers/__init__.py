"""Readers of other formats: one module a format, one way to decide what they mean."""

from demospec.demonstrations.readers._convert import Conversion, convert, read_source
from demospec.demonstrations.readers._guess import FORMATS, guess_format
from demospec.demonstrations.readers._mapping import (
    Mapping,
    column_options,
    read_mapping,
    with_options,
)
from demospec.demonstrations.readers._projection import Projection, fit_homography
from demospec.demonstrations.readers._reading import Reading
from demospec.demonstrations.readers._recording import ListedObjects
from demospec.demonstrations.readers.annotations._objects import read_objects
from demospec.demonstrations.readers.annotations._shapes import mask_outline
from demospec.demonstrations.readers.ros import (
    Bag,
    frame_of,
    is_path_type,
    open_bag,
    points_of,
    stamp_of,
)
from demospec.demonstrations.readers.tables._labels import read_label_table

__all__ = [
    "FORMATS",
    "Bag",
    "Conversion",
    "ListedObjects",
    "Mapping",
    "Projection",
    "Reading",
    "column_options",
    "convert",
    "fit_homography",
    "frame_of",
    "guess_format",
    "is_path_type",
    "mask_outline",
    "open_bag",
    "points_of",
    "read_label_table",
    "read_mapping",
    "read_objects",
    "read_source",
    "stamp_of",
    "with_options",
]
