"""Errors are one line that names the place; files are written whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from demospec.errors import InputError, MissingExtraError, OutputError
from demospec.files import (
    parse_json,
    read_bytes,
    read_json,
    write_json,
    writing_file,
    writing_folder,
)


def test_input_error_names_file_row_field_expected_found() -> None:
    error = InputError("a number", "x\ny", file="set/a.json", row=3, field="valid")
    assert str(error) == "set/a.json, row 3, valid: expected a number, found x y"


def test_place_is_added_without_losing_what_is_known() -> None:
    error = InputError("a", "b", field="points").at(file="f", row=2, field="other")
    assert str(error) == "f, row 2, points: expected a, found b"


def test_long_values_are_cut() -> None:
    assert len(str(InputError("a", "x" * 10_000))) < 200


def test_missing_extra_names_the_pip_command() -> None:
    assert "pip install 'demospec[vision]'" in str(MissingExtraError("torch", "vision", "fit"))


def test_failed_writing_leaves_the_old_file_and_no_rubbish(tmp_path: Path) -> None:
    target = tmp_path / "a.json"
    write_json(target, {"a": 1})
    with pytest.raises(RuntimeError), writing_file(target) as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert read_json(target) == {"a": 1}
    assert [p.name for p in tmp_path.iterdir()] == ["a.json"]


def test_failed_folder_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError), writing_folder(tmp_path / "set") as folder:
        (folder / "x").write_text("half")
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_folder_with_content_is_not_replaced_unless_asked(tmp_path: Path) -> None:
    with writing_folder(tmp_path / "set") as folder:
        (folder / "x").write_text("1")
    with pytest.raises(OutputError, match="--force"), writing_folder(tmp_path / "set"):
        pass
    with writing_folder(tmp_path / "set", replace=True) as folder:
        (folder / "y").write_text("2")
    assert [p.name for p in (tmp_path / "set").iterdir()] == ["y"]
    assert [p.name for p in tmp_path.iterdir()] == ["set"]


def test_what_a_library_says_of_a_full_disk_is_an_output_error(tmp_path: Path) -> None:
    """Only some libraries raise OSError: others wrap the system's words in their own exception."""

    class SomeLibrarysError(Exception):
        pass

    words = "Error while serializing: I/O error: No space left on device (os error 28)"
    for context in (writing_file, writing_folder):
        with (
            pytest.raises(OutputError, match=r"out: cannot write: .*No space left"),
            context(tmp_path / "out"),
        ):
            raise SomeLibrarysError(words)
        with pytest.raises(SomeLibrarysError, match="broken"), context(tmp_path / "out"):
            raise SomeLibrarysError("broken")
    # A file in a folder is called by the folder's own name, not by its temporary one.
    with pytest.raises(OutputError) as fault, writing_folder(tmp_path / "out") as folder:
        raise OutputError(f"{folder}/a.json: cannot write: No space left on device")
    assert str(fault.value) == f"{tmp_path}/out/a.json: cannot write: No space left on device"
    assert list(tmp_path.iterdir()) == []


def test_disk_full_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="No space left"), writing_file(tmp_path / "a"):
        raise OSError(28, "No space left on device")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"{", "a JSON document"),
        (b'{"a": NaN}', "a finite number"),
        (b"\xff\xfe", "UTF-8 text"),
        (b"[" * 100_000, "a JSON document"),
        (b"1" * 10_000, "a finite number.* at line 1 column 1$"),
        (b'{"a": 2,\n "b": 1e400}', "found 1e400 at line 2 column 7$"),
        (b'{"a": "\\ud800"}', "half of a surrogate pair"),
        (b'{"a": 1, "a": 2}', "a"),
    ],
)
def test_broken_json_is_an_input_error(data: bytes, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        parse_json(data, file="x.json")


def test_unreadable_things_are_input_errors(tmp_path: Path) -> None:
    for path in (tmp_path / "absent", tmp_path, Path("bad\0name")):
        with pytest.raises(InputError):
            read_bytes(path)
    (tmp_path / "big").write_text(json.dumps("x" * 100))
    with pytest.raises(InputError, match="at most 10 bytes"):
        read_json(tmp_path / "big", limit_bytes=10)
