"""All interventions on some scenes, collected for one table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from demospec.causal._dose import distance_to_added, in_bins
from demospec.causal._paths import (
    distance_from_line,
    draw_controls,
    paths_of,
    region_of_scene,
)
from demospec.causal._results import Intervention, Settings
from demospec.causal._statistics import stable_seed
from demospec.causal._trials import Trial, TrialTable
from demospec.demonstrations import Motions, Paths, ValidityModel, View, fit_bezier
from demospec.errors import CannotJudgeError
from demospec.frames import FloatArray
from demospec.geometry import Bounds
from demospec.progress import Progress, silent
from demospec.rules import RuleView
from demospec.scene import Disc, Editor, Scene, SceneObject, Template, free_places, room_around

CLEAR_ENDS = 0.08
"""Least distance from what is added to start and goal, as a share of the region's width."""
GAP = 0.02
"""Least distance between what is added and every other object, as a share of that width."""

Collected = tuple[
    list[str], list[FloatArray], list[FloatArray], list[FloatArray], list[Trial],
    dict[str, list[tuple[str, int]]], list[str], list[tuple[str, CannotJudgeError]],
]  # fmt: skip
"""Scene ids, controls, before, before by rule, trials, too few places, unlisted, refused scenes."""


class SceneTrials:
    """Collects the trials of one analysis, scene by scene."""

    def __init__(
        self,
        model: ValidityModel,
        editor: Editor,
        types: tuple[str, ...],
        symbols: tuple[str, ...],
        settings: Settings,
        region: Bounds,
        paths: Mapping[str, Sequence[FloatArray]] | None,
    ) -> None:
        self.model, self.editor, self.types, self.symbols = model, editor, types, symbols
        self.settings, self.region, self.paths = settings, region, paths
        self.scene_ids: list[str] = []
        self.controls: list[FloatArray] = []
        self.before: list[FloatArray] = []
        self.before_by_rule: list[FloatArray] = []
        self.trials: list[Trial] = []
        self.short: dict[str, list[tuple[str, int]]] = {}
        self.unlisted: list[str] = []
        self.refused: list[tuple[str, CannotJudgeError]] = []

    def scenes(self, scenes: Sequence[Scene], progress: Progress = silent) -> None:
        """All interventions on some scenes; those that cannot be judged are kept apart."""
        for i, scene in enumerate(scenes):
            progress("interventions", i, len(scenes))
            try:
                self.scene(scene)
            except CannotJudgeError as error:
                self.refused.append((scene.scene_id, error))
        progress("interventions", len(scenes), len(scenes))

    def take(self, part: Collected) -> None:
        """Adds what was collected elsewhere, on the scenes that follow."""
        scene_ids, controls, before, by_rule, trials, short, unlisted, refused = part
        first = len(self.scene_ids)
        self.scene_ids += scene_ids
        self.controls += controls
        self.before += before
        self.before_by_rule += by_rule
        self.trials += [replace(t, scene=first + t.scene) for t in trials]
        for symbol, places in short.items():
            self.short.setdefault(symbol, []).extend(places)
        self.unlisted += unlisted
        self.refused += refused

    def collected(self) -> Collected:
        """What `take` adds to another."""
        return (self.scene_ids, self.controls, self.before, self.before_by_rule, self.trials,
                self.short, self.unlisted, self.refused)  # fmt: skip

    def rng(self, scene: Scene, *words: str) -> np.random.Generator:
        """A stream of its own for each scene and purpose: the order of symbols is no matter."""
        return np.random.default_rng(stable_seed(self.settings.seed, scene.scene_id, *words))

    def scene(self, scene: Scene) -> None:
        """All interventions on one scene; CannotJudgeError leaves nothing behind."""
        area = region_of_scene(scene, self.region)
        controls, paths = self._paths(scene, area)
        if not len(paths):
            raise CannotJudgeError("paths to judge", "none", row=f"scene {scene.scene_id}")
        before, before_by_rule = self._judge(scene, paths)
        index = len(self.scene_ids)
        self.scene_ids.append(scene.scene_id)
        self.controls.append(controls)
        self.before.append(before)
        if before_by_rule is not None:
            self.before_by_rule.append(before_by_rule.mean(axis=2))
        listed = self.editor.listed(scene)
        if scene.objects is None:
            self.unlisted.append(scene.scene_id)

        def trial(
            kind: Intervention,
            symbol: str,
            k: int,
            at: tuple[float, float],
            after: Scene,
            **more: str,
        ) -> None:
            judged, by_rule = self._judge(after, paths)
            near = distance_to_added(scene, after, paths) if kind == "add" else None
            dose = None
            if near is not None and by_rule is not None and before_by_rule is not None:
                dose = (by_rule - before_by_rule) @ in_bins(near, self.region[2] - self.region[0])
            share = None if by_rule is None else by_rule.mean(axis=2)
            self.trials.append(
                Trial(
                    index, kind, symbol, k, at, judged,
                    by_rule=share, near=near, dose_by_rule=dose, **more,
                )
            )  # fmt: skip

        kinds = self.settings.interventions
        if "add" in kinds:
            for symbol in self.symbols:
                self._add(scene, listed, area, symbol, trial)
        if "remove" in kinds:
            for k, item in enumerate(scene.objects or ()):
                trial("remove", item.symbol, k, item.center, self.editor.remove(scene, item.id))
        if "move" in kinds:
            self._move(scene, listed, area, trial)
        if "swap" in kinds:
            self._swap(scene, listed, area, trial)
        self._placebo(scene, listed, area, trial)
        self._unrelated(scene, area, trial)

    def view(self, scene: Scene) -> View:
        """The model's view of a scene, without its object list where lists are hidden."""
        return self.model.see(scene.seen() if self.settings.hide_lists else scene)

    def with_one_added(self, scene: Scene) -> list[tuple[str, Scene]]:
        """The scene with one of each symbol added at the first place tried; no room: left out."""
        area, listed = region_of_scene(scene, self.region), self.editor.listed(scene)
        out: list[tuple[str, Scene]] = []

        def keep(
            kind: str, symbol: str, k: int, at: tuple[float, float], after: Scene, **more: str
        ) -> None:
            if k == 0:
                out.append((symbol, after))

        for symbol in self.symbols:
            self._add(scene, listed, area, symbol, keep)
        return out

    def _paths(self, scene: Scene, area: Bounds) -> tuple[FloatArray, Paths]:
        if self.paths is not None:
            given = self.paths.get(scene.scene_id, [])
            if isinstance(given, Motions):
                # Copies: what is measured beside things that are added goes with the scene.
                given = Motions(replace(m, known={}) for m in given.motions[: self.settings.draws])
            else:
                given = given[: self.settings.draws]
            fitted = [fit_bezier(p[:, :2])[0] for p in given]
            return np.array(fitted).reshape(-1, 2), given
        controls = draw_controls(area, self.settings.draws, self.rng(scene, "z_theta"))
        return controls, paths_of(scene, controls)

    def _judge(self, scene: Scene, paths: Paths) -> tuple[FloatArray, FloatArray | None]:
        """(types, draws) probability of validity, and what each rule accepts.

        Learned rules are asked with all that their answers allow: p is the share of the rules of
        the posterior that accept, and (types, rules, draws) what each accepts.
        """
        view = self.view(scene)
        if isinstance(view, RuleView) and view.draws:
            each = np.stack([view.by_draw(paths, t) for t in self.types])
            return each.mean(axis=1), each
        return np.stack([view.p_valid(paths, t) for t in self.types]), None

    def _spots(
        self,
        listed: Scene,
        area: Bounds,
        radius: float,
        rng: np.random.Generator,
        without: Sequence[str] = (),
        n: int | None = None,
    ) -> FloatArray:
        width = area[2] - area[0]
        clear = self.settings.clear_ends_px
        return free_places(
            listed,
            radius,
            self.settings.placements if n is None else n,
            rng,
            gap_px=GAP * width,
            end_gap_px=CLEAR_ENDS * width if clear is None else clear,
            bounds=area,
            without=without,
        )

    def _add(
        self, scene: Scene, listed: Scene, area: Bounds, symbol: str, trial: Callable[..., None]
    ) -> None:
        """Each placement draws its own item, so that no single item stands for its symbol.

        The places are stratified by how far they lie from the straight line start–goal, which
        decides most of the effect: the k-th of P comes from the k-th P-tile of free places.
        Over all P they are uniform over the free table, as unstratified ones would be.
        """
        rng = self.rng(scene, "add", symbol)
        templates = self.editor.templates(symbol, scene)
        wanted = self.settings.placements if templates else 0
        done = 0
        for k in range(wanted):
            template = templates[int(rng.integers(len(templates)))]
            angle = float(rng.uniform(0, 2 * np.pi))
            spots = self._spots(listed, area, template.radius_px(scene), rng, n=8 * wanted)
            if len(spots):
                order = np.argsort(distance_from_line(spots, scene), kind="stable")
                pick = order[int((k + rng.random()) / wanted * len(spots))]
                at = (float(spots[pick, 0]), float(spots[pick, 1]))
                after = template.put(scene, at, angle)
                trial("add", symbol, k, at, after, source=template.name)
                done += 1
        if done < self.settings.placements:
            self.short.setdefault(symbol, []).append((scene.scene_id, done))

    def _move(self, scene: Scene, listed: Scene, area: Bounds, trial: Callable[..., None]) -> None:
        for k, item in enumerate(scene.objects or ()):
            rng = self.rng(scene, "move", item.id)
            spots = self._spots(listed, area, item.outline_radius, rng, without=[item.id], n=1)
            for x, y in spots:
                at = (float(x), float(y))
                trial("move", item.symbol, k, at, self.editor.move(scene, item.id, at))

    def _swap(self, scene: Scene, listed: Scene, area: Bounds, trial: Callable[..., None]) -> None:
        """Another symbol where the object stood, wherever something of it fits there."""
        for k, item in enumerate(scene.objects or ()):
            bare = None
            for symbol in self.symbols:
                if symbol == item.symbol:
                    continue
                rng = self.rng(scene, "swap", item.id, symbol)
                templates = self.editor.templates(symbol, scene)
                template = self._fitting(templates, listed, item.id, rng)
                if template is not None:
                    bare = bare if bare is not None else self.editor.remove(scene, item.id)
                    after = template.put(bare, item.center, float(rng.uniform(0, 2 * np.pi)))
                    trial("swap", item.symbol, k, item.center, after, onto=symbol,
                          source=template.name)  # fmt: skip

    def _fitting(
        self, templates: Sequence[Template], listed: Scene, gone: str, rng: np.random.Generator
    ) -> Template | None:
        center = next(o.center for o in listed.objects or () if o.id == gone)
        room = float(room_around(listed, [center], without=[gone])[0])
        for i in rng.permutation(len(templates))[:8]:
            if templates[int(i)].radius_px(listed) <= room:
                return templates[int(i)]
        return None

    def _placebo(
        self, scene: Scene, listed: Scene, area: Bounds, trial: Callable[..., None]
    ) -> None:
        rng = self.rng(scene, "placebo")
        radius = 0.06 * (area[2] - area[0])
        spots = self._spots(listed, area, radius, rng)
        done = 0
        for k, (x, y) in enumerate(spots):
            at = (float(x), float(y))
            after = self.editor.placebo(scene, at, rng)
            if after is not None:
                trial("placebo", "", k, at, after)
                done += 1
        if done < self.settings.placements:
            self.short.setdefault("", []).append((scene.scene_id, done))

    def _unrelated(self, scene: Scene, area: Bounds, trial: Callable[..., None]) -> None:
        """A thing of a class that nobody has shown to the model, as large as what stands there.

        It is in the list alone: a picture of it would be one of some other class.
        """
        if not scene.objects or self.settings.hide_lists:
            return
        radius = float(np.median([o.outline_radius for o in scene.objects]))
        taken = {o.symbol for o in scene.objects}.union(self.symbols)
        symbol = next(s for s in ("unrelated" + "_" * i for i in range(99)) if s not in taken)
        for x, y in self._spots(scene, area, radius, self.rng(scene, "unrelated"), n=1):
            at = (float(x), float(y))
            thing = SceneObject(f"{symbol}-thing", symbol, at, None, Disc(at, radius))
            objects = (*scene.objects, thing)
            after = scene.with_changes(objects=objects, picture=scene.picture)
            trial("unrelated", "", 0, at, after)

    def table(self, skipped: dict[str, str]) -> TrialTable:
        """What was collected, with every shortfall stated.

        Raises:
            CannotJudgeError: No scene could be judged.
        """
        if not self.scene_ids:
            raise self.refused[0][1]
        return TrialTable(
            scene_ids=tuple(self.scene_ids),
            types=self.types,
            symbols=self.symbols,
            controls=tuple(self.controls),
            before=tuple(self.before),
            trials=tuple(self.trials),
            notes=tuple(self._notes(skipped)),
            skipped=skipped,
            before_by_rule=tuple(self.before_by_rule),
            width=self.region[2] - self.region[0],
        )

    def _notes(self, skipped: dict[str, str]) -> list[str]:
        refused, n = self.refused, len(self.scene_ids)
        notes = [f"{symbol}: not added: {why}" for symbol, why in skipped.items()]
        if refused:
            ids = _some([scene_id for scene_id, _ in refused])
            why = refused[0][1]
            notes.append(
                f"{len(refused)} of {n + len(refused)} scenes could not be judged ({ids}): "
                f"expected {why.expected}, found {why.found}; n = {n}"
            )
        if self.unlisted:
            notes.append(
                f"{len(self.unlisted)} of {n} scenes list no objects ({_some(self.unlisted)}): "
                "free places are where the distance network detects nothing"
            )
        for symbol, places in self.short.items():
            name = symbol or "placebo"
            none = [scene_id for scene_id, done in places if done == 0]
            if none:
                notes.append(
                    f"{name}: no room in {len(none)} of {n} scenes ({_some(none)}): "
                    f"n = {n - len(none)}"
                )
            few = [done for _, done in places if done > 0]
            if few:
                notes.append(
                    f"{name}: room for fewer than {self.settings.placements} placements in "
                    f"{len(few)} of {n} scenes (least {min(few)})"
                )
        return notes


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:5]) + (", …" if len(names) > 5 else "")
