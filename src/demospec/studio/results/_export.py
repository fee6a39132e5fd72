"""What the Results page hands out: the set, the rules, planners' files, the report."""

from __future__ import annotations

import importlib.util
import json
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from demospec.demonstrations import write_set
from demospec.errors import DemospecError, InputError
from demospec.rules import RuleSet, rules_document
from demospec.studio.session._scales import OtherScale
from demospec.studio.session._workspace import Workbench

if TYPE_CHECKING:
    from demospec.report import Report

FORMS = {
    "set": "the set",
    "rules": "the rules",
    "report": "the report",
    "nav2": "nav2",
    "moveit": "MoveIt",
    "mcap": "MCAP",
}
"""What can be downloaded → its name on the button."""

PLANNED = ("nav2", "moveit", "mcap")
"""Those that need a scene and a type, because a path is planned."""

TAUGHT, GIVEN_RUN = "taught", "run"
"""What a report is about: what was taught here, or the run that the studio was started with."""


class CannotPlan(DemospecError):
    """Why no plan is made: a sentence for the person at the page."""


@dataclass(frozen=True)
class Choices:
    """What can be asked for, and why something cannot.

    Args:
        rules: Name of a rule set → types that it knows.
        scenes: Scenes that can be planned in.
        missing: Form → why it cannot be had now; the others can.
        missing_in: Scene → why nothing can be planned there.
        missing_for: Name of a rule set → type → why nothing can be planned for it.
    """

    rules: Mapping[str, tuple[str, ...]]
    scenes: tuple[str, ...]
    missing: Mapping[str, str]
    missing_in: Mapping[str, str]
    missing_for: Mapping[str, Mapping[str, str]]


LEARNING = "Learning from the labels…"


def choices(workbench: Workbench, *, learned: bool = True) -> Choices:
    """What stands on the table now.

    Args:
        learned: False: not what rules must be learned for; that is said to be missing.
    """
    known = workbench.rule_sets() if learned else {}
    missing: dict[str, str] = {}
    if not workbench.demonstrations:
        missing["set"] = "Draw a path first."
        if workbench.run_folder is None:
            missing["report"] = "Draw a path first: the report is about what was taught."
    if not known:
        words = "Accept or reject a path first: the rules are learned from that."
        words = words if learned else LEARNING
        missing |= dict.fromkeys(("rules", *PLANNED), words)
    elif importlib.util.find_spec("mcap") is None or importlib.util.find_spec("rosbags") is None:
        missing["mcap"] = "MCAP needs more: pip install 'demospec[ros]'."
    return Choices(
        {name: tuple(rules.types) for name, rules in known.items()},
        tuple(s.scene_id for s in workbench.scenes),
        missing,
        {s.scene_id: why for s in workbench.scenes if (why := _cannot_plan(workbench, s.scene_id))},
        {
            name: {t: why for t in rules.types if (why := _unexplained(rules, t))}
            for name, rules in known.items()
        },
    )


def _unexplained(rules: RuleSet, type: str) -> str:
    """Why a rule is not planned with: its answers do not tell it from chance."""
    fit = rules.of_type(type).fit
    if fit is None or fit.verdict != "not":
        return ""
    if fit.contradicted:
        return "Distances do not explain these answers: a robot must not go by this rule."
    return (
        f"{fit.n} {'answer is' if fit.n == 1 else 'answers are'} too few to tell this rule from "
        "chance: show a few more paths, about as many to accept as to reject."
    )


def _cannot_plan(workbench: Workbench, scene_id: str) -> str:
    scene = workbench.scene(scene_id)
    if scene.objects is None:
        return "Nobody has said yet what stands here: mark the objects under Teach."
    if workbench.scale_of(scene_id) is None:
        return "How wide is this picture on the table? Robots need metres: measure it under Teach."
    return ""


def export(
    workbench: Workbench,
    form: str,
    *,
    rules: str = "",
    scene: str = "",
    type: str = "",
    of: str = "",
) -> tuple[str, str, bytes]:
    """One download: (file name, media type, content).

    Args:
        workbench: What stands on the table.
        form: One of `FORMS`.
        rules: Name of a rule set; the first by default.
        scene, type: For the forms in `PLANNED`.
        of: `TAUGHT` or `GIVEN_RUN`, for the report.

    Raises:
        InputError: Unknown form, rules, scene or type; nothing to export; no plan; no scale.
        MissingExtraError: MCAP without the extra ``ros``.
    """
    if form == "set":
        return "set.zip", "application/zip", _set(workbench)
    if form == "report":
        return "report.html", "text/html", _report(workbench, of)
    if form not in FORMS:
        raise InputError(f"one of {', '.join(FORMS)}", form, field="form")
    known = workbench.rule_sets()
    if not known:
        raise InputError("labelled demonstrations, or --model RULES", "none", field="rules")
    name = rules or next(iter(known))
    if name not in known:
        raise InputError(f"one of {', '.join(known)}", name, field="rules")
    if form in PLANNED:
        return _planned(workbench, form, name, scene, type)
    text = json.dumps(rules_document(known[name]), indent=1)
    return "rules.json", "application/json", text.encode()


def _planned(
    workbench: Workbench, form: str, name: str, scene: str, type: str
) -> tuple[str, str, bytes]:
    from demospec.planning import export_request, export_to

    why = _cannot_plan(workbench, scene)
    if why:
        raise OtherScale(why)
    rules = workbench.model_at(name, scene)
    if not isinstance(rules, RuleSet):
        raise InputError("rules to plan with", name, field="rules")
    why = _unexplained(rules, type) if type in rules.types else ""
    if why:
        raise CannotPlan(why)
    frame = None if workbench.original is None else workbench.original.axes
    request = export_request(rules, workbench.scene(scene), type or None, axes=frame)
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


def _report(workbench: Workbench, of: str) -> bytes:
    from demospec.report import render_html

    return render_html(report_of(workbench, of)).encode()


def subjects(workbench: Workbench) -> dict[str, str]:
    """What a report can be about → its name; the first is shown unless told otherwise."""
    found = {}
    if workbench.run_folder is not None:
        found[GIVEN_RUN] = f"the run {workbench.run_folder.name}"
    if workbench.demonstrations:
        found[TAUGHT] = "what was taught here"
    return found


def report_of(workbench: Workbench, of: str = "") -> Report:
    """The report of the run, or of what was taught here.

    Raises:
        InputError: There is none, or a document of the run is damaged.
    """
    from demospec.report import build_report
    from demospec.studio.results._run import taught_run

    known = subjects(workbench)
    of = of or next(iter(known), TAUGHT)
    if of == GIVEN_RUN and workbench.run_folder is not None:
        return build_report(workbench.run_folder)
    run = taught_run(workbench) if of == TAUGHT else None
    if run is None:
        raise InputError("a path that was drawn here, or a run (--run RUN)", "none", field="report")
    return build_report(run)


def zipped(folder: Path) -> bytes:
    """A folder and all in it as a ZIP archive; the folder's own name comes first."""
    buffer = BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.rglob("*")):
            if file.is_file():
                archive.write(file, Path(folder.name) / file.relative_to(folder))
    return buffer.getvalue()
