"""A run folder as HTML: what it found, with the numbers of its own documents."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from typing import Any

from demospec.errors import InputError
from demospec.files import read_json
from demospec.studio.results._chart import accuracy_chart

Document = dict[str, Any]

WHOSE = {
    "truth": "the rule that made the labels (for comparison)",
    "paper": "the paper's model",
    "field": "the field model",
}
WHICH = {"seen": "seen scenes, held-out paths", "unseen": "unseen scenes and items"}
VIDEOS = (".gif", ".mp4")


def read_document(run: Path | None, name: str) -> Document | None:
    """``NAME.json`` of a run, or None where there is none; InputError where it is damaged."""
    file = None if run is None else run / f"{name}.json"
    if file is None or not file.is_file():
        return None
    content = read_json(file)
    if not isinstance(content, dict):
        raise InputError("a JSON object", type(content).__name__, file=file)
    return content


def videos_of(run: Path | None) -> list[Path]:
    """Videos of executions, anywhere in the run folder; in the order of their names."""
    if run is None:
        return []
    return sorted(p for p in run.rglob("*") if p.suffix.lower() in VIDEOS and p.is_file())


def section(
    run: Path | None,
    name: str,
    title: str,
    draw: Callable[[Document], str],
    command: str,
) -> str:
    """One card of the page: drawn from ``NAME.json``, or what is missing and how to make it."""
    try:
        document = read_document(run, name)
        body = absent(title, command) if document is None else draw(document)
    except (InputError, KeyError, TypeError, AttributeError, ValueError) as error:
        words = str(error) if isinstance(error, InputError) else f"{type(error).__name__} {error}"
        body = f'<p class="re-wrong">{escape(name)}.json cannot be shown: {escape(words)}</p>'
    return f'<section class="card" id="{escape(name)}"><h2>{escape(title)}</h2>{body}</section>'


def absent(title: str, command: str) -> str:
    """A plain message in the place of what is absent."""
    return f'<p class="soft">This run has none. <code>{escape(command)}</code> makes it.</p>'


def table(
    header: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    caption: str = "",
    bold: frozenset[tuple[int, int]] = frozenset(),
    numbers: int = 1,
) -> str:
    """An HTML table; cells are HTML already. From column `numbers` on, numbers to the right."""
    head = "".join(f'<th scope="col">{h}</th>' for h in header)
    lines = []
    for i, row in enumerate(rows):
        cells = [f'<th scope="row">{row[0]}</th>']
        for j, cell in enumerate(row[1:], 1):
            words = f"<strong>{cell}</strong>" if (i, j) in bold else cell
            cells.append(f"<td{' class=num' if j >= numbers else ''}>{words}</td>")
        lines.append(f"<tr>{''.join(cells)}</tr>")
    # Above what scrolls sideways, so that a narrow page does not cut it off.
    said = f'<p class="re-caption">{caption}</p>' if caption else ""
    name = f' aria-label="{caption}"' if caption else ""
    return (
        f'{said}<div class="re-wide" tabindex="0" role="group" '
        'aria-label="Table, scrolls sideways">'
        f"<table{name}><thead><tr>{head}</tr></thead><tbody>{''.join(lines)}</tbody></table></div>"
    )


def rules(document: Document) -> str:
    """One sentence for each type."""
    lines = [
        f"<li><span class='re-type'>{escape(str(name))}</span> {escape(str(rule['sentence']))}</li>"
        for name, rule in document["types"].items()
    ]
    return f'<ul class="re-rules">{"".join(lines)}</ul>'


def causes(document: Document) -> str:
    """The paper's table for each model: bold where an effect is causal."""
    if "effects" in document:  # the document of `demospec causes` alone
        document = {"": document}
    parts = []
    for name, found in document.items():
        types = list(found["base"])
        symbols = list(dict.fromkeys(e["symbol"] for e in found["effects"]))
        cells = {(e["type"], e["symbol"]): e for e in found["effects"]}
        placebo = {p["type"]: p for p in found["placebo"]}
        rows, bold = [], set()
        for i, kind in enumerate(types):
            row = [escape(kind), number(found["base"][kind]["mean"])]
            for j, symbol in enumerate(symbols):
                cell = cells.get((kind, symbol))
                row.append("–" if cell is None else effect(cell))
                if cell is not None and cell["causal"]:
                    bold.add((i, j + 2))
            row.append(effect(placebo[kind]) if kind in placebo else "–")
            rows.append(row)
        header = ["type", "P(valid)", *(f"+ {escape(s)}" for s in symbols), "placebo"]
        said = f"According to {escape(WHOSE.get(name, name or 'the model'))}"
        parts.append(
            table(header, rows, bold=frozenset(bold), caption=f"{said}, {found['n_scenes']} scenes")
        )
        parts.append(f'<p class="soft">{escape(" ".join(found["sentences"]))}</p>')
    note = (
        "Change of the probability that a random path is accepted when one more such object is "
        "put on the table, with its 95 % interval; <strong>bold</strong> where causal. The "
        "placebo, a moved patch of bare table, has to change nothing."
    )
    return f'<p class="soft">{note}</p>' + "".join(parts)


