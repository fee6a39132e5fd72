"""Draws docs/images/house.svg: the rooms, and who imports from whom, read from the code.

python docs/house.py
"""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "demospec"
WORDS = {
    "cli": "arguments in, exit codes out",
    "studio": "teach and explore in the browser",
    "pipeline": "the flow, top to bottom",
    "report": "results to one page",
    "experiments": "the paper's protocols, sweeps",
    "execution": "a simulated robot follows",
    "monitor": "live verdicts on a robot",
    "planning": "cost maps, paths, exports",
    "causal": "interventions, effects",
    "specification": "models of what is accepted",
    "perception": "the distance network, objects",
    "rules": "exact rules, envelopes, queries",
    "demonstrations": "sets, readers, simulators",
    "scene": "objects, pictures, editing",
    "parallel": "processes and clusters",
    "files": "atomic writes",
    "frames": "pixels and metres",
    "progress": "reports of progress",
    "errors": "the exception family",
}


def storeys() -> list[list[str]]:
    """Top to bottom, as the import contract of pyproject.toml has them."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    contracts = tomllib.loads(text)["tool"]["importlinter"]["contracts"]
    contract = next(c for c in contracts if c["type"] == "layers")
    return [[n.strip().removeprefix("demospec.") for n in row.split("|")]
            for row in contract["layers"]]  # fmt: skip


def imports(room: str) -> dict[str, int]:
    """Room → how many modules of `room` import from it."""
    place = SOURCE / room
    files = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    counts: dict[str, int] = {}
    for file in files:
        names = set()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            module = node.module if isinstance(node, ast.ImportFrom) else None
            if module and module.startswith("demospec."):
                names.add(module.split(".")[1])
        for name in names - {room}:
            counts[name] = counts.get(name, 0) + 1
    return counts


def lines_of(room: str) -> int:
    place = SOURCE / room
    files = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    return sum(len(f.read_text(encoding="utf-8").splitlines()) for f in files)


def draw() -> str:
    """One row a room, from the roof down; a dot where the row's room imports the column's."""
    rooms = [name for storey in storeys() for name in storey]
    left, top, step = 364, 120, 26
    width, height = left + step * len(rooms) + 20, top + step * len(rooms) + 40
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        'font-family="sans-serif" font-size="13">',
        "<title>The rooms of demospec; a dot: the room on the left imports from the one above"
        "</title>",
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
    ]
    for i, room in enumerate(rooms):
        y, x = top + step * i, left + step * i
        if i % 2 == 0:
            out.append(
                f'<rect x="10" y="{y}" width="{width - 20}" height="{step}" fill="#f2f5f7"/>'
            )
        out.append(f'<text x="16" y="{y + 18}" font-weight="bold">{room}</text>')
        out.append(f'<text x="142" y="{y + 18}" fill="#444444">{WORDS.get(room, "")}</text>')
        out.append(
            f'<text transform="translate({x + 17},{top - 8}) rotate(-60)" fill="#222222">'
            f"{room}</text>"
        )
        out.append(f'<rect x="{x + 3}" y="{y + 3}" width="20" height="20" fill="#cccccc"/>')
    for i, room in enumerate(rooms):
        for name, count in imports(room).items():
            if name not in rooms:
                continue
            j = rooms.index(name)
            radius = min(3 + count**0.5, 11)
            # Okabe-Ito: blue goes down, as it should; vermilion would go up.
            colour = "#0072b2" if j > i else "#d55e00"
            out.append(
                f'<circle cx="{left + step * j + 13}" cy="{top + step * i + 13}" '
                f'r="{radius:.1f}" fill="{colour}"><title>{count} modules of {room} import '
                f"{name}</title></circle>"
            )
    total = sum(lines_of(room) for room in rooms)
    out.append(
        f'<text x="16" y="{height - 14}" fill="#444444">A dot: a room (row) imports from another '
        f"(column); area grows with the number of modules. {total:,} lines.</text></svg>"
    )
    return "\n".join(out) + "\n"


if __name__ == "__main__":
    (ROOT / "docs" / "images" / "house.svg").write_text(draw(), encoding="utf-8")
