"""What the rules room hands over: rules per type, which are a `ValidityModel` too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.demonstrations import Motion, Paths, Verdict
from demospec.errors import CannotJudgeError, InputError
from demospec.frames import FloatArray, metres_of_unit
from demospec.geometry import nearest_on_paths
from demospec.rules._goodness import Fit
from demospec.rules._verdicts import constraint_verdicts, known_of, verdicts
from demospec.rules.clearance._measure import Distance, nearest_approach, polylines, shape_of
from demospec.rules.constraints._constraint import Constraint
from demospec.scene import Footprint, Scene

if TYPE_CHECKING:
    from demospec.rules.constraints._judge import Worst
    from demospec.rules.influence._rule import InfluenceRule

ANYONE = "anyone"
"""Name of the one type where none is named: of a set in which no demonstration has a type, and of
the answer to a single problem."""

LARGEST_LOGIT = 1e6
"""The logit of a path that nothing in the scene can invalidate."""


@dataclass(frozen=True)
class ClearanceRule:
    """A path is acceptable iff it keeps at least c_k from everything of class k that matters.

    Args:
        value: Relevant symbol → clearance, set units; the point answer.
        interval: Relevant symbol → [lower end, upper end] that the demonstrations allow; the
            upper end is +inf where no demonstration bounds it.
        uninformed: Symbols about which no demonstration says anything.
        distance: Measured from the ``footprint`` (signed) or from the ``center``.
        draws: Rules drawn from the posterior, each relevant symbol → clearance, set units: what
            else the answers allow. Empty for rules that nobody learned.
    """

    value: Mapping[str, float]
    interval: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    uninformed: tuple[str, ...] = ()
    distance: Distance = "footprint"
    draws: tuple[Mapping[str, float], ...] = ()

    @property
    def relevant(self) -> tuple[str, ...]:
        """The symbols that matter."""
        return tuple(self.value)

    def margins(self, scene: Scene, paths: Paths) -> FloatArray:
        """(n,) smallest distance − clearance along each path; ≥ 0 where it is kept.

        +inf where nothing in the scene matters. Set units.

        Raises:
            CannotJudgeError: The scene does not list its objects.
        """
        near = nearest_approach(scene, paths, self.relevant, distance=self.distance)
        if not self.value:
            return np.full(len(near), np.inf)
        return np.asarray((near - np.array(list(self.value.values()))).min(axis=1))

    def margins_and_gradients(
        self, scene: Scene, paths: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Margins (n,) and, for each path (n, m, 2), where to move its points to raise it.

        The subgradient of the smallest margin: the nearest point of the path, away from
        the object, shared between the two path points that it lies between. Zero where
        nothing in the scene matters.
        """
        stack = np.asarray(paths, dtype=np.float64)
        flat = polylines(stack)
        nudge = 2e-5 * scene.length_scale
        margin = np.full(len(flat), np.inf)
        first = np.zeros(len(flat), dtype=np.int64)
        along = np.zeros(len(flat))
        normal = np.zeros((len(flat), 2))
        for item in scene.listed_objects():
            if item.symbol not in self.value:
                continue
            shape = shape_of(item, self.distance)
            found, row, share = nearest_on_paths(flat, shape)
            found = found - self.value[item.symbol]
            closer = np.flatnonzero(found < margin)
            if not len(closer):
                continue
            margin[closer], first[closer], along[closer] = found[closer], row[closer], share[closer]
            here, there = flat.at(row, share)[closer], flat.at(row, np.ones(len(flat)))[closer]
            normal[closer] = _normal(shape, here, there - here, nudge)
        gradient = np.zeros((len(flat.points), 2))
        gradient[first] += (1.0 - along)[:, None] * normal
        inner = np.flatnonzero(along > 0)
        gradient[first[inner] + 1] += along[inner, None] * normal[inner]
        return margin, gradient.reshape(stack.shape[0], stack.shape[1], 2)


