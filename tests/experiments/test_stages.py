"""A run computes a stage once, again when its settings change, and leaves no half artefacts."""

from __future__ import annotations

from pathlib import Path

import pytest

from demospec.errors import InputError
from demospec.experiments import Stage, code_key, run_stages
from demospec.files import write_json
from demospec.progress import Progress


def _stages(log: list[str], size: int = 1) -> tuple[Stage, ...]:
    def make(name: str) -> Stage:
        def work(folder: Path, progress: Progress) -> None:
            log.append(name)
            write_json(folder / name, {})

        return Stage(
            name,
            name,
            work,
            settings={"size": size} if name == "b" else {},
            needs={"a": (), "b": ("a",), "c": ("b",)}[name],
        )

    return make("a"), make("b"), make("c")


def test_second_run_finds_everything(tmp_path: Path) -> None:
    log: list[str] = []
    run_stages(tmp_path / "run", _stages(log), command="x", seed=0)
    record = run_stages(tmp_path / "run", _stages(log), command="x", seed=0)
    assert log == ["a", "b", "c"]
    assert record.cached == ("a", "b", "c")


def test_changed_settings_recompute_what_follows(tmp_path: Path) -> None:
    log: list[str] = []
    run_stages(tmp_path / "run", _stages(log), command="x", seed=0)
    run_stages(tmp_path / "run", _stages(log, size=2), command="x", seed=0)
    assert log == ["a", "b", "c", "b", "c"]


def test_deleted_artefact_is_made_again(tmp_path: Path) -> None:
    log: list[str] = []
    run_stages(tmp_path / "run", _stages(log), command="x", seed=0)
    (tmp_path / "run" / "b").unlink()
    run_stages(tmp_path / "run", _stages(log), command="x", seed=0)
    assert log == ["a", "b", "c", "b"]


def test_interrupted_run_resumes(tmp_path: Path) -> None:
    log: list[str] = []
    first, second, third = _stages(log)

    def stop(folder: Path, progress: Progress) -> None:
        raise KeyboardInterrupt

    broken = Stage("b", "b", stop, settings=second.settings, needs=("a",))
    with pytest.raises(KeyboardInterrupt):
        run_stages(tmp_path / "run", (first, broken, third), command="x", seed=0)
    run_stages(tmp_path / "run", (first, second, third), command="x", seed=0)
    assert log == ["a", "b", "c"]


def test_the_whole_is_told_by_weights_and_only_of_what_is_left(tmp_path: Path) -> None:
    """Half of a stage of weight 8 beside one of weight 2 that was found: half of the whole."""

    def work(folder: Path, progress: Progress) -> None:
        for done in (10, 15):  # ten were there before: no sign of this run's speed
            progress("inner", done, 20)
        write_json(folder / "b", {})

    def quick(folder: Path, progress: Progress) -> None:
        write_json(folder / "a", {})

    stages = (Stage("a", "a", quick, weight=2.0), Stage("b", "b", work, weight=8.0))
    told: list[tuple[str, float, float]] = []

    def progress(what: str, done: float, total: float) -> None:
        told.append((what, done, total))

    run_stages(tmp_path / "run", stages, command="x", seed=0, progress=progress)
    whole = [step[1:] for step in told if step[0] == "all stages"]
    assert whole == [(0, 10), (2, 10), (2, 10), (2, 10), (6, 10), (10, 10)]
    assert [step for step in told if step[0] == "inner"][-1] == ("inner", 20, 20)
    (tmp_path / "run" / "b").unlink()
    told.clear()
    run_stages(tmp_path / "run", stages, command="x", seed=0, progress=progress)
    whole = [step[1:] for step in told if step[0] == "all stages"]
    assert whole == [(0, 8), (0, 8), (4, 8), (8, 8)]


def test_folder_of_somebody_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("precious")
    with pytest.raises(InputError, match="new or empty folder"):
        run_stages(tmp_path, _stages([]), command="x", seed=0)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]


def test_a_run_whose_first_stage_is_refused_leaves_no_folder(tmp_path: Path) -> None:
    def refuse(folder: Path, progress: Progress) -> None:
        raise InputError("a catalogue", "bogus")

    stages = (Stage("a", "a", refuse),)
    with pytest.raises(InputError):
        run_stages(tmp_path / "run", stages, command="x", seed=0)
    assert not (tmp_path / "run").exists()
    (tmp_path / "mine").mkdir()
    with pytest.raises(InputError):
        run_stages(tmp_path / "mine", stages, command="x", seed=0)
    assert (tmp_path / "mine").is_dir()  # it was there before


def test_the_key_of_code_follows_its_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "words_of_a_page"
    package.mkdir()
    (package / "__init__.py").write_text("WORDS = 'before'\n")
    (package / "page.j2").write_text("{{ words }}")
    monkeypatch.syspath_prepend(str(tmp_path))
    first = code_key("words_of_a_page")
    assert code_key("words_of_a_page") == first
    (package / "page.j2").write_text("{{ words }}.")
    assert code_key("words_of_a_page") != first
