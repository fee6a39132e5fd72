"""What to ask next: the demonstration whose label splits the remaining parameters best."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from demospec.errors import InputError
from demospec.frames import FloatArray
from demospec.rules._problem_fields import unread_note
from demospec.rules.active._candidates import (
    BoolArray,
    WeighedSets,
    check_error_rate,
    effective_number,
    paths_as_steps,
    verdicts,
    weighed_sets,
)
from demospec.rules.active._probes import Place, Probe, draw_probe
from demospec.rules.active._result import Query
from demospec.rules.clearance._problem import ClearanceProblem
from demospec.rules.influence._problem import RuleProblem

ERRING = 0.05
"""Rate of wrong labels that is assumed where the labels contradict each other."""

NOISY_BITS = 0.02
"""Below this gain a teacher who errs cannot be asked anything useful."""

_JUDGES = 6000  # sets that choose among the probes; the chosen one is counted over all
_FINALISTS = 4
_ROUNDS = 5
_ENOUGH = 0.9998  # of the bits that an even split would bring


def next_query(
    problem: RuleProblem | ClearanceProblem,
    *,
    error_rate: float = 0.0,
    pool: int = 300,
    seed: int = 0,
    random: bool = False,
) -> Query:
    """The path whose label would tell most, from a pool of probes.

    Args:
        problem: What was shown so far, of either family; it may hold no trajectory yet.
        error_rate: Share of answers that the teacher gets wrong, in [0, 0.5). Where the
            labels contradict each other `ERRING` is assumed.
        pool: Probes to choose among; the best are varied and tried again.
        seed: Of the pool.
        random: Take any probe that is not settled already (a baseline, to compare with).

    Raises:
        InputError: No objects to ask about, F_max unknown, or a wrong rate.
    """
    check_error_rate(error_rate)
    if isinstance(problem, ClearanceProblem):
        from demospec.rules.active._clearance import next_clearance_query

        return next_clearance_query(problem, pool=pool, seed=seed)
    if problem.F_max is None:
        raise InputError("a known F_max (or identify_F_max)", "null", field="F_max")
    if not problem.parameters:
        raise InputError("at least one object to ask about", "none", field="scenes")
    note = ""
    left = weighed_sets(problem, error_rate, seed)
    if not len(left.sets):
        error_rate = ERRING
        note = f"the labels contradict each other: {ERRING:.0%} of them are taken for wrong"
        left = weighed_sets(problem, error_rate, seed)
    rng = np.random.default_rng(seed)
    judges = _judges(left, rng)
    # Ends that were shown first; where those tell little, ends out of everything's influence.
    found: list[tuple[float, Probe]] = []
    for shown in (True, False):
        places = probe_places(problem, shown=shown)
        if random:
            found = _score(problem, [_draw(rng, problem, places, judges)], judges, error_rate)
            break
        found += _search(problem, places, judges, error_rate, pool, rng)
        if max(bits for bits, _ in found) >= 0.5 * answer_bits(0.5, error_rate):
            break
    best = sorted(found, key=lambda s: -s[0])[:_FINALISTS]
    return _counted(problem, [p for _, p in best], left, error_rate, note)


def _search(
    problem: RuleProblem,
    places: Sequence[Place],
    judges: np.ndarray,
    error_rate: float,
    pool: int,
    rng: np.random.Generator,
) -> list[tuple[float, Probe]]:
    """The best probes of a pool, varied until one splits evenly; bits and probe."""
    probes = [_draw(rng, problem, places, judges) for _ in range(pool)]
    scored = _score(problem, probes, judges, error_rate)
    best = sorted(scored, key=lambda s: -s[0])[: 3 * _FINALISTS]
    enough = _ENOUGH * answer_bits(0.5, error_rate)
    for _ in range(_ROUNDS):
        if best[0][0] >= enough:
            break
        near = [probe.varied(rng) for _, probe in best for _ in range(10)]
        near += [_draw(rng, problem, places, judges) for _ in range(pool // 3)]
        scored = [*best, *_score(problem, near, judges, error_rate)]
        best = sorted(scored, key=lambda s: -s[0])[: 3 * _FINALISTS]
    return best


def query_file(
    path: str | os.PathLike[str], *, error_rate: float = 0.0, pool: int = 300, seed: int = 0
) -> Query:
    """The next question for a problem file of either family.

    Raises:
        InputError: Naming file and field.
    """
    from demospec.files import read_json
    from demospec.rules.clearance._problem import clearance_problem_from_document
    from demospec.rules.influence._problem import problem_from_document

    document = read_json(path)
    family = document.get("family") if isinstance(document, dict) else None
    try:
        problem: RuleProblem | ClearanceProblem
        if family == "clearance":
            problem = clearance_problem_from_document(document)
        else:
            problem = problem_from_document(document)
        warning = unread_note(document, "clearance" if family == "clearance" else "influence")
        query = next_query(problem, error_rate=error_rate, pool=pool, seed=seed)
        return replace(query, warning=warning)
    except InputError as error:
        raise error.at(file=path) from error


def _judges(left: WeighedSets, rng: np.random.Generator) -> np.ndarray:
    """A sample of the remaining sets that stands for all of them."""
    if len(left.sets) <= _JUDGES and np.ptp(left.weight) == 0:
        return left.sets
    at = (np.arange(_JUDGES) + rng.random()) / _JUDGES
    rows = np.searchsorted(np.cumsum(left.weight), at * left.weight.sum())
    return np.asarray(left.sets[np.clip(rows, 0, len(left.sets) - 1)])


def probe_places(problem: RuleProblem, *, shown: bool = True) -> list[Place]:
    """Scenes with objects, and where paths begin and end in them.

    Args:
        shown: Where demonstrations began and ended, if there are any; else out of reach.
    """
    places = []
    every = [p.points for p in problem.trajectories]
    for s, scene in enumerate(problem.scenes):
        if not scene.objects:
            continue
        centers = np.array([o.center[:2] for o in scene.objects], dtype=np.float64)
        mine = [p.points for p in problem.trajectories if p.scene == s] or every
        if mine and shown:
            starts = np.unique([p[0, :2] for p in mine], axis=0)[:50]
            goals = np.unique([p[-1, :2] for p in mine], axis=0)[:50]
        else:
            starts, goals = _ring(problem, centers)
        width = max([len(o.center) for o in scene.objects])
        if mine:
            width = max(width, mine[0].shape[1])
        rest = [o.center[2] if len(o.center) > 2 else 0.0 for o in scene.objects]
        extra = tuple([float(np.mean(rest))] + [0.0] * (width - 3)) if width > 2 else ()
        places.append(Place(s, starts, goals, centers, extra))
    return places


def _ring(problem: RuleProblem, centers: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ends of paths where nobody showed any: around the objects, out of their influence."""
    middle = centers.mean(axis=0)
    far = problem.bounds.radius[1] + np.linalg.norm(centers - middle, axis=1).max() + 1
    turn = np.arange(8) * (np.pi / 4)
    ring = middle + far * np.column_stack([np.cos(turn), np.sin(turn)])
    return ring, ring


