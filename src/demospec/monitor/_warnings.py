"""Warnings that noise neither raises nor interrupts: due for a while, and kept for a while."""

from __future__ import annotations

from dataclasses import dataclass, replace

from demospec.monitor._results import Finding

_Key = tuple[str, str | None]


@dataclass
class _Warning:
    since: float
    last: float
    given: bool = False


class Warnings:
    """The warnings of one monitor, by constraint and object.

    Args:
        confirm_s: Given once it has been due for so many seconds.
        hold_s: Taken back once it has not been due for so many seconds.
    """

    def __init__(self, confirm_s: float, hold_s: float) -> None:
        self.confirm_s = confirm_s
        self.hold_s = hold_s
        self._known: dict[_Key, _Warning] = {}

    def clear(self) -> None:
        self._known.clear()

    def confirmed(self, t: float, findings: list[Finding]) -> list[Finding]:
        """The findings with the warnings that stand; others become ``ok``."""
        out = []
        for finding in findings:
            key = (finding.constraint, finding.object)
            known = self._known.get(key)
            if finding.verdict in ("warn", "violation"):
                if known is None:
                    known = self._known[key] = _Warning(t, t)
                known.last = t
                known.given |= t - known.since >= self.confirm_s or finding.verdict == "violation"
            elif known is not None and (not known.given or t - known.last > self.hold_s):
                known = None
                del self._known[key]
            stands = known is not None and known.given
            if finding.verdict in ("ok", "warn"):
                finding = replace(finding, verdict="warn" if stands else "ok")
            out.append(finding)
        present = {(f.constraint, f.object) for f in findings}
        for key in [k for k in self._known if k not in present]:
            del self._known[key]
        return out
