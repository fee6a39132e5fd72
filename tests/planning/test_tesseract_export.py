"""The export to Tesseract: its own contact check finds what the rule forbids."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from demospec.geometry import Polygon
from demospec.planning import ExportRequest, export_request, export_to
from demospec.planning.exports._tesseract import _convex_pieces
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Capsule, Disc, Scene, SceneObject

HERE = Path(__file__).parent
OWN = HERE.parents[1] / ".venv-tesseract" / "bin" / "python"


@pytest.fixture(scope="module")
def asked() -> ExportRequest:
    rules = RuleSet(
        {"careful": TypeRules(ClearanceRule({"glass": 0.05, "bowl": 0.03, "utensil": 0.02}))},
        units="m",
    )
    bowl = Polygon([[0.62, 0.55], [0.78, 0.54], [0.80, 0.66], [0.70, 0.60], [0.63, 0.67]])
    objects = (
        SceneObject('glass <1> & "2"', "glass", (0.45, 0.42), None, Disc((0.45, 0.42), 0.06)),
        SceneObject("tool", "bowl", (0.7, 0.6), None, bowl),
        SceneObject(
            "fork.1", "utensil", (0.2, 0.2), None, Capsule((0.14, 0.16), (0.28, 0.25), 0.015)
        ),
    )
    return export_request(rules, Scene("0007", (0.1, 0.7), (0.9, 0.1), objects), "careful")


def link_of(zone_id: str) -> str:
    return "object_tool" if zone_id == "tool" else zone_id


def test_margins_of_pairs_are_the_clearances_less_the_ball(
    asked: ExportRequest, tmp_path: Path
) -> None:
    export_to(asked, "tesseract", tmp_path / "t")
    package = tmp_path / "t" / "demospec_table"
    robot = ET.parse(package / "table.urdf").getroot()
    (ball,) = robot.iter("sphere")
    links = {link.get("name") for link in robot.iter("link")}
    said = {
        pair.get("link2"): float(str(pair.get("margin")))
        for pair in ET.parse(package / "table.srdf").getroot().iter("pair_margin")
    }
    assert len(said) == len(asked.cost_map.zones) == 3
    for zone in asked.cost_map.zones:
        name = link_of(zone.object_id)
        assert name in links
        assert said[name] + float(str(ball.get("radius"))) == pytest.approx(zone.radius)
    for mesh in robot.iter("mesh"):
        assert (tmp_path / "t" / str(mesh.get("filename")).removeprefix("package://")).is_file()


@pytest.mark.parametrize("seed", range(40))
def test_pieces_are_convex_and_make_up_the_outline(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 40))
    angle = (np.arange(count) + rng.uniform(0, 0.9, count)) * 2 * np.pi / count
    outline = np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(0.3, 1, (count, 1))
    pieces = _convex_pieces(outline[:: int(rng.choice([-1, 1]))])
    points = rng.uniform(-1, 1, (500, 2))
    inside = np.zeros(len(points), dtype=int)
    for piece in pieces:
        way = np.roll(piece, -1, axis=0) - piece
        turn = way[:, 0] * np.roll(way[:, 1], -1) - way[:, 1] * np.roll(way[:, 0], -1)
        assert (turn >= -1e-12).all()
        inside += Polygon(piece).contains(points)
    np.testing.assert_array_equal(inside, Polygon(outline).contains(points).astype(int))


def python_with_tesseract() -> str | None:
    if importlib.util.find_spec("tesseract_robotics"):
        return sys.executable
    return str(OWN) if OWN.exists() else None


def test_its_contact_check_agrees_on_ten_thousand_places(
    asked: ExportRequest, tmp_path: Path
) -> None:
    python = python_with_tesseract()
    if python is None:
        pytest.skip("make tesseract")
    export_to(asked, "tesseract", tmp_path / "t")
    xy = np.random.default_rng(0).uniform(0, 0.9, (10_000, 2))
    places = np.column_stack([xy, np.full(len(xy), 0.15)]).tolist()
    run = subprocess.run(
        [python, str(HERE / "tesseract_contacts.py"), str(tmp_path / "t")],
        input=json.dumps(places), capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    said = json.loads(run.stdout.splitlines()[-1])
    for zone in asked.cost_map.zones:
        name = link_of(zone.object_id)
        gap = zone.shape.signed_distance(xy)
        ball = zone.radius - said["margins"][name]
        theirs = np.array([d[name] for d in said["distances"]]) + ball
        outside = gap > 0
        assert np.abs(theirs - gap)[outside].max() < 1e-3
        assert (theirs[~outside] < ball + 1e-6).all()
        contact = np.array([name in c for c in said["contacts"]])
        sure = np.abs(gap - zone.radius) > 1e-3
        np.testing.assert_array_equal(contact[sure], (gap < zone.radius)[sure])
        assert contact.any()
        assert not contact.all()
