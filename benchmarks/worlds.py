"""Simulated people of many kinds, most of whom do not follow a clearance rule.

The generator shares no code with the learner: it measures with its own dense samples of discs.
A world is a table of 100 × 100 px (1 m) with discs of four classes; every path has time stamps,
a height column and a tilt column. `KINDS` names the people; each says which verdict of the fit
is right and which suspect explains the rest, where the set holds it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet
from demospec.scene import Disc, Scene, SceneObject

CLASSES = ("bowl", "glass", "plate", "utensil")
SIZE = 100.0
_DENSE = 300

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


@dataclass
class World:
    """Everything about the paths of one set that a person may judge by.

    Args:
        objects: By scene: (class, x, y, radius).
        scene: (n,) scene of each path.
        dense: (n, m, 2) points along each path.
        distance: (n, 4) least distance to each class; +inf where the scene has none.
        side: (n, 4, 4) the same where only path points right of, left of, below or above the
            thing's centre count.
        shape: Named (n,) numbers of the path: length, duration, speed, height, tilt, curvature.
    """

    objects: list[list[tuple[str, float, float, float]]]
    scene: NDArray[np.int64]
    dense: Floats
    time: Floats
    distance: Floats
    side: Floats
    shape: dict[str, Floats]
    demonstrator: NDArray[np.object_]
    columns: Floats = field(default_factory=lambda: np.empty(0))


Judge = Callable[[World, np.random.Generator], Bools]


@dataclass(frozen=True)
class Kind:
    """One kind of person.

    Args:
        judge: Accepts or rejects each path.
        family: ``in`` (a clearance rule, perhaps with noise), ``coin``, or ``out``.
        suspect: Feature that explains the rest, or None where the set does not hold it.
        hidden: Classes that stand on the table but are not listed.
        truth: Class → clearance where the person keeps one.
    """

    judge: Judge
    family: str
    suspect: str | None = None
    hidden: tuple[str, ...] = ()
    truth: dict[str, float] = field(default_factory=dict)


def make_world(rng: np.random.Generator, scenes: int = 20, each: int = 10) -> World:
    """Random tables and paths."""
    objects = []
    for _ in range(scenes):
        names = list(rng.permutation(CLASSES)) + list(rng.choice(CLASSES, 2))
        things: list[tuple[str, float, float, float]] = []
        for name in names:
            for _ in range(50):
                radius = float(rng.uniform(2.5, 6.0))
                x, y = (float(v) for v in rng.uniform(18.0, 82.0, 2))
                if all(np.hypot(x - a, y - b) > radius + c + 3.0 for _, a, b, c in things):
                    things.append((str(name), x, y, radius))
                    break
        objects.append(things)
    n = scenes * each
    scene = np.repeat(np.arange(scenes), each)
    start = np.stack([np.full(n, 5.0), rng.uniform(30.0, 70.0, n)], axis=1)
    goal = np.stack([np.full(n, 95.0), rng.uniform(30.0, 70.0, n)], axis=1)
    start, goal = start[scene * each], goal[scene * each]  # one start and goal a scene
    bend = np.stack([rng.uniform(20.0, 80.0, n), rng.uniform(-30.0, 130.0, n)], axis=1)
    u = np.linspace(0.0, 1.0, _DENSE)
    dense = (
        (1 - u)[None, :, None] ** 2 * start[:, None]
        + (2 * u * (1 - u))[None, :, None] * bend[:, None]
        + u[None, :, None] ** 2 * goal[:, None]
    )
    dense = np.clip(dense, 0.5, SIZE - 0.5)
    step = np.linalg.norm(np.diff(dense, axis=1), axis=2)
    length = step.sum(axis=1)
    # Speed: a level of its own for each path, and a gentle rise and fall.
    level = rng.uniform(8.0, 40.0, n)
    profile = level[:, None] * (1.0 + 0.3 * np.sin(np.pi * u[1:])[None])
    time = np.concatenate([np.zeros((n, 1)), np.cumsum(step / profile, axis=1)], axis=1)
    height = rng.uniform(5.0, 40.0, n)[:, None] + rng.uniform(0, 10, n)[:, None] * np.sin(np.pi * u)
    tilt = np.abs(rng.uniform(0.0, 40.0, n)[:, None] * np.sin(np.pi * u))
    distance = np.full((n, len(CLASSES)), np.inf)
    side = np.full((n, len(CLASSES), 4), np.inf)
    for i in range(n):
        for name, x, y, radius in objects[scene[i]]:
            k = CLASSES.index(name)
            offset = dense[i] - (x, y)
            gap = np.linalg.norm(offset, axis=1) - radius
            distance[i, k] = min(distance[i, k], gap.min())
            halves = (offset[:, 0] > 0, offset[:, 0] < 0, offset[:, 1] > 0, offset[:, 1] < 0)
            for s, half in enumerate(halves):
                if half.any():
                    side[i, k, s] = min(side[i, k, s], gap[half].min())
    direction = np.unwrap(np.arctan2(*np.moveaxis(np.diff(dense, axis=1), 2, 0)[::-1]), axis=1)
    return World(
        objects,
        scene,
        dense,
        time,
        distance,
        side,
        {
            "length": length,
            "duration": time[:, -1],
            "speed": profile.max(axis=1),
            "height": height.min(axis=1),
            "tilt": tilt.max(axis=1),
            "curvature": np.abs(np.diff(direction, axis=1)).sum(axis=1),
        },
        np.array([f"person-{i % 2}" for i in range(n)], dtype=object),
        np.stack([height, tilt], axis=2),
    )


def as_set(world: World, valid: Bools, kind: Kind, name: str = "someone") -> DemonstrationSet:
    """The demonstration set that such a person would have recorded."""
    listed = [c for c in CLASSES if c not in kind.hidden]
    scenes = tuple(
        Scene(
            f"s{j:02}",
            tuple(world.dense[world.scene == j][0, 0].tolist()),
            tuple(world.dense[world.scene == j][0, -1].tolist()),
            objects=tuple(
                SceneObject(f"{c}-{i}", c, (x, y), None, Disc((x, y), r))
                for i, (c, x, y, r) in enumerate(things)
                if c in listed
            ),
        )
        for j, things in enumerate(world.objects)
    )
    keep = np.linspace(0, _DENSE - 1, 120).round().astype(int)
    items = [
        Demonstration(
            f"d{i:03}",
            f"s{world.scene[i]:02}",
            np.concatenate([world.dense[i, keep], world.columns[i, keep]], axis=1),
            type=name,
            demonstrator=str(world.demonstrator[i]),
            valid=bool(valid[i]),
            t=world.time[i, keep],
        )
        for i in range(len(valid))
    ]
    return DemonstrationSet(
        scenes,
        Demonstrations.of(items, columns=4),
        metres_per_unit=0.01,
        symbols=tuple(listed),
        types=(name,),
        columns=("x", "y", "z", "tilt"),
    )


def _keeps(**clearance: float) -> Judge:
    def judge(world: World, _: np.random.Generator) -> Bools:
        out = np.ones(len(world.scene), dtype=bool)
        for name, c in clearance.items():
            out &= world.distance[:, CLASSES.index(name)] >= c
        return out

    return judge


def _margin(world: World, clearance: dict[str, float]) -> Floats:
    gaps = [world.distance[:, CLASSES.index(name)] - c for name, c in clearance.items()]
    return np.min(gaps, axis=0)


def _noisy(sd: float = 0.0, flips: float = 0.0, strict: float = 0.0, **clearance: float) -> Judge:
    def judge(world: World, rng: np.random.Generator) -> Bools:
        margin = _margin(world, clearance)
        n = len(margin)
        out = margin + sd * rng.standard_normal(n) >= 0
        out &= ~((margin >= 0) & (margin < strict) & (rng.random(n) < 0.5))
        return out ^ (rng.random(n) < flips)

    return judge


def _coin(share: float) -> Judge:
    return lambda world, rng: rng.random(len(world.scene)) < share


def _below(name: str, q: float = 0.55) -> Judge:
    return lambda world, _: world.shape[name] <= np.quantile(world.shape[name], q)


def _above(name: str, q: float = 0.45) -> Judge:
    return lambda world, _: world.shape[name] >= np.quantile(world.shape[name], q)


def _near(world: World, _: np.random.Generator) -> Bools:
    return world.distance[:, CLASSES.index("glass")] <= 8.0


def _sides(world: World, _: np.random.Generator) -> Bools:
    below, above = world.side[:, CLASSES.index("glass"), 2:].T
    return (below >= 14.0) & (above >= 2.0)


def _two_people(world: World, _: np.random.Generator) -> Bools:
    first = world.demonstrator == "person-0"
    one = _margin(world, {"glass": 9.0}) >= 0
    other = _margin(world, {"plate": 3.0, "bowl": 3.0}) >= 0
    return np.where(first, one, other)


def _two_unnamed(world: World, rng: np.random.Generator) -> Bools:
    """Whose answer each is, the set does not say: its demonstrators are others."""
    return _two_people(replace(world, demonstrator=rng.permutation(world.demonstrator)), rng)


def _demonstrator(world: World, rng: np.random.Generator) -> Bools:
    return (world.demonstrator == "person-0") ^ (rng.random(len(world.scene)) < 0.05)


def _order(world: World, _: np.random.Generator) -> Bools:
    early = np.arange(len(world.scene)) < len(world.scene) / 2
    margin = world.distance[:, CLASSES.index("glass")]
    return np.where(early, margin >= 2.0, margin >= 16.0)


def _place(world: World, _: np.random.Generator) -> Bools:
    return world.dense[:, :, 1].max(axis=1) <= np.quantile(world.dense[:, :, 1].max(axis=1), 0.5)


def _edge(world: World, _: np.random.Generator) -> Bools:
    y = world.dense[:, :, 1]
    return np.minimum(y, SIZE - y).min(axis=1) >= 12.0


def _crowd(world: World, _: np.random.Generator) -> Bools:
    near = np.array(
        [
            sum(
                np.linalg.norm(path - (x, y), axis=1).min() - r < 10.0
                for _, x, y, r in world.objects[j]
            )
            for path, j in zip(world.dense, world.scene, strict=True)
        ]
    )
    return near <= np.median(near)


def _hidden(world: World, _: np.random.Generator) -> Bools:
    return _margin(world, {"glass": 6.0}) >= 0


def _speed_near(world: World, _: np.random.Generator) -> Bools:
    close = world.distance[:, CLASSES.index("glass")] < 12.0
    return ~close | (world.shape["speed"] <= np.quantile(world.shape["speed"], 0.4))


KINDS: dict[str, Kind] = {
    "one class": Kind(_keeps(glass=6.0), "in", truth={"glass": 6.0}),
    "two classes": Kind(_keeps(glass=5.0, plate=5.0), "in", truth={"glass": 5.0, "plate": 5.0}),
    "every class": Kind(
        _keeps(**dict.fromkeys(CLASSES, 3.0)), "in", truth=dict.fromkeys(CLASSES, 3.0)
    ),
    "own clearances": Kind(_keeps(glass=9.0, bowl=3.0), "in", truth={"glass": 9.0, "bowl": 3.0}),
    "touching only": Kind(_keeps(plate=0.0, glass=0.0), "in", truth={"plate": 0.0, "glass": 0.0}),
    "sd 0.3": Kind(_noisy(sd=0.3, glass=7.0), "noisy", truth={"glass": 7.0}),
    "sd 1": Kind(_noisy(sd=1.0, glass=7.0), "noisy", truth={"glass": 7.0}),
    "sd 3": Kind(_noisy(sd=3.0, glass=8.0), "noisy", truth={"glass": 8.0}),
    "flips 5 %": Kind(_noisy(flips=0.05, glass=7.0), "noisy", truth={"glass": 7.0}),
    "flips 15 %": Kind(_noisy(flips=0.15, glass=7.0), "noisy", truth={"glass": 7.0}),
    "over-strict": Kind(_noisy(strict=3.0, glass=6.0), "noisy", truth={"glass": 6.0}),
    "coin 20 %": Kind(_coin(0.2), "coin"),
    "coin 35 %": Kind(_coin(0.35), "coin"),
    "coin 50 %": Kind(_coin(0.5), "coin"),
    "coin 65 %": Kind(_coin(0.65), "coin"),
    "coin 80 %": Kind(_coin(0.8), "coin"),
    "must come near": Kind(_near, "out", "near"),
    "speed": Kind(_below("speed"), "out", "speed"),
    "duration": Kind(_below("duration"), "out", "duration"),
    "length": Kind(_below("length"), "out", "length"),
    "curvature": Kind(_below("curvature"), "out", "curvature"),
    "height": Kind(_above("height"), "out", "height"),
    "tilt": Kind(_below("tilt"), "out", "tilt"),
    "one side": Kind(_sides, "out", "side"),
    "speed near glasses": Kind(_speed_near, "out", "speed"),
    "two people": Kind(_two_people, "out", "demonstrator"),
    "demonstrator": Kind(_demonstrator, "out", "demonstrator"),
    "changes their mind": Kind(_order, "out", "order"),
    "place on the table": Kind(_place, "out", "place"),
    "edge": Kind(_edge, "out", "place"),
    "crowd": Kind(_crowd, "out", "count"),
    "unlisted class": Kind(_hidden, "out", None, hidden=("glass",)),
    "two people, unnamed": Kind(_two_unnamed, "out", "two people"),
}


def sample(name: str, seed: int, scenes: int = 20, each: int = 10) -> DemonstrationSet:
    """One set of one kind of person."""
    kind = KINDS[name]
    rng = np.random.default_rng([seed, list(KINDS).index(name)])
    world = make_world(rng, scenes, each)
    return as_set(world, kind.judge(world, rng), kind)
