"""Exports with headers of several lines: Motive, DeepLabCut, Tracker, Kinovea."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from demospec.demonstrations.readers import Mapping, read_source
from demospec.errors import InputError


def read(tmp_path: Path, text: str | bytes, name: str = "take.csv", **given: object) -> Any:
    file = tmp_path / name
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_source(file, mapping=Mapping.model_validate(given))


def motive(
    bodies: list[tuple[str, str]], unit: str = "Millimeters", rotation: str = "Quaternion"
) -> str:
    """A Motive export with these (type, name): body k at x = 100 k + 10 i, y = 500, z = 20 i mm."""
    head = (
        f"Format Version,1.23,Take Name,T 1,Capture Frame Rate,120.000000,Rotation Type,{rotation},"
        f"Length Units,{unit},Coordinate Space,Global"
    )
    rows: dict[str, list[str]] = {k: ["", k] for k in ("Type", "Name", "ID")}
    kinds, axes = ["", ""], ["Frame", "Time (Seconds)"]
    for kind, name in bodies:
        turned = kind == "Rigid Body"
        width = 7 if turned else 3
        for key, value in (("Type", kind), ("Name", name), ("ID", "1A2B")):
            rows[key] += [value] * width
        kinds += (["Rotation"] * 4 if turned else []) + ["Position"] * 3
        axes += (["X", "Y", "Z", "W"] if turned else []) + ["X", "Y", "Z"]
    lines = [head, "", *(",".join(r) for r in rows.values()), ",".join(kinds), ",".join(axes)]
    for i in range(4):
        cells = [str(i), f"{i / 120:.6f}"]
        for k, (kind, _) in enumerate(bodies):
            # A quarter turn about y: what pointed along z then points along x.
            cells += ["0.000000", "0.707107", "0.000000", "0.707107"] * (kind == "Rigid Body")
            cells += [f"{100 * k + 10 * i:.6f}", "500.000000", f"{20 * i:.6f}"]
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


TOOL = [("Rigid Body", "tool"), ("Rigid Body Marker", "tool:1")]


def test_motive_reads_the_only_rigid_body_in_the_plane_that_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--plane zx"):
        read(tmp_path, motive(TOOL))
    result = read(tmp_path, motive(TOOL), projection={"plane": "zx"})
    data, item = result.data, result.data.demonstrations[0]
    assert data.columns == ("x", "y", "z", "qx", "qy", "qz", "qw")
    assert data.units == "m"
    # z of Motive is x here, x is y, and its y the height: seen from above, not mirrored.
    np.testing.assert_allclose(item.points[3, :3], [0.06, 0.03, 0.5], atol=1e-12)
    assert item.t is not None
    np.testing.assert_allclose(item.t, np.arange(4) / 120, atol=1e-6)
    assert any("body: tool; not read: tool:1" in n for n in result.notes)


def test_motive_orientation_turns_with_the_plane(tmp_path: Path) -> None:
    from scipy.spatial.transform import Rotation

    item = read(tmp_path, motive(TOOL), projection={"plane": "zx"}).data.demonstrations[0]
    # In Motive's axes the tool's z axis points along x; in the plane (z, x, y) that is along y.
    turned = Rotation.from_quat(item.points[0, 3:])
    np.testing.assert_allclose(turned.apply([0, 0, 1]), [0, 1, 0], atol=1e-6)


def test_motive_with_several_bodies_or_units(tmp_path: Path) -> None:
    two = [("Rigid Body", "tool"), ("Rigid Body", "glass"), ("Marker", "m1")]
    plane = {"plane": "zx"}
    with pytest.raises(InputError, match="tool, glass"):
        read(tmp_path, motive(two), projection=plane)
    item = read(tmp_path, motive(two), projection=plane, path="glass").data.demonstrations[0]
    np.testing.assert_allclose(item.points[0, :3], [0, 0.1, 0.5])
    marker = read(tmp_path, motive(two), projection=plane, path="m1").data
    assert marker.columns == ("x", "y", "z")
    metres = read(tmp_path, motive(TOOL, "Meters"), projection=plane).data
    np.testing.assert_allclose(metres.demonstrations[0].points[3, :3], [60, 30, 500])
    for wrong, words in (
        (motive(TOOL, "Furlongs"), "Length Units"),
        (motive(TOOL).replace("Space,Global", "Space,Local"), "Coordinate Space Global"),
        (motive([*TOOL, TOOL[0]]), "tool twice"),
    ):
        with pytest.raises(InputError, match=words):
            read(tmp_path, wrong, projection=plane)


def test_motive_in_utf_16_with_euler_angles_and_occlusions(tmp_path: Path) -> None:
    text = motive(TOOL, rotation="XYZ").encode("utf-16")
    assert read(tmp_path, text, projection={"plane": "zx"}).data.columns == ("x", "y", "z")
    lost = motive([("Marker", "m1")]).replace("10.000000,500.000000,20.000000", ",,")
    with pytest.raises(InputError, match=r"line 9, x: .*--drop-missing"):
        read(tmp_path, lost, projection={"plane": "zx"})
    kept = read(tmp_path, lost, projection={"plane": "zx"}, drop_missing=True).data
    assert len(kept.demonstrations[0].points) == 3


DLC = """scorer,net,net,net,net,net,net
bodyparts,hand,hand,hand,cup,cup,cup
coords,x,y,likelihood,x,y,likelihood
0,10.5,20,0.99,300,100,1
1,11.5,21,0.30,300,100,1
2,12.5,22,0.98,300,100,1
"""


def test_deeplabcut(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="hand, cup"):
        read(tmp_path, DLC)
    result = read(tmp_path, DLC, path="hand")
    assert result.data.demonstrations[0].points.tolist() == [[10.5, 20], [11.5, 21], [12.5, 22]]
    assert result.data.units == "px"
    assert any("below 0.6 in 1 of 3 points" in n for n in result.notes)
    assert result.reading.frame.how == "as the columns state"
    with pytest.raises(InputError, match="a body part foot"):
        read(tmp_path, DLC, path="foot")


def test_deeplabcut_with_several_animals(tmp_path: Path) -> None:
    lines = DLC.splitlines()
    text = "\n".join([lines[0], "individuals,a,a,a,b,b,b", *lines[1:]]).replace("cup", "hand")
    with pytest.raises(InputError, match="a/hand, b/hand"):
        read(tmp_path, text)
    data = read(tmp_path, text, path="b/hand").data
    assert data.demonstrations[0].points[0].tolist() == [300, 100]
    with pytest.raises(InputError, match="each body part once"):
        read(tmp_path, DLC.replace("cup", "hand"), path="hand")
    with pytest.raises(InputError, match="line 5, x"):
        read(tmp_path, DLC.replace("11.5", ""), path="hand")
    with pytest.raises(InputError, match="the unit that the columns state"):
        read(tmp_path, DLC, path="hand", units="mm")


TRACKER = "mass_A\nt\tx\ty\tv_{x}\n0.0E0\t1.0E-1\t2.0E-1\t\n4.0E-2\t1.5E-1\t2.5E-1\t1.2\n"


def test_tracker(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--units"):
        read(tmp_path, TRACKER, "a.txt")
    data = read(tmp_path, TRACKER, "a.txt", units="m").data
    assert data.demonstrations[0].points.tolist() == [[0.1, 0.2], [0.15, 0.25]]
    assert data.demonstrations[0].t is not None
    assert data.demonstrations[0].t.tolist() == [0, 0.04]
    comma = TRACKER.replace(".", ",")
    again = read(tmp_path, comma, "a.txt", units="m").data
    assert again.demonstrations[0].points.tolist() == [[0.1, 0.2], [0.15, 0.25]]


def test_tracker_with_several_masses(tmp_path: Path) -> None:
    text = "#multi:\n\tcup\t\thand\t\t\nt\tx\ty\tx\ty\t\n0.0\t1\t2\t3\t4\t\n0.1\t1\t2\t5\t6\t\n"
    with pytest.raises(InputError, match="cup, hand"):
        read(tmp_path, text, "a.txt", units="cm")
    data = read(tmp_path, text, "a.txt", units="cm", path="hand").data
    np.testing.assert_allclose(data.demonstrations[0].points, [[0.03, 0.04], [0.05, 0.06]])


KINOVEA = """#Kinovea Trajectory data export
#T X Y

