"""Gathers the fragments of changelog.d/ under one heading of CHANGELOG.md, and removes them.

python changelog.d/gather.py 0.2.0 [--date 2026-12-01] [--keep]
"""

from __future__ import annotations

import argparse
import datetime
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).parent


def gathered(fragments: list[Path], version: str, date: str, before: str) -> str:
    """The changelog with the fragments under a heading of their own, above the older ones.

    Raises:
        ValueError: A fragment that is no list, no older heading, or a heading of that version.
    """
    texts = [file.read_text(encoding="utf-8").strip() for file in fragments]
    for file, text in zip(fragments, texts, strict=True):
        if not text.startswith("- "):
            raise ValueError(f"{file.name}: expected a list that begins with '- '")
    if f"\n## {version} " in before:
        raise ValueError(f"CHANGELOG.md has {version} already")
    head, heading, rest = before.partition("\n## ")
    if not heading:
        raise ValueError("CHANGELOG.md has no heading of a version")
    return f"{head}\n## {version} ({date})\n\n" + "\n".join(texts) + "\n\n## " + rest


def main(arguments: list[str] | None = None, root: Path = HERE.parent) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("version")
    parser.add_argument("--date", default=datetime.date.today().isoformat())
    parser.add_argument("--keep", action="store_true", help="leave the fragments where they are")
    asked = parser.parse_args(arguments)
    declared = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    if declared["project"]["version"] != asked.version:
        print(f"pyproject.toml says version {declared['project']['version']}", file=sys.stderr)
        return 2
    fragments = sorted((root / "changelog.d").glob("*.md"))
    changelog = root / "CHANGELOG.md"
    try:
        text = gathered(fragments, asked.version, asked.date, changelog.read_text(encoding="utf-8"))
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    changelog.write_text(text, encoding="utf-8")
    if not asked.keep:
        for file in fragments:
            file.unlink()
    print(f"{len(fragments)} fragments under {asked.version}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
