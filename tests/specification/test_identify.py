"""Identification: who normalises finds the careful, who only sums elects the lenient."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from demospec.demonstrations import Demonstration, Demonstrations, DemonstrationSet
from demospec.specification import ControlPlane, identify
from demospec.specification.evaluation import acceptances, clusters, type_posterior
from demospec.testing import DiscModel, disc_scene

MODEL = DiscModel(5.0)


def shown(
    rng: np.random.Generator, accepts: dict[str, str], n: int, *, left_only: tuple[str, ...] = ()
) -> DemonstrationSet:
    """Demonstrators who show n paths that their type accepts, without labels and types."""
    scenes = tuple(
        replace(
            disc_scene(*((*rng.uniform(25, 75, 2), rng.uniform(6, 12)) for _ in range(2))),
            scene_id=str(i),
        )
        for i in range(4)
    )
    items = []
    for name, type_ in accepts.items():
        for k in range(n):
            scene = scenes[k % len(scenes)]
            view = MODEL.see(scene)
            plane = ControlPlane(view)
            while True:
                z = rng.uniform(-20, 120, (1, 1, 2))
                if name in left_only and z.sum() > 100:
                    continue
                if plane.logits(z, type_)[0] > 0:
                    break
            items.append(
                Demonstration(f"{name}-{k}", scene.scene_id, plane.paths(z)[0], None, name, None)
            )
    return DemonstrationSet(
        scenes, Demonstrations.of(items), types=("careful", "bold"), symbols=("glass",)
    )


def test_types_are_found_from_unlabelled_demonstrations():
    rng = np.random.default_rng(0)
    right = 0
    for _ in range(6):
        data = shown(rng, {"anna": "careful", "ben": "bold"}, 20)
        found = {d.demonstrator: d for d in identify(MODEL, data).demonstrators}
        right += (found["anna"].type == "careful") + (found["ben"].type == "bold")
        for d in found.values():
            assert abs(sum(d.posterior.values()) - 1) < 1e-9
    assert right >= 11


def test_the_plain_sum_would_elect_whoever_accepts_everything():
    data = shown(np.random.default_rng(1), {"anna": "careful"}, 12)
    found, _, _ = acceptances(MODEL, data)
    plain = np.log(np.clip(found.c, 0.02, 0.98)).sum(axis=0)
    assert plain[0] == plain[1]  # a tie at best: the careful one never wins
    assert type_posterior(found)[0] > 0.9


def test_types_of_the_set_are_never_read():
    data = shown(np.random.default_rng(2), {"anna": "careful", "ben": "bold"}, 8)
    lied = data.demonstrations.rows(np.arange(len(data.demonstrations)))
    lied.type = np.array(["bold"] * len(lied), dtype=object)
    assert identify(MODEL, data) == identify(MODEL, replace(data, demonstrations=lied))


def test_rejections_say_more_than_paths():
    rng = np.random.default_rng(3)
    data = shown(rng, {"anna": "bold"}, 12)
    d = data.demonstrations.rows(np.arange(12))
    views = {s.scene_id: MODEL.see(s) for s in data.scenes}
    d.valid = np.array(
        [int(views[i.scene_id].p_valid(i.points[None], "careful")[0]) for i in d], np.int8
    )
    assert (d.valid == 0).any()
    (found,) = identify(MODEL, replace(data, demonstrations=d)).demonstrators
    assert found.type == "careful"
    assert found.posterior["careful"] > 0.99


def test_nobody_is_forced_into_a_type_and_strangers_are_grouped():
    # "avoider" keeps twice the distance from one side only: neither careful nor bold explains it.
    rng = np.random.default_rng(4)
    scenes = tuple(replace(disc_scene((50, 50, 12)), scene_id=str(i)) for i in range(4))
    items = []
    for name in ("x", "y"):
        for k in range(60):
            view = MODEL.see(scenes[k % 4])
            plane = ControlPlane(view)
            # Seeks the object: passes it closer than careful accepts, every time.
            while True:
                z = rng.uniform(-20, 120, (1, 1, 2))
                if plane.logits(z, "careful")[0] <= 0:
                    break
            items.append(Demonstration(f"{name}{k}", str(k % 4), plane.paths(z)[0], None, name))
    data = DemonstrationSet(
        scenes, Demonstrations.of(items), types=("careful", "bold"), symbols=("glass",)
    )
    found = identify(MODEL, data).demonstrators
    assert [d.type for d in found] == [None, None]
    assert all(d.none_of_these and d.surprise < 1e-3 for d in found)
    assert [d.cluster for d in found] == [0, 0]


def test_false_alarms_are_rare():
    rng = np.random.default_rng(5)
    alarms = 0
    for _ in range(15):
        data = shown(rng, {"anna": "careful", "ben": "bold"}, 16)
        alarms += sum(d.none_of_these for d in identify(MODEL, data).demonstrators)
    assert alarms <= 1


def test_clusters_are_numbered_by_first_appearance():
    profiles = np.array([[0.0, 0.0], [0.9, 0.9], [0.02, 0.0], [0.9, 0.88]])
    assert clusters(profiles) == [0, 1, 0, 1]
    assert clusters(profiles[:1]) == [0]
