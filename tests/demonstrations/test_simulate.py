"""Simulated sets: known truth, base rates, determinism, options."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from demospec.demonstrations import (
    DemonstrationSet,
    fit_bezier,
    random_paths,
    read_set,
    simulate_set,
    true_clearances,
    write_set,
)
from demospec.demonstrations.simulation._truth import margins
from demospec.errors import InputError
from demospec.scene import STATISTICS, TASK_SYMBOLS, Polygon, draw_scene, load_catalogue


def segment_distance(p: np.ndarray, q: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(n, k) exact distance between path segments p–q (n, 2) and edges a–b (k, 2)."""

    def to(points: np.ndarray, s: np.ndarray, e: np.ndarray) -> np.ndarray:
        d = (e - s)[None]
        t = ((points[:, None] - s[None]) * d).sum(-1) / np.maximum((d**2).sum(-1), 1e-18)
        foot = s[None] + np.clip(t, 0, 1)[..., None] * d
        return np.asarray(np.linalg.norm(points[:, None] - foot, axis=-1))

    gap = np.minimum.reduce([to(p, a, b), to(q, a, b), to(a, p, q).T, to(b, p, q).T])

    def side(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> np.ndarray:
        return np.asarray(
            (v[..., 0] - u[..., 0]) * (w[..., 1] - u[..., 1])
            - (v[..., 1] - u[..., 1]) * (w[..., 0] - u[..., 0])
        )

    pp, qq, aa, bb = p[:, None], q[:, None], a[None], b[None]
    crosses = (side(pp, qq, aa) * side(pp, qq, bb) < 0) & (side(aa, bb, pp) * side(aa, bb, qq) < 0)
    return np.where(crosses, 0.0, gap)


def exact_clearance(path: np.ndarray, corners: np.ndarray) -> float:
    """Distance between a path and a polygon; 0 where they touch. Segment against segment."""
    edges = corners, np.roll(corners, -1, axis=0)
    return float(segment_distance(path[:-1], path[1:], *edges).min())


def polygon_of(thing: object) -> np.ndarray:
    shape = thing.outline  # type: ignore[attr-defined]
    assert isinstance(shape, Polygon)
    return np.asarray(shape.vertices)


@pytest.mark.parametrize("task", TASK_SYMBOLS)
def test_labels_equal_the_sign_of_an_exactly_recomputed_margin(task: str) -> None:
    data, truth = simulate_set(task, train_scenes=5, test_scenes=5, demonstrations=6, seed=3)
    checked = set()
    for demo in data.demonstrations:
        rule = truth["types"][demo.type]["clearance"]["value"]
        scene = data.scene(demo.scene_id)
        margin = min(
            (
                exact_clearance(demo.xy, polygon_of(thing)) - rule[thing.symbol]
                for thing in scene.listed_objects()
                if thing.symbol in rule
            ),
            default=np.inf,
        )
        assert demo.valid == (margin >= 0), demo.demo_id
        assert abs(margin) > 0.01
        checked.add((demo.type, demo.valid))
    assert len(checked) == 5  # aggressive is always valid


def test_margins_equal_the_exact_ones_near_the_boundary() -> None:
    rng = np.random.default_rng(0)
    for _ in range(10):
        scene = draw_scene(rng, load_catalogue("builtin", "train"))
        rule = dict.fromkeys(TASK_SYMBOLS["tabletop"], 3.0)
        paths = random_paths(rng, scene, 8)
        for path, got in zip(paths, margins(scene, paths, rule), strict=True):
            exact = min(exact_clearance(path, polygon_of(o)) for o in scene.listed_objects()) - 3.0
            if exact > -3.0:  # outside every footprint the exact distance is the signed one
                assert got == pytest.approx(exact, abs=1e-9)
            else:
                assert got <= -2.98


@pytest.mark.parametrize(
    ("task", "careful", "normal"), [("tabletop", 0.43, 0.62), ("workbench", 0.43, 0.62)]
)
def test_base_rates_of_random_paths_are_those_of_the_paper(
    task: str, careful: float, normal: float
) -> None:
    rates, watched = [], 0
    truth = true_clearances(task, 3.0)
    for part in ("train", "test"):
        rng = np.random.default_rng(17)
        catalogue = load_catalogue("builtin", part)  # type: ignore[arg-type]
        for _ in range(70):
            scene = draw_scene(rng, catalogue, task=task)
            paths = random_paths(rng, scene, 30, task=task)
            rates.append(
                [(margins(scene, paths, truth[t]) >= 0).mean() for t in ("careful", "normal")]
            )
            watched += any(o.symbol == STATISTICS[task].watched for o in scene.listed_objects())
    mean = np.mean(rates, axis=0)
    # 140 scenes: a standard error of 0.02
    np.testing.assert_allclose(mean, [careful, normal], atol=0.05)
    assert watched / 140 > 0.93


def test_tabletop_demonstrations_are_beziers_and_workbench_ones_are_not() -> None:
    def misfit(task: str) -> np.ndarray:
        data, _ = simulate_set(task, train_scenes=2, test_scenes=0, demonstrations=4)
        out = []
        for path in data.demonstrations.paths_xy():
            control = fit_bezier(path, 2)
            every = np.stack([path[0], control[0], path[-1]])
            t = np.linspace(0, 1, 2000)[:, None]
            curve = (1 - t) ** 2 * every[0] + 2 * t * (1 - t) * every[1] + t**2 * every[2]
            out.append(np.sqrt(((path[:, None] - curve) ** 2).sum(2)).min(1).max())
        return np.array(out)

    assert misfit("tabletop").max() < 0.1
    assert np.median(misfit("workbench")) > 1.0


def test_paths_start_at_the_start_and_end_at_the_goal() -> None:
    for task in TASK_SYMBOLS:
        data, _ = simulate_set(task, train_scenes=3, test_scenes=0, demonstrations=3)
        for demo in data.demonstrations:
            scene = data.scene(demo.scene_id)
            np.testing.assert_allclose(demo.xy[0], scene.start, atol=1e-9)
            np.testing.assert_allclose(demo.xy[-1], scene.goal, atol=1e-9)
            assert demo.t is not None
            assert (np.diff(demo.t) > 0).all()


def files_of(folder: Path) -> dict[str, bytes]:
    return {
        str(f.relative_to(folder)): f.read_bytes() for f in sorted(folder.rglob("*")) if f.is_file()
    }


def test_the_same_seed_gives_the_same_bytes(tmp_path: Path) -> None:
    for name, seed in (("a", 4), ("b", 4), ("c", 5)):
        data, truth = simulate_set(train_scenes=2, test_scenes=2, demonstrations=3, seed=seed)
        write_set(data, tmp_path / name, documents={"truth.json": truth})
    a, b, c = (files_of(tmp_path / name) for name in "abc")
    assert a == b
    assert a.keys() == c.keys()
    assert all(a[name] != c[name] for name in a if name.endswith((".png", ".parquet")))


def test_a_larger_set_begins_with_the_smaller_one() -> None:
    small, _ = simulate_set(train_scenes=2, test_scenes=0, demonstrations=3, seed=1)
    large, _ = simulate_set(train_scenes=4, test_scenes=2, demonstrations=3, seed=1)
    assert large.scenes[:2] == small.scenes
    assert large.demonstrations[: len(small.demonstrations)] == small.demonstrations


def test_counts_splits_and_items() -> None:
    data, _ = simulate_set(train_scenes=3, test_scenes=2, demonstrations=4, seed=2)
    assert [s.split for s in data.scenes] == ["train"] * 3 + ["test"] * 2
    assert len(data.demonstrations) == 5 * 3 * 4
    for scene in data.scenes:
        assert scene.recipe is not None
        items = scene.recipe.items
        assert all(scene.split in entry.item for entry in items.values())


def test_label_noise_flips_as_many_as_it_says_and_says_which() -> None:
    clean, _ = simulate_set(train_scenes=3, test_scenes=0, demonstrations=10, seed=6)
    noisy, truth = simulate_set(
        train_scenes=3, test_scenes=0, demonstrations=10, seed=6, label_noise=0.1
    )
    differ = clean.demonstrations.valid != noisy.demonstrations.valid
    assert differ.sum() == 9
    assert list(clean.demonstrations.demo_id[differ]) == truth["flipped"]
    assert np.array_equal(clean.demonstrations.flat, noisy.demonstrations.flat)


def test_unlisted_test_scenes_tell_nothing_about_their_objects(tmp_path: Path) -> None:
    hidden, _ = simulate_set(train_scenes=1, test_scenes=2, demonstrations=2, test_objects=False)
    listed, _ = simulate_set(train_scenes=1, test_scenes=2, demonstrations=2)
    for a, b in zip(hidden.scenes[1:], listed.scenes[1:], strict=True):
        assert a.objects is None
        assert a.recipe is None
        assert a.picture == b.picture
    assert hidden.demonstrations == listed.demonstrations
    write_set(hidden, tmp_path / "set")
    text = (tmp_path / "set" / "scenes" / "metadata.jsonl").read_text().splitlines()[1]
    assert "glass" not in text


def test_balanced_sampling_gives_both_labels_where_there_are_both() -> None:
    data, _ = simulate_set(train_scenes=6, test_scenes=0, demonstrations=8, seed=1, balanced=True)
    d = data.demonstrations
    halves = []
    for scene in data.scenes:
        for type_ in ("careful", "normal"):
            valid = d.valid[(d.scene_id == scene.scene_id) & (d.type == type_)]
            assert len(valid) == 8
            halves.append(int((valid == 1).sum()))
    assert np.median(halves) == 4
    assert (d.valid[d.type == "aggressive"] == 1).all()


def test_size_scales_everything() -> None:
    small, a = simulate_set(train_scenes=1, test_scenes=0, demonstrations=2, size_px=100)
    large, b = simulate_set(train_scenes=1, test_scenes=0, demonstrations=2, size_px=200)
    assert large.scenes[0].size_px == (200, 200)
    assert large.metres_per_unit == pytest.approx(0.0041)
    assert b["types"]["normal"]["clearance"]["value"]["glass"] == pytest.approx(
        2 * a["types"]["normal"]["clearance"]["value"]["glass"]
    )
    assert large.scenes[0].goal == (180.0, 20.0)
    assert len(small.demonstrations) == len(large.demonstrations)


def test_the_truth_is_a_rule_that_agrees_with_every_label(tmp_path: Path) -> None:
    from demospec.files import write_json
    from demospec.rules import read_rules

    data, truth = simulate_set(train_scenes=4, test_scenes=2, demonstrations=6, seed=9)
    write_json(tmp_path / "truth.json", truth)
    rules = read_rules(tmp_path / "truth.json")
    d = data.demonstrations
    for scene_id, rows in data.rows_by_scene().items():
        view = rules.see(data.scene(scene_id))
        for type_ in data.types:
            chosen = [int(i) for i in rows if d.type[i] == type_]
            p = view.p_valid(d.paths_xy(chosen), type_)
            assert ((p > 0.5) == (d.valid[chosen] == 1)).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"task": "kitchen"}, "one of the tasks tabletop, workbench"),
        ({"catalogue": "ikea"}, "a catalogue"),
        ({"train_scenes": 0, "test_scenes": 0}, "train_scenes"),
        ({"train_scenes": -1}, "train_scenes"),
        ({"demonstrations": 0}, "demonstrations"),
        ({"size_px": 8}, "size_px"),
        ({"label_noise": 0.7}, "label_noise"),
        ({"label_noise": float("nan")}, "label_noise"),
        ({"clearance_px": -1.0}, "clearance_px"),
        ({"clearance_px": float("inf")}, "clearance_px"),
    ],
)
def test_nonsense_is_refused_in_one_line(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        simulate_set(**arguments)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def test_a_set_of_real_models_credits_their_makers(tmp_path: Path) -> None:
    from demospec.errors import MissingPackageError

    try:
        data, _ = simulate_set(
            catalogue="sweethome3d", train_scenes=1, test_scenes=1, demonstrations=2
        )
    except MissingPackageError as error:
        pytest.skip(str(error))
    write_set(data, tmp_path / "set")
    back: DemonstrationSet = read_set(tmp_path / "set")
    credit = dict(back.extra)["attribution"]
    named = {row["item"] for row in credit}
    used = {e.item for s in back.scenes if s.recipe for e in s.recipe.items.values()}
    assert used <= named
    assert all(row["creator"] and row["licence"] for row in credit)
