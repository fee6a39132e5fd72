"""Table of interventions: the model's answers before and after each."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from demospec.causal._results import Intervention
from demospec.files import writing_file
from demospec.frames import FloatArray

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True)
class Trial:
    """One intervention on one scene.

    Args:
        scene: Position in `TrialTable.scene_ids`.
        intervention: ``add``, ``remove``, ``move``, ``swap``, ``placebo`` or ``unrelated``.
        symbol: What was added, removed, moved or replaced; "" for the placebos.
        placement: Number of the place (``add``, ``move``, ``placebo``) or object.
        center: Where, pixels.
        after: (types, draws) probability of validity afterwards.
        by_rule: (types, rules) share of the paths that each rule of the posterior accepts
            afterwards; None where the model has no posterior.
        onto: The symbol put instead (swaps).
        source: Which item was put there, in words.
        near: (draws,) distance from each path to the footprint of what was added, set units; None
            where nothing was added, or its outline is not known.
        dose_by_rule: (types, rules, bins) sum over the paths of each bin of `near` of what each
            rule changes; see `demospec.causal._dose`.
    """

    scene: int
    intervention: Intervention
    symbol: str
    placement: int
    center: tuple[float, float]
    after: FloatArray
    onto: str | None = None
    source: str = ""
    by_rule: FloatArray | None = None
    near: FloatArray | None = None
    dose_by_rule: FloatArray | None = None


@dataclass(frozen=True)
class TrialTable:
    """All interventions on all scenes, with the paths that were judged before and after.

    Args:
        scene_ids: One per scene.
        types: User types, in the order of the arrays' first axis.
        symbols: Symbols that were to be added.
        controls: Per scene (draws, 2): z_θ, pixels.
        before: Per scene (types, draws).
        before_by_rule: Per scene (types, rules) as `Trial.by_rule`; empty without a posterior.
        width: Of the region that distances are binned by, set units.
        trials: In the order of scenes.
        notes: Smaller n, stated.
        skipped: Symbol → why nothing of it could be added.
    """

    scene_ids: tuple[str, ...]
    types: tuple[str, ...]
    symbols: tuple[str, ...]
    controls: tuple[FloatArray, ...]
    before: tuple[FloatArray, ...]
    trials: tuple[Trial, ...]
    notes: tuple[str, ...]
    skipped: dict[str, str]
    before_by_rule: tuple[FloatArray, ...] = ()
    width: float = 1.0

    def rule_differences(
        self, intervention: Intervention, symbol: str, onto: str | None = None
    ) -> FloatArray | None:
        """(types, rules) mean effect over scenes under each rule of the posterior; None without."""
        if not self.before_by_rule:
            return None
        sums: dict[int, list[FloatArray]] = {}
        for trial in self.trials:
            same = trial.intervention == intervention and trial.symbol == symbol
            if same and trial.onto == onto and trial.by_rule is not None:
                change = trial.by_rule - self.before_by_rule[trial.scene]
                sums.setdefault(trial.scene, []).append(change)
        if not sums:
            return None
        return np.asarray(np.mean([np.mean(p, axis=0) for p in sums.values()], axis=0))

    def scene_differences(
        self, intervention: Intervention, symbol: str, onto: str | None = None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Per scene and type: mean of after − before over placements and draws.

        Returns:
            (effect, changed, before), each (types, n), over the n scenes in which the
            intervention was possible; `changed` is the mean |after − before|, `before` the
            mean before.
        """
        sums: dict[int, list[FloatArray]] = {}
        for trial in self.trials:
            same = trial.intervention == intervention and trial.symbol == symbol
            if same and trial.onto == onto:
                sums.setdefault(trial.scene, []).append(trial.after - self.before[trial.scene])
        if not sums:
            none = np.empty((len(self.types), 0))
            return none, none, none
        effect = [np.mean([d.mean(axis=1) for d in parts], axis=0) for parts in sums.values()]
        changed = [
            np.mean([np.abs(d).mean(axis=1) for d in parts], axis=0) for parts in sums.values()
        ]
        before = [self.before[scene].mean(axis=1) for scene in sums]
        return np.stack(effect, axis=1), np.stack(changed, axis=1), np.stack(before, axis=1)


def to_arrow(table: TrialTable) -> pa.Table:
    """One row per trial × type × path: for DoWhy, R, or a spreadsheet.

    Columns: scene, intervention, symbol, onto, placement, place_x, place_y, source, draw,
    z_theta_x, z_theta_y, type, before, after, distance (from the path to what was added; null
    elsewhere). Pixels and probabilities.
    """
    import pyarrow as pa

    n_types = len(table.types)
    sizes = [trial.after.size for trial in table.trials]

    def per_trial(values: list[object], kind: pa.DataType) -> pa.Array:
        # Dictionary columns: a word is stored once, not once per path.
        return pa.array(values, kind).take(pa.array(np.repeat(np.arange(len(sizes)), sizes)))

    def stacked(parts: list[FloatArray]) -> pa.Array:
        return pa.array(np.concatenate(parts) if parts else np.empty(0), pa.float64(),
                        from_pandas=True)  # fmt: skip

    trials = table.trials
    word = pa.string()
    draws = [table.controls[t.scene] for t in trials]
    types = [np.repeat(np.arange(n_types), len(z)) for z in draws]
    return pa.table(
        {
            "scene": per_trial([table.scene_ids[t.scene] for t in trials], word),
            "intervention": per_trial([t.intervention for t in trials], word),
            "symbol": per_trial([t.symbol for t in trials], word),
            "onto": per_trial([t.onto for t in trials], word),
            "placement": per_trial([t.placement for t in trials], pa.int32()),
            "place_x": per_trial([t.center[0] for t in trials], pa.float64()),
            "place_y": per_trial([t.center[1] for t in trials], pa.float64()),
            "source": per_trial([t.source for t in trials], word),
            "draw": stacked([np.tile(np.arange(len(z)), n_types) for z in draws]).cast(pa.int32()),
            "z_theta_x": stacked([np.tile(z[:, 0], n_types) for z in draws]),
            "z_theta_y": stacked([np.tile(z[:, 1], n_types) for z in draws]),
            "type": pa.array(list(table.types), word).take(
                pa.array(np.concatenate(types) if types else np.empty(0, np.int64))
            ),
            "before": stacked([table.before[t.scene].ravel() for t in trials]),
            "after": stacked([t.after.ravel() for t in trials]),
            "distance": stacked([np.tile(_near(t), n_types) for t in trials]),
        }
    )


def _near(trial: Trial) -> FloatArray:
    return np.full(trial.after.shape[1], np.nan) if trial.near is None else trial.near


def write_trials(table: TrialTable, path: str | os.PathLike[str]) -> None:
    """Writes the table of interventions as Parquet, through a temporary name."""
    import pyarrow.parquet as pq

    with writing_file(path) as temporary:
        pq.write_table(to_arrow(table), temporary, compression="zstd")
