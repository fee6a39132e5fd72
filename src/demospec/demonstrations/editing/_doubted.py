"""Labels that an audit doubts: which of a set they are, and how many may be changed at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from demospec.demonstrations._set import DemonstrationSet
from demospec.errors import InputError

MOST = 0.2
"""Share of one type's labels that an audit may change at once. Beyond it, the rule that doubts
the labels is more likely wrong than they are."""


def doubted(
    data: DemonstrationSet, entries: Sequence[Mapping[str, Any]], ids: Sequence[str] | None = None
) -> list[str]:
    """Demonstrations of a set that the entries of an audit would have reviewed.

    Args:
        entries: ``demonstrations`` of the audit's JSON document.
        ids: Only these; all where None.

    Raises:
        InputError: An entry that is not of this set: an unknown demonstration, or one with
            another scene, type or label than the audit saw; an id that is not to be reviewed.
    """
    d = data.demonstrations
    row_of = {str(name): i for i, name in enumerate(d.demo_id)}
    found: list[str] = []
    for i, entry in enumerate(entries):
        if entry.get("verdict") != "review":
            continue
        name = entry.get("demo_id")
        if not isinstance(name, str) or name not in row_of:
            raise InputError(
                "a demonstration of the set", name, field=f"demonstrations[{i}].demo_id"
            )
        row = row_of[name]
        label = None if d.valid[row] < 0 else bool(d.valid[row])
        mine = {"scene_id": d.scene_id[row], "type": d.type[row], "valid": label}
        for key, value in mine.items():
            if key in entry and entry[key] != value:
                raise InputError(
                    f"{value}, as the set has it (the audit is of another set)",
                    entry[key],
                    row=name,
                    field=key,
                )
        found.append(name)
    for name in ids or ():
        if name not in found:
            raise InputError("a demonstration that the audit would have reviewed", name,
                             field="--ids")  # fmt: skip
    return found if ids is None else [name for name in found if name in set(ids)]


def refuse_many(data: DemonstrationSet, names: Sequence[str]) -> None:
    """InputError where `names` are more than `MOST` of the labels of some type."""
    d = data.demonstrations
    labelled = Counter(str(t) for t, v in zip(d.type, d.valid, strict=True) if v >= 0)
    chosen = set(names)
    changed = Counter(
        str(t) for t, name in zip(d.type, d.demo_id, strict=True) if str(name) in chosen
    )
    for name, count in changed.items():
        if count > max(1.0, MOST * labelled[name]):
            raise InputError(
                f"at most {MOST:.0%} of the labels of a type to change "
                "(--ids for some of them, --anyway for all)",
                f"{count} of {labelled[name]} of {name}",
                field="--audit",
            )
