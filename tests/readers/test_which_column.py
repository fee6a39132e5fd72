"""Which column is what: one reading, or a refusal that names the cell or lists the columns."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from demospec.demonstrations import DemonstrationSet
from demospec.demonstrations.readers import Mapping, read_source
from demospec.errors import InputError


def read(tmp_path: Path, text: str | bytes, name: str = "a.csv", **given: object) -> Any:
    file = tmp_path / name
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_source(file, mapping=Mapping.model_validate(given))


def points(data: DemonstrationSet) -> list[list[float]]:
    return [[round(v, 9) for v in p] for p in data.demonstrations[0].points.tolist()]


SAME = [[1.5, 2.0], [3.0, 4.0], [7.0, 5.0]]
"""What each of the tables below says."""

READ: dict[str, str] = {
    "index before": ",x,y\n0,1.5,2\n1,3,4\n2,7,5\n",
    "pandas without names": "0,1\n1.5,2.0\n3.0,4.0\n7.0,5.0\n",
    "pandas index without names": ",0,1\n0,1.5,2.0\n1,3.0,4.0\n2,7.0,5.0\n",
    "frame and time": "frame,t,x,y\n0,0.0,1.5,2\n1,0.1,3,4\n2,0.2,7,5\n",
    "velocity beside": "vx,vy,x,y\n9,9,1.5,2\n9,8,3,4\n9,7,7,5\n",
    "velocity first, position with its own names": "v_x,v_y,p_x,p_y\n9,9,1.5,2\n9,8,3,4\n8,7,7,5\n",
    "twist and pose": "twist.linear.x,twist.linear.y,pose.position.x,pose.position.y\n"
    "9,9,1.5,2\n9,8,3,4\n8,7,7,5\n",
    "index named so": "index,X,Y\n0,1.5,2\n1,3,4\n2,7,5\n",
    "goal beside": "goal_x,goal_y,x,y\n9,9,1.5,2\n9,9,3,4\n9,9,7,5\n",
    "camel case": "posX,posY\n1.5,2\n3,4\n7,5\n",
    "other order": "y,label_text,x\n2,a,1.5\n4,b,3\n5,c,7\n",
    "savetxt header": "# x y\n1.5 2\n3 4\n7 5\n",
    "savetxt with time": "# t x y\n0.0 1.5 2\n0.1 3 4\n0.2 7 5\n",
    "EuRoC": "#timestamp [ns], p_RS_R_x [px], p_RS_R_y [px]\n"
    "0,1.5,2\n50000000,3,4\n100000000,7,5\n",
    "trailing commas": "x,y,\n1.5,2,\n3,4,\n7,5,\n",
    "trailing commas below the header": "x,y\n1.5,2,\n3,4,\n7,5,\n",
    "empty rows at the end": "x,y\n1.5,2\n3,4\n7,5\n,\n,\n",
    "one of several": "left_x,left_y,x,y\n9,9,1.5,2\n9,9,3,4\n9,9,7,5\n",
    "units line": "x,y\npx,px\n1.5,2\n3,4\n7,5\n",
    "units in brackets": "x (px),y (px)\n1.5,2\n3,4\n7,5\n",
    "old Mac": "x,y\r1.5,2\r3,4\r7,5\r",
    "quoted": '"x","y"\n"1.5","2"\n"3","4"\n"7","5"\n',
    "decimal commas": "x;y\n1,5;2,0\n3,0;4,0\n7,0;5,0\n",
    "decimal commas, tabs": "x\ty\n1,5\t2\n3\t4\n7\t5\n",
    "decimal commas, blanks": "x y\n1,5 2,0\n3,0 4,0\n7,0 5,0\n",
    "decimal commas in quotes": 'x|y\n"1,5"|2\n3|4\n7|5\n',
    "exponents": "x,y\n1.5e0,2E+0\n3e0,4e0\n70e-1,5\n",
    "blanks round the cells": "x , y\n 1.5 , 2\n3 ,4\n7, 5\n",
}  # fmt: skip


@pytest.mark.parametrize("name", list(READ))
def test_tables_that_have_one_reading(tmp_path: Path, name: str) -> None:
    assert points(read(tmp_path, READ[name]).data) == SAME


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-8-sig", "utf-8"])
def test_encodings_are_found(tmp_path: Path, encoding: str) -> None:
    data = read(
        tmp_path, "x,y,who\n1.5,2,é\n3,4,é\n7,5,é\n".encode(encoding), demonstrator="who"
    ).data
    assert points(data) == SAME
    assert data.demonstrations[0].demonstrator == "é"


def test_an_encoding_can_be_said(tmp_path: Path) -> None:
    text = "x,y,who\n1.5,2,é\n3,4,é\n7,5,é\n".encode("latin-1")
    with pytest.raises(InputError, match="--encoding"):
        read(tmp_path, text)
    data = read(tmp_path, text, encoding="latin-1", demonstrator="who").data
    assert data.demonstrations[0].demonstrator == "é"
    for wrong in ("ascii", "klingon", "base64"):
        with pytest.raises(InputError) as fault:
            read(tmp_path, text, encoding=wrong)
        assert "\n" not in str(fault.value)


def test_lines_above_the_table(tmp_path: Path) -> None:
    text = "Recorded by Ann\n1,2,3\n\nx,y\n1.5,2\n3,4\n7,5\n"
    with pytest.raises(InputError, match="--skip-rows"):
        read(tmp_path, text)
    assert points(read(tmp_path, text, skip_rows=3).data) == SAME
    assert points(read(tmp_path, text, header_row=4).data) == SAME
    with pytest.raises(InputError, match="a header in line 3"):
        read(tmp_path, text, header_row=3)


def test_a_header_of_integers_or_a_first_point(tmp_path: Path) -> None:
    unclear = "0,1\n1,2\n2,3\n3,5\n"
    with pytest.raises(InputError, match=r"--header-row 1 .*--header-row none"):
        read(tmp_path, unclear)
    assert points(read(tmp_path, unclear, header_row="none").data)[0] == [0, 1]
    assert points(read(tmp_path, unclear, header_row=1).data)[0] == [1, 2]
    far = "0,1\n400,300\n402,301\n404,303\n405,306\n"
    assert points(read(tmp_path, far).data)[0] == [400, 300]


CELLS: dict[str, tuple[str, str, str]] = {
    "thousands": ("x,y,z\n1,2,3\n\"1,234.5\",2,3\n", "line 3, x", "1,234.5"),
    "thousands, decimal comma": ("x;y;z\n1,5;2,5;3\n1.234,5;2;3\n", "line 3, x", "1.234,5"),
    "thousands with blanks": ("x;y;z\n1;2;3\n1 234,5;2;3\n", "line 3, x", "1 234,5"),
    "dash": ("x,y,z\n1,2,3\n-,2,3\n", "line 3, x", "'-'"),
    "words": ("x,y,speed\n1,2,3\nn.d.,2,3\n", "line 3, x", "n.d."),
    "nothing but words": ("x,y,z\na,2,3\nb,2,3\n", "line 2, x", "'a'"),
    "empty": ("x,y,z\n1,2,3\n,2,3\n1,2,3\n", "line 3, x", "''"),
    "underscores": ("x,y\n1_000,2\n1,2\n", "line 2, x", "1_000"),
    "other digits": ("x,y\n١٢,2\n1,2\n", "line 2, x", "١٢"),
    "hexadecimal": ("x,y\n1,0x1A\n1,2\n", "line 2, y", "0x1A"),
    "too large": ("x,y\n1,1e400\n1,2\n", "line 2, y", "1e400"),
    "beyond 64 bits": ("x,y\n123456789012345678901234567890,1\n1,2\n", "line 2, x", "12345678901"),
    "a comment counts as a line": ("# a\n# b\nx,y\n1,2\n# c\n\n1,q\n", "line 7, y", "'q'"),
    "height": ("x,y,z\n1,2,3\n1,2,high\n", "line 3, z", "'high'"),
    "tilt": ("x,y,tilt\n1,2,3\n1,2,steep\n", "line 3, tilt", "'steep'"),
    "clock": ("t,x,y\n0,2,3\nlater,2,3\n", "line 3, t", "'later'"),
    "two decimal marks": ("x;y\n1,5;2\n1.5;3\n", "line 3, x", "1.5"),
    "two decimal marks, two columns": ("x;y\n1,5;2.5\n2,5;3.5\n", "line 2, y", "2.5"),
    "comma of thousands or decimals": ("x;y\n1,234;2\n2,345;3\n", "line 2, x", "1,234"),
}  # fmt: skip


@pytest.mark.parametrize("name", list(CELLS))
def test_a_cell_that_is_no_number_is_named_and_no_column_is_lost(tmp_path: Path, name: str) -> None:
    text, place, cell = CELLS[name]
    with pytest.raises(InputError) as fault:
        read(tmp_path, text)
    assert place in str(fault.value)
    assert cell in str(fault.value)
    assert "a.csv" in str(fault.value)


def test_missing_cells_are_left_out_where_asked(tmp_path: Path) -> None:
    text = "x,y\n1,2\n-,3\n,4\nnan,5\nN/A,6\n7,8\n"
    assert points(read(tmp_path, text, drop_missing=True).data) == [[1, 2], [7, 8]]
    with pytest.raises(InputError, match="line 3, x"):  # a word is never taken for missing
        read(tmp_path, "x,y\n1,2\nlost,3\n7,8\n", drop_missing=True)


def test_a_decimal_mark_can_be_said(tmp_path: Path) -> None:
    text = "x;y\n1,234;2\n2,345;3\n"
    assert points(read(tmp_path, text, decimal=",").data) == [[1.234, 2], [2.345, 3]]
    with pytest.raises(InputError, match="line 2, x"):
        read(tmp_path, text, decimal=".")
    clear = "x;y\n1,234;0,5\n2,345;0,25\n"  # another column shows what a comma is
    assert points(read(tmp_path, clear).data) == [[1.234, 0.5], [2.345, 0.25]]
    comma = 'x,y\n"1,5","2,5"\n"3,0","4,0"\n'
    assert points(read(tmp_path, comma, decimal=",").data) == [[1.5, 2.5], [3, 4]]


UNCLEAR: dict[str, tuple[str, str]] = {
    "no y": ("x,vy\n1,2\n3,4\n", "columns for x and y"),
    "only velocities": ("vx,vy\n1,2\n3,4\n", "columns for x and y"),
    "only speeds": ("speed,time\n1,2\n3,4\n", "columns for x and y"),
    "orientation alone": ("qx,qy,qz,qw\n0,0,0,1\n0,0,0,1\n", "columns for x and y"),
    "names that say nothing": ("a,b\n1,2\n3,4\n", "columns for x and y"),
    "latitude": ("lat,lon\n1,2\n3,4\n", "columns for x and y"),
    "two things": ("left_x,left_y,right_x,right_y\n1,2,3,4\n", "one column for x"),
    "x of one, y of another": ("left_x,right_y\n1,2\n3,4\n", "one column for"),
    "y lost its name, another thing has both": ("x,foo,left_x,left_y\n1,2,3,4\n", "one column for"),
    "index, x and y without names": ("0,5,9\n1,6,9\n2,7,8\n3,9,8\n", "like a clock or a count"),
    "time without names": ("0.0,5,9\n0.11,6,9\n0.19,7,8\n0.3,9,8\n", "like a clock or a count"),
    "time last": ("5,9,100.0\n6,9,100.1\n7,8,100.2\n9,8,100.3\n", "like a clock or a count"),
    "date first": ("1.7e9 5 9\n1.7000001e9 6 9\n1.7000003e9 6 9\n", "like a clock or a count"),
    "four without names": ("1,2,3,4\n2,2,3,4\n", "columns for x and y"),
    "inches": ("x (in),y (in)\n1,2\n3,4\n", "a length in px, m, cm or mm"),
    "one unit of two": ("x (mm),y\n1,2\n3,4\n", "a unit for every column"),
    "pixels and metres": ("x_px,y_m\n1,2\n3,4\n", "one unit of length"),
    "angles": ("x (deg),y (deg)\n1,2\n3,4\n", "columns for x and y"),
}


@pytest.mark.parametrize("name", list(UNCLEAR))
def test_columns_with_several_readings_are_refused(tmp_path: Path, name: str) -> None:
    text, words = UNCLEAR[name]
    with pytest.raises(InputError, match=words):
        read(tmp_path, text)


def test_a_column_that_falls_is_no_clock(tmp_path: Path) -> None:
    data = read(tmp_path, "1,5,9\n2,6,9\n1.5,7,8\n1.2,9,8\n").data
    assert data.columns == ("x", "y", "z")
    np.save(tmp_path / "a.npy", np.array([[0, 5, 9], [1, 6, 9], [2, 7, 9.0]]))
    with pytest.raises(InputError, match="like a clock"):
        read_source(tmp_path / "a.npy")
    how = Mapping.model_validate({"columns": {"x": 1, "y": 2}, "time": 0})
    found = read_source(tmp_path / "a.npy", mapping=how).data.demonstrations[0]
    assert found.points.tolist() == [[5, 9], [6, 9], [7, 9]]
    assert found.t is not None
    assert found.t.tolist() == [0, 1, 2]


def test_each_file_is_read_by_its_own_names(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.csv").write_text("x,y\n1,2\n3,4\n")
    (tmp_path / "in" / "b.csv").write_text("y,t,x\n2,0,1\n4,1,3\n")
    (tmp_path / "in" / "c.csv").write_text("pos_x;pos_y\n1,0;2,0\n3,0;4,0\n")
    items = read_source(tmp_path / "in").data.demonstrations
    assert [d.points.tolist() for d in items] == [[[1, 2], [3, 4]]] * 3
    (tmp_path / "in" / "d.csv").write_text("x,y,z\n1,2,9\n3,4,9\n")
    with pytest.raises(InputError, match="a column for z, as d has one"):
        read_source(tmp_path / "in")


def test_include_and_exclude(tmp_path: Path) -> None:
    for name in ("run1.csv", "run2.csv", "sub/run3.csv"):
        (tmp_path / "in" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "in" / name).write_text("x,y\n1,2\n3,4\n")
    for name in ("README.txt", "words.txt"):
        (tmp_path / "in" / name).write_text("Two runs and a third.\n")

    def names(**given: object) -> list[str]:
        how = Mapping.model_validate(given)
        return [d.demo_id for d in read_source(tmp_path / "in", mapping=how).data.demonstrations]

    with pytest.raises(InputError, match=r"words\.txt"):  # a README is no recording
        names()
    with pytest.raises(InputError, match=r"README\.txt"):  # unless it is said to be one
        names(include=["README.txt"])
    assert names(exclude=["*.txt"]) == ["run1", "run2", "run3"]
    assert names(include=["run*.csv"], exclude=["sub/*"]) == ["run1", "run2"]
    with pytest.raises(InputError, match="files that the patterns leave"):
        names(include=["*.dat"])


def test_a_long_table_without_a_known_name_of_its_demonstrations(tmp_path: Path) -> None:
    rows = [(f"q{i}", float(4 * k), 40.0 * i + k) for i in range(3) for k in range(6)]
    text = "session,x,y\n" + "".join(f"{q},{x},{y}\n" for q, x, y in rows)
    with pytest.raises(InputError, match="--demonstration session"):
        read(tmp_path, text)
    assert len(read(tmp_path, text, demonstration="session").data.demonstrations) == 3
    assert len(read(tmp_path, text, demonstration="none").data.demonstrations) == 1
    # Phases of one path do not leap; a clock that starts again does.
    phases = "phase,x,y\n" + "".join(f"{'abc'[k // 4]},{4 * k},{k}\n" for k in range(12))
    assert len(read(tmp_path, phases).data.demonstrations) == 1
    clock = "t,x,y\n" + "".join(f"{k % 4},{4 * k},{k}\n" for k in range(12))
    with pytest.raises(InputError, match="the clock starts again"):
        read(tmp_path, clock)
    two = "demo_id,trial,x,y\n" + "".join(f"d{k // 6},t{k // 4},{k},1\n" for k in range(12))
    with pytest.raises(InputError, match="one column that tells demonstrations apart"):
        read(tmp_path, two)


def test_numpy_archives(tmp_path: Path) -> None:
    path = np.array([[1.5, 2.0], [3.0, 4.0], [7.0, 5.0]])
    file = tmp_path / "a.npz"
    np.savez(file, vel=np.ones((3, 2)), pos=path)
    assert points(read_source(file).data) == SAME
    np.savez(file, vel=np.ones((3, 2)))
    with pytest.raises(InputError, match="one array of points"):
        read_source(file)
    np.savez(file, y=path[:, 1], x=path[:, 0], t=np.array([0, 50_000_000, 100_000_000]))
    item = read_source(file).data.demonstrations[0]
    assert item.points.tolist() == SAME
    assert item.t is not None
    np.testing.assert_allclose(item.t, [0, 0.05, 0.1])
    kinds = [("y", "f8"), ("x", "f8"), ("seq", "i4")]
    array = np.array([(y, x, i) for i, (x, y) in enumerate(SAME)], dtype=kinds)
    np.save(tmp_path / "b.npy", array)
    assert points(read_source(tmp_path / "b.npy").data) == SAME