# reach
0 866,00 320,00
40 847,00 321,50
80 800,00 330,00

# retreat
0 118,00 45,00
40 131,00 37,00

"""


def test_kinovea_text(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--units"):
        read(tmp_path, KINOVEA, "a.txt")
    data = read(tmp_path, KINOVEA, "a.txt", units="px").data
    assert [d.demo_id for d in data.demonstrations] == ["a-reach", "a-retreat"]
    assert data.demonstrations[0].points[1].tolist() == [847, 321.5]
    assert data.demonstrations[0].t is not None
    np.testing.assert_allclose(data.demonstrations[0].t, [0, 0.04, 0.08])  # milliseconds, found
    with pytest.raises(InputError, match="line 6, x"):
        read(tmp_path, KINOVEA.replace("847,00", "8a7"), "a.txt", units="px")
    codes = (
        KINOVEA.replace("\n0 ", "\n0:00:00:00 ")
        .replace("\n40 ", "\n0:00:00:04 ")
        .replace("\n80 ", "\n0:00:00:08 ")
    )
    coded = read(tmp_path, codes, "a.txt", units="px")
    assert coded.data.demonstrations[0].t is None
    assert any("time codes" in n for n in coded.notes)


def test_kinovea_csv(tmp_path: Path) -> None:
    one = "Time (ms),X (px),Y (px)\n0,1.5,2\n40,3,4\n"
    data = read(tmp_path, one).data
    assert data.demonstrations[0].points.tolist() == [[1.5, 2], [3, 4]]
    np.testing.assert_allclose(data.demonstrations[0].t, [0, 0.04])
    two = '"Time";"hand/0/X";"hand/0/Y";"cup/0/X";"cup/0/Y"\n0;1,5;2;9;9\n40;3,0;4;9;9\n'
    with pytest.raises(InputError, match="one column for x"):
        read(tmp_path, two)
    data = read(tmp_path, two, path="hand/0").data
    assert data.demonstrations[0].points.tolist() == [[1.5, 2], [3, 4]]


def test_a_plain_table_is_not_taken_for_an_export(tmp_path: Path) -> None:
    """A title of one word above a table without a time column stays a fault of the table."""
    with pytest.raises(InputError, match="--skip-rows"):
        read(tmp_path, "title\nx,y\n1,2\n3,4\n")
