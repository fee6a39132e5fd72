"""Influence answers in plain sentences."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from demospec.frames import describe_length
from demospec.rules._sentences import listed, plural
from demospec.rules.constraints.features._point_features import feature_named
from demospec.rules.influence._answer import InfluenceAnswer
from demospec.rules.influence._problem import RuleProblem


def describe_influence(
    answer: InfluenceAnswer,
    problem: RuleProblem,
    length: Callable[[float], str] = lambda value: f"{value:g} units",
) -> tuple[str, ...]:
    """The answer in plain sentences.

    Args:
        length: A length in words, as from `describe_length`.
    """
    if answer.status == "infeasible":
        return _contradiction(answer)
    if answer.hull_T_min is None or answer.hull_radius is None:
        if answer.contradicted is not None:
            return (
                "The time ran out: the parameters printed contradict "
                f"{len(answer.contradicted)} demonstration(s); fewer may do.",
            )
        return ("No consistent parameters were found in the time allowed.",)
    low, high = answer.hull_T_min
    lines = [
        f"No point may come as near as T_min to anything; T_min is {_range(length, low, high)}."
    ]
    for name, (least, most) in zip(answer.names, answer.hull_radius, strict=True):
        verb = _sentence(problem, name).format(name=name, value=length(low))
        lines.append(
            f"{name}: {verb}; out to {_range(length, least, most)} it depends on how long."
        )
    end = {"min": answer.saturated_min, "max": answer.saturated_max}
    for which, names in end.items():
        if names:
            lines.append(f"At the {which}imum, set by the bound, not by data: {', '.join(names)}.")
    if answer.contradicted is not None:
        lines += _tolerated(answer)
    if answer.status == "timeout":
        lines.append("The time ran out: the ranges may be wider than printed.")
    if not any(not path.valid for path in problem.trajectories):
        lines.append(
            "Nobody showed a bad demonstration: upper ends say how far the influence could "
            "reach without forbidding what was shown; lower ends are the bounds, not data."
        )
    elif not any(path.valid for path in problem.trajectories):
        lines.append("Nobody showed a good demonstration: upper ends are the bounds, not data.")
    return tuple(lines)


def _tolerated(answer: InfluenceAnswer) -> list[str]:
    """Which demonstrations a tolerant fit contradicts, and what its ranges allow for."""
    wrong = answer.contradicted or ()
    few = f"At least {len(wrong)} demonstration(s) must be" if wrong else "None must be"
    names = f": {_listed(answer, wrong)} by the least parameters that do" if wrong else ""
    lines = [f"{few} contradicted{names}."]
    if answer.allowed is not None and answer.allowed > len(wrong):
        lines.append(
            f"With {answer.label_noise:.0%} of labels wrong more may be: the ranges hold for all "
            f"parameters that contradict up to {answer.allowed}."
        )
    return lines


def _contradiction(answer: InfluenceAnswer) -> tuple[str, ...]:
    if not answer.conflict:
        return ("No parameters within the bounds agree with the labels.",)
    return (
        "No parameters agree with all labels. These demonstrations contradict each other "
        f"(leave any one out and the rest agree): {_listed(answer, answer.conflict)}.",
    )


def _listed(answer: InfluenceAnswer, indices: Sequence[int]) -> str:
    ids = answer.trajectory_ids
    return ", ".join((ids[i] or f"#{i}") if i < len(ids) else f"#{i}" for i in indices)


def _range(length: Callable[[float], str], low: int, high: int) -> str:
    if low == high:
        return f"exactly {length(low)}"
    return f"between {_first(length(low), length(high))} and {length(high)}"


def _sentence(problem: RuleProblem, name: str) -> str:
    k = problem.parameters.index(name)
    for scene, members in zip(problem.scenes, problem.parameter_of, strict=True):
        for item, at in zip(scene.objects, members, strict=True):
            if at == k:
                return feature_named(item.feature).sentence
    return "keeps at least {value} from {name}"


def influence_words(
    answer: Mapping[str, Any], metres_per_unit: float | None, units: str = "px"
) -> str:
    """``keeps at least 37 px from the drill; between 37 px and 159 px it depends on how long``.

    Classes whose influence need not reach beyond T_min are left out.

    Args:
        answer: The JSON of one type's answer, in units of the set.
        metres_per_unit, units: Of the set.
    """

    def length(value: float) -> str:
        return describe_length(value, metres_per_unit, units)

    hull = answer.get("hull")
    if not hull:
        return "" if not answer.get("max") else _unproven_words(answer, length)
    low, high = hull["T_min"]
    least = length(high)
    if low != high:
        least = f"{_first(length(low), least)} to {least}"
    by_class = answer["settings"].get("thresholds") == "class"
    far = [
        (plural(name) if by_class else f"the {name}", length(longest))
        for name, (shortest, longest) in hull["radius"].items()
        if shortest > high
    ]
    if high == 0 and far:
        # Touching is not forbidden as such: "at least 0 px" would say nothing.
        reach = listed([f"{words} from {where}" for where, words in far])
        text = f"no distance is forbidden outright; within {reach} it depends on how long"
    elif len(far) == 1 and len(hull["radius"]) == 1:
        ((where, words),) = far
        text = f"keeps at least {least} from {where}; "
        text += f"between {_first(length(high), words)} and {words} it depends on how long"
    elif far:
        # T_min holds for every class, also where only one reaches further.
        reach = listed([f"{words} from {where}" for where, words in far])
        text = f"keeps at least {least} from everything; out to {reach} it depends on how long"
    else:
        text = f"keeps at least {least} from the centre of everything"
    wrong = answer.get("contradicted")
    if wrong:
        text += f"; {len(wrong)} demonstrations contradict this"
    if answer.get("status") == "timeout":
        text += " (stopped early: distances may range more widely)"
    return text


def _first(low: str, high: str) -> str:
    """The first of two lengths, without its unit where the second has the same."""
    number, _, unit = low.rpartition(" ")
    return number if unit == high.rpartition(" ")[2] else low


def _unproven_words(answer: Mapping[str, Any], length: Callable[[float], str]) -> str:
    """Words for the best that was known when the time ran out."""
    T_min, own = answer["max"]["T_min"], answer["max"]["T_object"]
    far = [f"{length(T_min + t)} from {plural(name)}" for name, t in own.items() if t > 0]
    reach = f"; out to {listed(far)} it depends on how long" if far else ""
    wrong = len(answer.get("contradicted") or ())
    return (
        f"keeps at least {length(T_min)} from everything{reach}; {wrong} demonstrations "
        "contradict this (stopped early: other distances may contradict fewer)"
    )
