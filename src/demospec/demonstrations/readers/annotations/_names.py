"""What an annotated picture may be called."""

from __future__ import annotations

from demospec.demonstrations.readers.annotations._drawn import base_name


def names_of(name: str) -> tuple[str, ...]:
    """A picture's name as written, without folders (of any system), and without its ending."""
    plain = base_name(name)
    stem = plain.rpartition(".")[0] or plain
    return tuple(dict.fromkeys([name, name.replace("\\", "/"), plain, stem]))