def _draw(
    rng: np.random.Generator, problem: RuleProblem, places: Sequence[Place], judges: np.ndarray
) -> Probe:
    """A probe at a distance about which two of the remaining sets disagree."""
    assert problem.F_max is not None
    place = places[int(rng.integers(len(places)))]
    item = int(rng.integers(len(place.centers)))
    column = 1 + problem.parameter_of[place.scene][item]
    a, b = judges[rng.integers(len(judges), size=2)]
    use_contact = rng.random() < 0.3
    ends = (a[0], b[0]) if use_contact else (a[0] + a[column], b[0] + b[column])
    low, high = sorted(int(e) for e in ends)
    distance = low + rng.random() * max(high - low, 1)
    each = {"distance": max(distance, 1.0), "hinge": 1.0 + 0.3 * (high - low), "count": 1.0}
    enough = problem.F_max / each[problem.penalty]
    if problem.weights == "arc":
        enough /= max(0.05 * float(np.ptp(place.starts)), 1.0)
    return draw_probe(rng, place, item, distance, min(enough, 300.0))


def _score(
    problem: RuleProblem, probes: Sequence[Probe], judges: np.ndarray, error_rate: float
) -> list[tuple[float, Probe]]:
    """Bits of each probe, by the sets that judge."""
    steps, where = paths_as_steps(problem, [(p.place.scene, p.points()) for p in probes])
    out = []
    for probe, (block, row) in zip(probes, where, strict=True):
        p = float(verdicts(steps, block, row, judges).mean())
        out.append((answer_bits(p, error_rate), probe))
    return out


def answer_bits(p: float, error_rate: float) -> float:
    """Information in bits of an answer that is "valid" with probability p, wrong at a rate."""
    heard = p * (1 - error_rate) + (1 - p) * error_rate
    return max(_entropy(heard) - _entropy(error_rate), 0.0)


def _entropy(p: float) -> float:
    if p <= 0.0 or p >= 1.0:
        return 0.0
    return float(-(p * np.log2(p) + (1 - p) * np.log2(1 - p)))


def _counted(
    problem: RuleProblem,
    finalists: Sequence[Probe],
    left: WeighedSets,
    error_rate: float,
    note: str,
) -> Query:
    """The best of the last few probes, counted over every set that is left."""
    steps, where = paths_as_steps(problem, [(p.place.scene, p.points()) for p in finalists])
    best: tuple[float, Probe, BoolArray] | None = None
    for probe, (block, row) in zip(finalists, where, strict=True):
        accepts = verdicts(steps, block, row, left.sets)
        bits = answer_bits(float(left.weight[accepts].sum()), error_rate)
        if best is None or bits > best[0]:
            best = (bits, probe, accepts)
    assert best is not None
    bits, probe, accepts = best
    least = NOISY_BITS if error_rate > 0 else 1e-9
    if bits < least:
        word = note or "no path of the pool splits what is left"
        return Query("settled", bits=bits, total=left.total, exact=left.exact, note=word)
    p = float(left.weight[accepts].sum())
    valid, invalid = _left_after(left, accepts, p, error_rate)
    return Query(
        "ask",
        scene=probe.place.scene,
        points=probe.points(),
        if_valid=valid,
        if_invalid=invalid,
        bits=bits,
        p_valid=p * (1 - error_rate) + (1 - p) * error_rate,
        total=left.total,
        exact=left.exact and error_rate == 0,
        note=note,
    )


def _left_after(
    left: WeighedSets, accepts: BoolArray, p: float, error_rate: float
) -> tuple[float | None, float | None]:
    """Sets left after either answer."""
    if error_rate == 0.0:
        if left.exact:
            count = int(accepts.sum())
            return count, len(left.sets) - count
        if left.total is None:
            return None, None
        return p * left.total, (1 - p) * left.total
    if not left.exact:
        return None, None
    numbers = []
    for answer in (True, False):
        weight = left.weight * np.where(accepts == answer, 1 - error_rate, error_rate)
        numbers.append(effective_number(weight / weight.sum()))
    return numbers[0], numbers[1]