def _normal(shape: Footprint, points: FloatArray, ways: FloatArray, nudge: float) -> FloatArray:
    """(n, 2) how the distance of a path changes when its nearest point (n, 2) is displaced.

    Where two sides of a footprint are equally near, that is the mixture of both gradients that
    has no part along the path (`ways`, (n, 2)): the nearest point slides along it.
    """
    length = np.hypot(ways[:, 0], ways[:, 1])[:, None]
    way = ways / np.where(length > 0, length, 1.0)
    steps = nudge * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    sides = points[:, None] + 2 * nudge * np.stack([-way, way], axis=1)
    d = shape.signed_distance(sides[:, :, None] + steps)
    slopes = np.stack([d[..., 0] - d[..., 1], d[..., 2] - d[..., 3]], axis=2) / (2 * nudge)
    before, after = (slopes * way[:, None]).sum(axis=2).T
    turns = (before < 0) & (after > 0)
    share = np.where(turns, after / np.where(turns, after - before, 1.0), 0.5)[:, None]
    return np.asarray(share * slopes[:, 0] + (1.0 - share) * slopes[:, 1])


@dataclass(frozen=True)
class TypeRules:
    """What one user type follows.

    Args:
        clearance: The clearance rule, or None where it cannot be learned or is not given.
        influence: The influence answer (JSON document) for the same type, or None; lengths in
            set units. `influence_rule` is what it says.
        sentence: Both in plain words.
        evidence: Further fields of the JSON document: counts, probabilities, contradictions.
        fit: How well the rule fits the labels that it was learned from; None where it was not
            learned.
        constraints: What the type asks for besides clearances (or in their place); a path is
            acceptable iff it keeps the rule and all of these.
    """

    clearance: ClearanceRule | None = None
    influence: Any | None = None
    sentence: str = ""
    evidence: Mapping[str, Any] = field(default_factory=dict)
    fit: Fit | None = None
    constraints: tuple[Constraint, ...] = ()

    @property
    def constrained(self) -> tuple[str, ...]:
        """Classes of things that its constraints are about."""
        out: list[str] = []
        for c in self.constraints:
            of = c.of if c.when is None else c.when.of
            out += [of] if isinstance(of, str) else of or ()
        return tuple(dict.fromkeys(out))

    @cached_property
    def influence_rule(self) -> InfluenceRule | None:
        """The influence answer as a rule, read once; InputError where it is none."""
        if self.influence is None:
            return None
        from demospec.rules.influence._rule import InfluenceRule

        return InfluenceRule.of(self.influence)


@dataclass(frozen=True)
class RuleSet:
    """Rules per user type; the answer of ``demospec rules SET`` and a `ValidityModel`.

    Args:
        rules: Type → its rules.
        units, metres_per_unit: As in the set that the rules speak about.
        notes: What was left out of the answer and why, in words.
        unit_stated: Whether a file said in which unit it speaks.
    """

    rules: Mapping[str, TypeRules]
    units: str = "px"
    metres_per_unit: float | None = None
    notes: tuple[str, ...] = ()
    unit_stated: bool = field(default=True, compare=False)

    @property
    def types(self) -> tuple[str, ...]:
        """The types that have a rule to judge by."""
        return tuple(
            name
            for name, rule in self.rules.items()
            if rule.clearance is not None or rule.influence is not None or rule.constraints
        )

    def for_types(self, types: Sequence[str]) -> RuleSet:
        """The same rules for people of these types.

        Rules of `ANYONE` alone were learnt or written without asking who: they hold for each of
        the types. Rules of named types stay what they are.
        """
        if set(self.rules) != {ANYONE} or not types:
            return self
        return replace(self, rules=dict.fromkeys(types, self.rules[ANYONE]))

    def see(self, scene: Scene) -> RuleView:
        """Look at a scene; CannotJudgeError where it does not list its objects, or has a scale of
        its own and the rules have none."""
        scene.listed_objects()
        return RuleView(self.in_scene(scene), scene)

    def in_scene(self, scene: Scene) -> RuleSet:
        """The same rules in the pixels of a scene that has a scale of its own."""
        if scene.metres_per_unit is None:
            return self
        from demospec.rules._units import rules_in_unit

        if metres_of_unit(self.units, self.metres_per_unit) is None:
            raise CannotJudgeError(
                "rules with a scale (metres_per_unit), as the picture has its own",
                "none",
                row=f"scene {scene.scene_id}",
                field="metres_per_unit",
            )
        return rules_in_unit(self, "px", scene.metres_per_unit)

    def of_type(self, type: str) -> TypeRules:
        """The rules of one type; InputError lists the types there are."""
        if type not in self.rules:
            raise InputError(f"one of the types {', '.join(self.rules)}", type, field="type")
        return self.rules[type]


