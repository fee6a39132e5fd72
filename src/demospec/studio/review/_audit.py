"""Labels that look wrong: what the audit of the commands would have reviewed."""

from __future__ import annotations

from demospec.errors import DemospecError
from demospec.studio.session._workspace import Workbench

MOST_AUDITED = 1000
"""Demonstrations of one basis up to which labels are audited while somebody waits."""


def doubtful_labels(bench: Workbench) -> list[dict[str, str]]:
    """Labels that the audit of the commands would have reviewed, with its reasons."""
    from demospec.specification import audit_set

    found: list[dict[str, str]] = []
    for basis in bench.bases():
        data = bench.comparable(basis)
        if data is None or len(data.demonstrations) > MOST_AUDITED:
            continue
        try:
            entries = audit_set(data).to_json()["demonstrations"]
        except DemospecError:  # nothing to audit by
            continue
        found += [
            {"demo_id": str(e["demo_id"]), "why": str(e["why"])}
            for e in entries
            if e["verdict"] == "review"
        ]
    return found
