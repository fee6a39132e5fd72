"""Writes constraints/dev.txt: the versions installed here of all that demospec[all,dev] needs.

    python constraints/make.py

Names and versions only, no addresses. PyTorch and what its builds bring are left out: the
build is the user's choice (variable TORCH of the Makefile).
"""

from __future__ import annotations

import platform
import tomllib
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PYPROJECT = Path(__file__).parents[1] / "pyproject.toml"
CHOSEN_ELSEWHERE = ("torch", "triton", "nvidia-", "cuda-", "demospec")


def needed(name: str, extras: frozenset[str], seen: dict[tuple[str, frozenset[str]], None]) -> None:
    """Walks the requirements of an installed distribution; absent ones are not for this system."""
    key = (canonicalize_name(name), extras)
    if key in seen:
        return
    try:
        requirements = metadata.requires(name) or []
    except metadata.PackageNotFoundError:
        return
    seen[key] = None
    for line in requirements:
        requirement = Requirement(line)
        if requirement.marker is None or any(
            requirement.marker.evaluate({"extra": extra}) for extra in extras | {""}
        ):
            needed(requirement.name, frozenset(requirement.extras), seen)


def main() -> None:
    seen: dict[tuple[str, frozenset[str]], None] = {}
    project = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    for line in [*project["dependencies"], *(x for lines in extras.values() for x in lines)]:
        requirement = Requirement(line)
        needed(requirement.name, frozenset(requirement.extras), seen)
    names = sorted({name for name, _ in seen if not name.startswith(CHOSEN_ELSEWHERE)})
    version = ".".join(platform.python_version_tuple()[:2])
    lines = [
        f"# Versions the tests were last run with: Python {version}, {platform.system()}.",
        "# Made by `make constraints`.",
        *(f"{name}=={metadata.version(name).split('+')[0]}" for name in names),
    ]
    file = Path(__file__).with_name("dev.txt")
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
