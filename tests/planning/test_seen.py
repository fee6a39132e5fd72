"""Planning with a model that sees: exact where the scene is listed, its own opinion where not."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from demospec.errors import InputError
from demospec.planning import check_plan, plan_path
from demospec.planning._seen import SeenOutline
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Disc, Picture, Scene, SceneObject

PICTURE = Picture(array=np.zeros((100, 100, 3), dtype=np.uint8))
GLASS = Disc((48.0, 53.0), 7.0)
LISTED = (SceneObject("g", "glass", GLASS.center, None, GLASS),)
SCENE = Scene("s", (10.0, 90.0), (90.0, 10.0), LISTED, PICTURE)


@dataclass(frozen=True)
class Part:
    distance: np.ndarray
    classes: dict[str, float]
    error: float
    center: tuple[float, float]


class Model:
    """Sees one thing, through an exact distance map on a 100 × 100 grid."""

    types = ("careful",)

    def __init__(self, classes: dict[str, float]) -> None:
        rule = ClearanceRule({"glass": 4.0}, {"glass": (3.4, 4.6)})
        self.rules = RuleSet({"careful": TypeRules(rule)})
        self.classes = classes

    def see(self, scene: Scene) -> object:
        at = np.stack(np.meshgrid(np.arange(100) + 0.5, np.arange(100) + 0.5), axis=-1)
        part = Part(GLASS.signed_distance(at), self.classes, 0.4, GLASS.center)

        @dataclass(frozen=True)
        class View:
            perceived: tuple[Part, ...] = (part,)
            size: tuple[float, float] = (100.0, 100.0)

            def relevance(self, type: str) -> list[tuple[Part, float, float, float]]:
                return [(part, part.classes["glass"], 4.0, 0.3)]

        return View()


def test_outline_interpolates_its_map() -> None:
    part = Model({"glass": 1.0}).see(SCENE).perceived[0]  # type: ignore[attr-defined]
    seen = SeenOutline(part.distance, (100.0, 100.0))
    p = np.random.default_rng(0).uniform(0, 100, (500, 2))
    p = p[np.hypot(*(p - GLASS.center).T) > 2]  # bilinear blurs the tip of the cone
    inner = ((p > 0.5) & (p < 99.5)).all(axis=1)
    assert np.abs(seen.signed_distance(p) - GLASS.signed_distance(p))[inner].max() < 0.06
    assert seen.bounds == pytest.approx(GLASS.bounds, abs=1.0)


def test_unlisted_scene_is_planned_by_sight_and_says_so() -> None:
    model = Model({"glass": 0.9, "plate": 0.1})
    plan = plan_path(model, replace(SCENE, objects=None), "careful")
    assert plan.found
    assert plan.judged_by == "model"
    assert plan.to_json()["judged_by"] == "model"
    truth = RuleSet({"careful": TypeRules(ClearanceRule({"glass": 4.0}))})
    check = check_plan(truth, SCENE, plan.points)
    assert check.obeys
    assert check.margin == pytest.approx(2 * np.hypot(0.3, 0.4), abs=0.2)  # the upper end


def test_listed_scene_is_judged_by_the_rule() -> None:
    plan = plan_path(Model({"glass": 1.0}), SCENE)
    assert plan.judged_by == "rule"
    assert plan.check.clearance["g"] == pytest.approx(4.6, abs=0.1)


def test_what_probably_does_not_matter_is_ignored() -> None:
    plan = plan_path(Model({"plate": 0.8, "glass": 0.2}), replace(SCENE, objects=None), "careful")
    assert plan.length == pytest.approx(np.hypot(80, 80))


def test_a_model_without_parts_is_refused() -> None:
    model = Model({"glass": 1.0})
    model.see = lambda scene: object()  # type: ignore[method-assign]
    with pytest.raises(InputError, match="model: expected a model that sees objects"):
        plan_path(model, replace(SCENE, objects=None), "careful")