def effect(cell: Document) -> str:
    """``−0.21 [−0.26, −0.16]``."""
    low, high = cell["interval"]
    between = f'<span class="re-between">[{number(low)}, {number(high)}]</span>'
    return f"{number(cell['effect'], sign=True)} {between}"


def number(value: Any, *, sign: bool = False) -> str:
    """Two decimals with a true minus; a dash where there is no number."""
    if value is None:
        return "–"
    shown = f"{float(value):+.2f}" if sign else f"{float(value):.2f}"
    if float(shown) == 0:
        shown = "0.00"
    return shown.replace("-", "−")


def percent(value: Any) -> str:
    """``72 %``, or a dash."""
    return "–" if value is None else f"{100 * float(value):.0f}\u00a0%"


def accuracy(document: Document) -> str:
    """Balanced accuracy with its interval, as a picture and as a table."""
    rows = []
    for model, sets in document.items():
        for which, types in sets.items():
            for kind, s in types.items():
                balanced = s.get("balanced_accuracy")
                low, high = s["interval"]
                said = "undefined: one class" if balanced is None else percent(balanced)
                rows.append(
                    [
                        escape(model), WHICH.get(which, escape(which)), escape(kind), str(s["n"]),
                        percent(s["accuracy"]), said, f"{percent(low)} to {percent(high)}",
                        percent(s["majority"]),
                    ]
                )  # fmt: skip
    header = [
        "model", "judged on", "type", "n", "accuracy", "balanced", "95 % interval",
        "majority class",
    ]  # fmt: skip
    full = f"<details><summary>All numbers</summary>{table(header, rows, numbers=3)}</details>"
    return accuracy_chart(document) + full


def curve_table(document: Document) -> str:
    """The numbers behind `curves`."""
    rows = [
        [
            escape(str(r["model"])), escape(str(r["type"])), str(r["n"]), str(r["fits"]),
            percent(r["bacc_seen"]), percent(r["bacc_unseen"]), percent(r["majority_seen"]),
        ]
        for r in document["rows"]
    ]  # fmt: skip
    header = ["model", "type", "demonstrations a scene", "fits", "balanced, seen scenes",
              "balanced, unseen scenes", "majority class"]  # fmt: skip
    return f"<details><summary>All numbers</summary>{table(header, rows, numbers=2)}</details>"


def repairs(document: Document) -> str:
    """How often a repaired path is accepted by the rule that made the labels."""
    rows = []
    for model, sets in document.items():
        for which, types in sets.items():
            for kind, s in types.items():
                if s.get("vacuous"):
                    continue
                rows.append(
                    [
                        escape(model), WHICH.get(which, escape(which)), escape(kind), str(s["n"]),
                        percent(s["repaired_by_truth"]), percent(s["accepted_by_model"]),
                        "–" if s["moved_px"] is None else f"{s['moved_px']:.0f} px",
                    ]
                )  # fmt: skip
    header = [
        "model", "repaired in", "type", "n", "true rule accepts", "model's own opinion",
        "control point moved",
    ]  # fmt: skip
    return table(header, rows, numbers=3)


def audit(document: Document) -> str:
    """Demonstrations that contradict what the others follow."""
    listed = document["demonstrations"]
    doubtful = [d for d in listed if d["verdict"] == "review"]
    if not doubtful:
        return f"<p>None of {len(listed)} demonstrations contradicts what the others follow.</p>"
    rows = [[escape(str(d["demo_id"])), escape(str(d["why"]))] for d in doubtful[:30]]
    more = f'<p class="soft">and {len(doubtful) - 30} more</p>' if len(doubtful) > 30 else ""
    said = f"<p>{len(doubtful)} of {len(listed)} demonstrations should be looked at again.</p>"
    return said + table(["demonstration", "why"], rows, numbers=9) + more
