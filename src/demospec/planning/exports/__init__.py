"""Files that planners read. None of them needs ROS to be written or read."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from demospec.errors import InputError
from demospec.files import writing_file, writing_folder
from demospec.planning.exports._bags import write_mcap, write_rosbag2
from demospec.planning.exports._callables import write_numpy, write_ompl
from demospec.planning.exports._messages import type_store
from demospec.planning.exports._moveit import grown_hulls, write_moveit
from demospec.planning.exports._nav2 import write_nav2
from demospec.planning.exports._readme import write_readme
from demospec.planning.exports._request import ExportRequest, export_request
from demospec.planning.exports._stl import stl_formula, stl_signals, write_stl
from demospec.planning.exports._tesseract import write_tesseract
from demospec.planning.exports._vda5050 import write_vda5050
from demospec.planning.exports._waypoints import write_waypoints_csv, write_waypoints_json

__all__ = [
    "FILES",
    "FOLDERS",
    "ExportRequest",
    "export_request",
    "export_to",
    "grown_hulls",
    "stl_formula",
    "stl_signals",
    "type_store",
]

FOLDERS: dict[str, Callable[[ExportRequest, Path], None]] = {
    "nav2": write_nav2,
    "moveit": write_moveit,
    "numpy": write_numpy,
    "ompl": write_ompl,
    "rosbag2": write_rosbag2,
    "stl": write_stl,
    "vda5050": write_vda5050,
    "tesseract": write_tesseract,
}
"""Format → writer into a folder."""

FILES: dict[str, Callable[[ExportRequest, Path], None]] = {
    "mcap": write_mcap,
    "json": write_waypoints_json,
    "csv": write_waypoints_csv,
}
"""Format → writer of one file."""


def export_to(
    request: ExportRequest, form: str, out: str | os.PathLike[str], *, replace: bool = False
) -> None:
    """Writes one export; nothing that exists is replaced unless told so.

    A folder also gets ``README.txt``: the lines that make a robot use it.

    Args:
        request: From `export_request`.
        form: One of `FOLDERS` or `FILES`.
        out: Folder or file to make.
        replace: Replace what is there.

    Raises:
        InputError: Unknown format, no metres per unit where they are needed, no plan.
        OutputError: `out` exists.
        MissingExtraError: A library of the extra ``ros`` is absent.
    """
    if form in FOLDERS:
        with writing_folder(out, replace=replace) as folder:
            FOLDERS[form](request, folder)
            write_readme(form, folder)
    elif form in FILES:
        with writing_file(out, replace=replace) as file:
            FILES[form](request, file)
    else:
        names = ", ".join([*FOLDERS, *FILES])
        raise InputError(f"one of {names}", form, field="to")
