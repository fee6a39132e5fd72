"""What an open bag gives: its topics, and messages in the order of recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

Messages = Iterator[tuple[str, float, Any]]


@dataclass(frozen=True)
class Bag:
    """An open bag.

    Args:
        topics: Topic → types of its messages, such as ``geometry_msgs/msg/PoseStamped``; more
            than one where several senders disagree.
        messages: Topics → (topic, seconds of recording, decoded message), in recorded order.
    """

    topics: dict[str, tuple[str, ...]]
    messages: Callable[[list[str]], Messages]
