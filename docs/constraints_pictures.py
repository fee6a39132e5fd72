"""Draws docs/images/constraints/: of each constraint a path that keeps it and one that does not.

python docs/constraints_pictures.py
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from demospec.rules import Constraint, When, constraint_words, worst
from demospec.scene import Disc, Relation, Scene, SceneObject

TARGET = Path(__file__).parent / "images" / "constraints"
KEPT, BROKEN, ZONE, THING = "#1b7f5c", "#c0392b", "#f3c6bf", "#8a9ba8"
SCALE = 0.01  # one unit is a centimetre
COLUMNS = ("x", "y", "z", "tilt")


def thing(id: str, symbol: str, x: float, y: float, r: float, heading: float = 0.0) -> SceneObject:
    return SceneObject(id, symbol, (x, y), None, Disc((x, y), r), heading, (0.0, 8.0))


SCENE = Scene(
    "table", (5.0, 50.0), (95.0, 50.0),
    (thing("person-0", "person", 35.0, 62.0, 6.0, -60.0),
     thing("person-1", "person", 70.0, 30.0, 6.0, 130.0),
     thing("laptop-0", "laptop", 52.0, 50.0, 9.0)),
    relations=(Relation("talk", ("person-0", "person-1")),),
    extra=(("regions", {"table": [[0, 0], [100, 0], [100, 100], [0, 100]],
                        "tray": [[40, 66], [66, 66], [66, 92], [40, 92]]}),),
)  # fmt: skip


def path(bend: float, height: float = 12.0, tilt: float = 5.0, pace: float = 20.0) -> np.ndarray:
    """(n, 5): x, y, z, tilt and seconds of a path over (y > 50) or under the middle."""
    u = np.linspace(0.0, 1.0, 9)
    x, y = 5 + 90 * u, 50 + bend * np.sin(np.pi * u)
    step = np.hypot(np.diff(x), np.diff(y))
    t = np.concatenate([[0.0], np.cumsum(step / pace)])
    return np.column_stack([x, y, np.full(9, height), tilt * np.sin(np.pi * u), t])


C = Constraint
CASES: dict[str, tuple[Constraint, np.ndarray, np.ndarray]] = {
    "distance": (C("distance", "person", value=14, sector="front"), path(44), path(-4)),
    "near": (C("near", "laptop", "at_most", 4), path(6), path(44)),
    "between": (C("between", "talk", value=6), path(46), path(-4)),
    "height": (C("height", value=10), path(40, 14), path(-40, 4)),
    "height_over": (C("height_over", "laptop", value=10), path(2, 20), path(-2, 12)),
    "tilt": (C("tilt", None, "at_most", 12, unit="deg"), path(40, tilt=8), path(-40, tilt=30)),
    "speed": (C("speed", None, "at_most", 25, unit="px/s", when=When(20, "person")),
              path(-6, pace=18), path(2, pace=41)),
    "dwell": (C("dwell", "person", "at_most", 1.5, unit="s", when=When(15, "person")),
              path(46, pace=60), path(4, pace=12)),
    "length": (C("length", None, "at_most", 100), path(8), path(42)),
    "duration": (C("duration", None, "at_most", 6, unit="s"), path(8, pace=25), path(8, pace=9)),
    "curvature": (C("curvature", None, "at_most", 60, unit="deg"), path(8), path(40)),
    "edge": (C("edge", value=4.5), path(6), path(49)),
    "region": (C("region", "tray"), path(-8), path(32)),
}  # fmt: skip


def zone(ax: Axes, c: Constraint) -> None:
    """What the constraint forbids, or where it counts."""
    discs = {o.id: o for o in SCENE.objects or ()}
    if c.feature == "distance":
        for o in discs.values():
            if o.symbol == c.of:
                ahead = o.heading_deg or 0.0
                radius = 6.0 + c.value
                ax.add_patch(plt.matplotlib.patches.Wedge(o.center, radius, ahead - 90, ahead + 90,
                                                          color=ZONE))  # fmt: skip
                tip = np.radians(ahead)
                ax.arrow(*o.center, 8 * np.cos(tip), 8 * np.sin(tip), head_width=2.5, color="k",
                         zorder=5)  # fmt: skip
    elif c.feature in ("near", "speed", "dwell"):
        of, r = (c.when.of, c.when.within) if c.when else (c.of, c.value)
        for o in discs.values():
            if o.symbol == of:
                radius = o.outline_radius + r
                ax.add_patch(plt.Circle(o.center, radius, color="#dfe8f5" if c.when else "#d7efe5"))
    elif c.feature == "between":
        a, b = (np.array(discs[i].center) for i in ("person-0", "person-1"))
        ax.plot(*np.stack([a, b]).T, color=ZONE, lw=26, solid_capstyle="round", zorder=0)
    elif c.feature == "height_over":
        ax.add_patch(plt.Circle(discs["laptop-0"].center, 9, color=ZONE, zorder=2))
    elif c.feature == "edge":
        ax.add_patch(plt.Rectangle((0, 0), 100, 100, color=ZONE))
        ax.add_patch(plt.Rectangle((c.value,) * 2, 100 - 2 * c.value, 100 - 2 * c.value, color="w"))
    elif c.feature == "region":
        ax.add_patch(plt.Polygon(dict(SCENE.extra)["regions"]["tray"], color=ZONE))


def draw(name: str, c: Constraint, good: np.ndarray, bad: np.ndarray) -> str:
    """One picture; the sentence of its constraint."""
    found = [worst(c, SCENE, p[:, :4], p[:, 4], COLUMNS) for p in (good, bad)]
    assert found[0].margin >= 0 > found[1].margin, (name, [f.margin for f in found])
    fig, ax = plt.subplots(figsize=(2.5, 2.5), layout="constrained")
    zone(ax, c)
    for o in SCENE.objects or ():
        ax.add_patch(plt.Circle(o.center, o.outline_radius, color=THING, zorder=1))
        ax.annotate(o.symbol, o.center, ha="center", va="center", fontsize=6, zorder=6)
    for p, colour in ((good, KEPT), (bad, BROKEN)):
        ax.plot(p[:, 0], p[:, 1], color=colour, lw=1.8, marker=".", ms=4, zorder=4)
    place = found[1].point
    if place is not None:
        ax.plot(*place, marker="x", color=BROKEN, ms=9, mew=2, zorder=7)
    for p, one, colour in ((good, found[0], KEPT), (bad, found[1], BROKEN)):
        unit = {"deg": "°", "px": " cm", "px/s": " cm/s"}.get(c.unit, f" {c.unit}")
        text = "never" if not np.isfinite(one.value) else f"{one.value:.3g}{unit}"
        at = p[4, :2] + (0, 3.0 if p[4, 1] < 90 else -7.0)
        ax.annotate(text, at, color=colour, fontsize=7, ha="center", zorder=8)
    ax.set(xlim=(-1, 101), ylim=(-1, 101), aspect="equal", xticks=[], yticks=[])
    fig.savefig(TARGET / f"{name}.png", dpi=90)
    plt.close(fig)
    return constraint_words(replace(c), "px", SCALE)


if __name__ == "__main__":
    for name, case in CASES.items():
        print(f"{name}: {draw(name, *case)}")
