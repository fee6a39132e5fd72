"""What the Results page hands out: the set, the rules, planners' files, the report."""

from __future__ import annotations

import json
import tempfile
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

from demospec.demonstrations import write_set
from demospec.errors import InputError
from demospec.rules import RuleSet, rules_document
from demospec.studio.session._workspace import Workbench

FORMS = {
    "set": "Set",
    "rules": "Rules",
    "report": "Report",
    "nav2": "nav2",
    "moveit": "MoveIt",
    "mcap": "MCAP",
}
"""What can be downloaded → its name on the button."""

PLANNED = ("nav2", "moveit", "mcap")
"""Those that need a scene and a type, because a path is planned."""


def export(
    workbench: Workbench, form: str, *, rules: str = "", scene: str = "", type: str = ""
) -> tuple[str, str, bytes]:
    """One download: (file name, media type, content).

    Args:
        workbench: What stands on the table.
        form: One of `FORMS`.
        rules: Name of a rule set; the first by default.
        scene, type: For the forms in `PLANNED`.

    Raises:
        InputError: Unknown form, rules, scene or type; nothing to export; no plan; no scale.
        MissingExtraError: MCAP without the extra ``ros``.
    """
    if form == "set":
        return "set.zip", "application/zip", _set(workbench)
    if form == "report":
        return "report.html", "text/html", _report(workbench)
    if form not in FORMS:
        raise InputError(f"one of {', '.join(FORMS)}", form, field="form")
    known = workbench.rule_sets()
    if not known:
        raise InputError("labelled demonstrations, or --model RULES", "none", field="rules")
    name = rules or next(iter(known))
    if name not in known:
        raise InputError(f"one of {', '.join(known)}", name, field="rules")
    if form == "rules":
        text = json.dumps(rules_document(known[name]), indent=1)
        return "rules.json", "application/json", text.encode()
    return _planned(workbench, form, known[name], scene, type)


def _planned(
    workbench: Workbench, form: str, rules: RuleSet, scene: str, type: str
) -> tuple[str, str, bytes]:
    from dataclasses import replace

    from demospec.planning import export_request, export_to

    scaled = replace(rules, metres_per_unit=workbench.metres_per_unit)
    request = export_request(scaled, workbench.scene(scene), type or None)
    with tempfile.TemporaryDirectory() as place:
        if form == "mcap":
            file = Path(place) / "plan.mcap"
            export_to(request, form, file)
            return "plan.mcap", "application/octet-stream", file.read_bytes()
        folder = Path(place) / form
        export_to(request, form, folder)
        return f"{form}.zip", "application/zip", zipped(folder)


def _set(workbench: Workbench) -> bytes:
    data = workbench.data()
    if data is None:
        raise InputError("at least one demonstration", "none", field="demonstrations")
    with tempfile.TemporaryDirectory() as place:
        return zipped(write_set(data, Path(place) / "set"))


def _report(workbench: Workbench) -> bytes:
    run = workbench.run_folder
    if run is None:
        raise InputError("a run (demospec studio --run RUN)", "none", field="report")
    if (run / "report.html").is_file():
        return (run / "report.html").read_bytes()
    from demospec.report import build_report, render_html

    return render_html(build_report(run)).encode()


def zipped(folder: Path) -> bytes:
    """A folder and all in it as a ZIP archive; the folder's own name comes first."""
    buffer = BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.rglob("*")):
            if file.is_file():
                archive.write(file, Path(folder.name) / file.relative_to(folder))
    return buffer.getvalue()


def choices(workbench: Workbench) -> dict[str, Any]:
    """What the export form offers."""
    known = workbench.rule_sets()
    types = list(dict.fromkeys(t for rules in known.values() for t in rules.types))
    return {
        "rules": list(known),
        "types": types,
        "scenes": [s.scene_id for s in workbench.scenes],
    }
