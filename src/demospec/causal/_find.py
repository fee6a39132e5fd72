"""The causal analysis: intervene on scenes, ask the model before and after, estimate.

Source: Angelov et al. 2020, "Causal analysis": the structural causal model {Z_θ, Z_I, S, V},
do(S := s) and do(Z_I := E(I ∪ o)). Differs: effects are paired over scenes and z_θ, carry
intervals and corrected p-values, and stand beside a placebo; removals, moves and swaps too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from demospec.causal._checks import checked
from demospec.causal._estimate import estimate
from demospec.causal._paths import region_of
from demospec.causal._results import CausalFindings, Settings
from demospec.causal._scene_trials import SceneTrials
from demospec.causal._trials import TrialTable
from demospec.demonstrations import ValidityModel
from demospec.errors import CannotJudgeError, InputError
from demospec.frames import FloatArray
from demospec.geometry import Polygon
from demospec.progress import Progress, silent
from demospec.scene import Editor, Scene, SceneObject, Source


def find_causes(
    model: ValidityModel,
    scenes: Sequence[Scene],
    symbols: Sequence[str] | None = None,
    types: Sequence[str] | None = None,
    *,
    settings: Settings | None = None,
    editor: Editor | None = None,
    paths: Mapping[str, Sequence[FloatArray]] | None = None,
    progress: Progress = silent,
) -> CausalFindings:
    """Which symbols matter to which type, by how much, how surely.

    Args:
        model: Anything that judges paths: a network, learned rules, the truth.
        scenes: The unit of all statistics; at least one, better twenty.
        symbols: To be added; those that occur in the scenes by default.
        types: All that the model knows by default.
        settings: How much is tried and what counts as a claim.
        editor: How scenes are changed; by default what `editor_for` says.
        paths: Scene id → paths to judge instead of random Bézier curves (free polylines,
            say a set's own demonstrations).
        progress: Told about scenes done.

    Raises:
        InputError: No scenes; a type the model does not know; a symbol for which there is
            nothing to add although it was asked for.
        CannotJudgeError: The model can judge none of the scenes.
    """
    settings = settings or Settings()
    table = run_trials(
        model,
        scenes,
        symbols,
        types,
        settings=settings,
        editor=editor,
        paths=paths,
        progress=progress,
    )
    return checked(estimate(table, settings), model, scenes)


def run_trials(
    model: ValidityModel,
    scenes: Sequence[Scene],
    symbols: Sequence[str] | None = None,
    types: Sequence[str] | None = None,
    *,
    settings: Settings | None = None,
    editor: Editor | None = None,
    paths: Mapping[str, Sequence[FloatArray]] | None = None,
    skip_absent: bool = False,
    progress: Progress = silent,
) -> TrialTable:
    """The interventions themselves; `find_causes` estimates from their table.

    Args:
        skip_absent: Symbols for which there is nothing to add are left out and named in the
            table's `skipped`, instead of refused.
    """
    run, skipped = prepared(
        model, scenes, symbols, types, settings=settings, editor=editor, paths=paths,
        skip_absent=skip_absent,
    )  # fmt: skip
    run.scenes(scenes, progress)
    return run.table(skipped)


def prepared(
    model: ValidityModel,
    scenes: Sequence[Scene],
    symbols: Sequence[str] | None = None,
    types: Sequence[str] | None = None,
    *,
    settings: Settings | None = None,
    editor: Editor | None = None,
    paths: Mapping[str, Sequence[FloatArray]] | None = None,
    skip_absent: bool = False,
) -> tuple[SceneTrials, dict[str, str]]:
    """What runs interventions on any of these scenes; symbols that are left out, and why."""
    chosen_types = _types(model, types)
    if not scenes:
        raise InputError("at least one scene", "none", field="scenes")
    editor = editor if editor is not None else editor_for(scenes)
    wanted, skipped = _symbols(scenes, symbols, editor, skip_absent)
    run = SceneTrials(
        model, editor, chosen_types, wanted, settings or Settings(), region_of(scenes), paths
    )
    return run, skipped


def editor_for(
    scenes: Sequence[Scene],
    *,
    source: Source = "auto",
    catalogue: str | None = None,
    metres_per_unit: float | None = None,
) -> Editor:
    """The editor of these scenes; where one lists no objects, they are detected in its picture.

    Args:
        source, catalogue, metres_per_unit: See `Editor`.
    """
    return Editor(
        scenes, source=source, catalogue=catalogue, metres_per_unit=metres_per_unit,
        detect=_detected,
    )  # fmt: skip


def _detected(scene: Scene) -> tuple[SceneObject, ...]:
    from demospec.perception import observe

    return tuple(
        SceneObject(f"seen-{i}", d.kind, d.center, d.bbox, Polygon(d.polygon))
        for i, d in enumerate(observe(scene.pixels()).detections)
        if len(d.polygon) >= 3
    )


def _types(model: ValidityModel, types: Sequence[str] | None) -> tuple[str, ...]:
    if types is None:
        return tuple(model.types)
    for name in types:
        if name not in model.types:
            raise InputError(f"one of the model's types ({', '.join(model.types)})", name,
                             field="type")  # fmt: skip
    if not types:
        raise InputError("at least one type", "none", field="type")
    return tuple(dict.fromkeys(types))


def _symbols(
    scenes: Sequence[Scene], symbols: Sequence[str] | None, editor: Editor, skip_absent: bool
) -> tuple[tuple[str, ...], dict[str, str]]:
    """The symbols that can be added, and why others cannot."""
    if all(s.objects is None and s.picture is None for s in scenes):
        expected = "object lists or pictures to intervene on"
        raise CannotJudgeError(expected, "objects not listed", field="objects")
    present = tuple(dict.fromkeys(o.symbol for s in scenes for o in s.objects or ()))
    wanted = present if symbols is None else tuple(dict.fromkeys(symbols))
    if not wanted:
        expected = "symbols to add (the scenes list no objects: name them)"
        raise InputError(expected, "none", field="symbols")
    skipped = {
        s: "it occurs in no scene, and no catalogue has it"
        for s in wanted
        if not editor.templates(s)
    }
    if skipped and (not skip_absent or len(skipped) == len(wanted)):
        known = ", ".join(present) or "none"
        expected = f"a symbol that a scene or the catalogue has (the scenes: {known})"
        raise InputError(expected, next(iter(skipped)), field="symbols")
    return tuple(s for s in wanted if s not in skipped), skipped