@dataclass(frozen=True)
class RuleView:
    """A rule set that looks at one scene. The verdict is certain: p is 0 or 1."""

    model: RuleSet
    scene: Scene

    def logits(self, paths: Paths, type: str) -> FloatArray:
        """(n,) margins: set units for a clearance rule, penalty for an influence rule.

        The clearance rule judges where there is one, and the constraints beside it: the least
        margin, each in its own unit. > 0 exactly where the rule is kept; capped at
        `LARGEST_LOGIT`. A constraint that the paths do not hold the columns or times for (see
        `Motions`) lets them pass; `verdicts` says ``unknown`` of them.
        """
        rules = self.model.of_type(type)
        own = self._margins(rules, paths)
        if rules.constraints:
            asked = self.margins(paths, type)
            least = np.where(np.isnan(asked), np.inf, asked).min(axis=1)
            own = least if own is None else np.minimum(own, least)
        if own is None:
            raise InputError("a rule to judge by", "none", field=f"types.{type}")
        return _as_logit(own)

    def _margins(self, rules: TypeRules, paths: Paths) -> FloatArray | None:
        if rules.clearance is not None:
            return rules.clearance.margins(self.scene, paths)
        if rules.influence_rule is not None:
            return np.asarray(rules.influence_rule.margins(self.scene, paths))
        return None

    def margins(self, paths: Paths, type: str) -> FloatArray:
        """(n, k) margins under each of the type's constraints; NaN where not measurable."""
        from demospec.rules.constraints._judge import margins

        return margins(self.model.of_type(type).constraints, self.scene, paths)

    def p_valid(self, paths: Paths, type: str) -> FloatArray:
        """(n,) 0 or 1."""
        return self.p_of_logits(self.logits(paths, type))

    def broken(self, path: Motion | FloatArray, type: str) -> list[Worst]:
        """The type's constraints that a path breaks, and where; the one it breaks most first.

        Args:
            path: With times and columns, or bare places (n, 2): then what needs more is kept.
        """
        from demospec.rules.constraints._judge import worst

        found = [worst(c, self.scene, path) for c in self.model.of_type(type).constraints]
        broken = [one for one in found if one.margin < 0]
        return sorted(broken, key=lambda w: w.margin / (abs(w.constraint.value) or 1.0))

    def verdicts(self, paths: Paths, type: str) -> list[Verdict]:
        """One verdict a path; `unknown` where a learned rule's demonstrations decide nothing."""
        rules = self.model.of_type(type)
        if rules.clearance is None:
            own = self._margins(rules, paths)
            said: list[Verdict] = ["accept"] * len(paths)
            if own is not None:
                said = ["accept" if z >= 0 else "reject" for z in own]
        else:
            c = rules.clearance
            known = known_of(c.value, c.interval, rules.evidence, rules.fit)
            learned = "at_most" in rules.evidence
            said = verdicts(known, self.scene, paths, c.distance, learned=learned)
        if not rules.constraints:
            return said
        asked = [
            constraint_verdicts(c, column)
            for c, column in zip(rules.constraints, self.margins(paths, type).T, strict=True)
        ]
        if rules.fit is not None and rules.fit.verdict == "not":
            return ["unknown"] * len(said)
        return [_of_all(one) for one in zip(said, *asked, strict=True)]

    @property
    def draws(self) -> int:
        """Rules of the posterior of any type; 0 for rules that nobody learned."""
        rules = (self.model.rules[name].clearance for name in self.model.types)
        return max((len(r.draws) for r in rules if r is not None), default=0)

    def by_draw(self, paths: Paths, type: str) -> FloatArray:
        """(draws, n) what each rule of the posterior accepts, 0 or 1.

        A type without draws has its one rule in each of the rows; a shorter list begins anew.
        """
        rules = self.model.of_type(type)
        accepted = self._clearance_by_draw(rules, paths)
        if not rules.constraints:
            return accepted
        from demospec.rules.constraints._gradients import shifts

        margins = self.margins(paths, type)
        for column, shift in zip(margins.T, shifts(rules.constraints, self.draws), strict=True):
            # What cannot be measured is kept, as by `logits`.
            accepted = accepted * ~(column + shift[:, None] < 0)
        return accepted

    def _clearance_by_draw(self, rules: TypeRules, paths: Paths) -> FloatArray:
        rule = rules.clearance
        if rule is None or not rule.draws:
            own = self._margins(rules, paths)
            kept = np.ones(len(paths)) if own is None else (own >= 0).astype(np.float64)
            return np.tile(kept, (self.draws, 1))
        symbols = tuple(dict.fromkeys(s for draw in rule.draws for s in draw))
        if not symbols:
            return np.ones((self.draws, len(paths)))
        near = nearest_approach(self.scene, paths, symbols, distance=rule.distance)
        least = np.array([[draw.get(s, -np.inf) for s in symbols] for draw in rule.draws])
        accepted = np.stack([(near >= own).all(axis=1) for own in least]).astype(np.float64)
        return np.resize(accepted, (self.draws, accepted.shape[1]))

    def p_of_logits(self, logits: FloatArray) -> FloatArray:
        """1 where the logit is > 0, else 0: who has the logits need not judge again."""
        return (logits > 0).astype(np.float64)

    def logits_and_gradients(self, paths: FloatArray, type: str) -> tuple[FloatArray, FloatArray]:
        """Logits (n,) and their subgradients along the paths (n, m, 2).

        Paths are of the plane: what asks for heights, tilts or times has no part in it.

        Raises:
            InputError: The type has an influence rule only, which counts points and so has no
                gradient.
        """
        rules = self.model.of_type(type)
        if rules.clearance is None and (rules.influence is not None or not rules.constraints):
            field_name = f"types.{type}.clearance"
            raise InputError("a clearance rule (it has gradients)", "none", field=field_name)
        margin, gradient = np.full(len(paths), np.inf), np.zeros(np.shape(paths))
        if rules.clearance is not None:
            margin, gradient = rules.clearance.margins_and_gradients(self.scene, paths)
        if rules.constraints:
            from demospec.rules.constraints._gradients import margins_and_gradients

            asked, slopes = margins_and_gradients(rules.constraints, self.scene, paths)
            closer = asked < margin
            margin = np.where(closer, asked, margin)
            gradient = np.where(closer[:, None, None], slopes, gradient)
        return _as_logit(margin), gradient


def _of_all(said: tuple[Verdict, ...]) -> Verdict:
    """A conjunction: rejected if any part is broken, accepted if all are known to be kept."""
    if "reject" in said:
        return "reject"
    return "unknown" if "unknown" in said else "accept"


def _as_logit(margins: FloatArray) -> FloatArray:
    # A margin of exactly 0 keeps the rule; a logit of 0 would not count as valid.
    kept = np.where(margins >= 0, np.maximum(margins, 1e-9), margins)
    return np.clip(kept, -LARGEST_LOGIT, LARGEST_LOGIT)
