"""Bags of ROS 2 and ROS 1 and MCAP files: pose, path, transform and joint topics as paths."""

from demospec.demonstrations.readers.ros._bag import Bag
from demospec.demonstrations.readers.ros._bags import open_bag
from demospec.demonstrations.readers.ros._messages import (
    frame_of,
    is_path_type,
    points_of,
    stamp_of,
)

__all__ = ["Bag", "frame_of", "is_path_type", "open_bag", "points_of", "stamp_of"]
