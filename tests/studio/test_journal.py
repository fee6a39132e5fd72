"""The journal and the workbench, without a browser."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sqlite3
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from demospec.demonstrations import DemonstrationSet, read_set, simulate_set, write_set
from demospec.errors import InputError, OutputError
from demospec.studio.session._journal import Event, Journal
from demospec.studio.session._models import SO_FAR
from demospec.studio.session._workspace import Workbench

PATH = [[10.0, 50.0], [50.0, 70.0], [90.0, 50.0]]


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data, truth = simulate_set(train_scenes=2, test_scenes=1, demonstrations=2, seed=1)
    folder = tmp_path_factory.mktemp("journal") / "set"
    return write_set(data, folder, documents={"truth.json": truth})


def kind_of(event: Event | None) -> str | None:
    return None if event is None else event.kind


def listing(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_a_reopened_journal_has_everything_and_the_input_is_untouched(
    source: Path, tmp_path: Path
) -> None:
    before = listing(source)
    bench = Workbench(source, out=tmp_path / "new")
    scene = bench.scenes[0].scene_id
    demo = bench.draw(scene, PATH, actor="tab", type="normal", demonstrator="Kim", t=[0, 0.5, 1])
    bench.label(demo.demo_id, True, actor="tab")
    gone = bench.demonstrations[0].demo_id
    bench.delete(gone, actor="tab")
    bench.edit(demo.demo_id, actor="tab", type="careful")
    stood = bench.demonstrations
    # Not closed: as after a crash.
    again = Workbench(source, out=tmp_path / "new")
    assert again.demonstrations == stood
    written = read_set(again.write())
    assert tuple(written.demonstrations) == stood
    assert gone not in set(written.demonstrations.demo_id)
    last = written.demonstrations[len(written.demonstrations) - 1]
    assert (last.type, last.demonstrator, last.valid) == ("careful", "Kim", True)
    assert listing(source) == before
    again.write()  # a second time replaces it
    bench.close()
    again.close()


def test_undo_and_redo_are_of_ones_own(tmp_path: Path) -> None:
    bench = Workbench(out=tmp_path / "new")
    scene = bench.scenes[0].scene_id
    mine = bench.draw(scene, PATH, actor="a")
    other = bench.draw(scene, PATH, actor="b")
    assert kind_of(bench.undo("a")) == "add"
    assert [d.demo_id for d in bench.demonstrations] == [other.demo_id]
    assert bench.undo("a") is None
    assert kind_of(bench.redo("a")) == "add"
    assert {d.demo_id for d in bench.demonstrations} == {mine.demo_id, other.demo_id}
    bench.undo("a")
    third = bench.draw(scene, PATH, actor="a")
    assert bench.redo("a") is None  # acted since
    assert third.demo_id not in (mine.demo_id, other.demo_id)
    bench.close()


def test_another_set_another_journal(source: Path, tmp_path: Path) -> None:
    Workbench(source, out=tmp_path / "new").close()
    with pytest.raises(InputError, match="one about another"):
        Workbench(source, out=tmp_path / "new", scenes_only=True)
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "thesis.txt").write_text("mine")
    with pytest.raises(OutputError, match="exists without a journal"):
        Workbench(source, out=tmp_path / "kept")
    (tmp_path / "text.journal").write_text("this is no database, " * 100)
    with pytest.raises(InputError, match="a journal of the studio"):
        Workbench(source, out=tmp_path / "text")


def test_bad_strokes_are_refused_and_leave_nothing(tmp_path: Path) -> None:
    bench = Workbench(out=tmp_path / "new")
    scene = bench.scenes[0].scene_id
    for points in (
        [[1, 1]], [], "x", [[0, 0], [float("nan"), 1]], [[0, 0], [1e6, 0]],
        [[0, 0, 0], [1, 1, 1]], [[1, 2]] * 6000, None,
    ):  # fmt: skip
        with pytest.raises(InputError):
            bench.draw(scene, points, actor="a")
    with pytest.raises(InputError):
        bench.draw("no such scene", PATH, actor="a")
    with pytest.raises(InputError):
        bench.draw(scene, PATH, actor="a", t=[0.0, 1.0])
    with pytest.raises(InputError):
        bench.draw(scene, PATH, actor="a", type="x" * 200)
    with pytest.raises(InputError):
        bench.label("drawn-0001", True, actor="a")
    assert bench.demonstrations == ()
    with pytest.raises(InputError, match="at least one demonstration"):
        bench.write()
    bench.close()


def test_models_are_named(source: Path, tmp_path: Path) -> None:
    bench = Workbench(source, source / "truth.json", out=tmp_path / "new")
    assert set(bench.models()) == {SO_FAR, "truth"}
    bench.close()


def test_threads_and_two_openings_do_not_lose_or_repeat(tmp_path: Path) -> None:
    benches = [Workbench(out=tmp_path / "new") for _ in range(2)]
    scene = benches[0].scenes[0].scene_id
    faults: list[BaseException] = []

    def work(i: int) -> None:
        try:
            for _ in range(10):
                demo = benches[i % 2].draw(scene, PATH, actor=f"t{i}")
                benches[(i + 1) % 2].label(demo.demo_id, True, actor=f"t{i}")
        except BaseException as error:
            faults.append(error)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    assert not faults
    assert benches[0].demonstrations == benches[1].demonstrations
    assert len(benches[0].demonstrations) == 40
    assert all(d.valid for d in benches[0].demonstrations)
    for bench in benches:
        bench.close()


KILLED = """
import sys
from pathlib import Path
from demospec.studio.session._workspace import Workbench
bench = Workbench(out=Path(sys.argv[1]))
scene = bench.scenes[0].scene_id
while True:
    print(bench.draw(scene, [[10, 50], [90, 50]], actor="k").demo_id, flush=True)
"""


def test_what_was_answered_survives_kill_9(tmp_path: Path) -> None:
    out = tmp_path / "new"
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(out)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    told = [process.stdout.readline().strip() for _ in range(15)]
    os.kill(process.pid, signal.SIGKILL)
    told += process.stdout.read().split("\n")[:-1]
    process.wait()
    process.stdout.close()
    bench = Workbench(out=out)
    kept = [d.demo_id for d in bench.demonstrations]
    assert set(told) <= set(kept)
    assert len(kept) - len(told) <= 1  # kept, and killed before saying so
    bench.close()


@pytest.mark.slow
def test_twenty_kills_while_labelling_lose_nothing_that_was_answered(tmp_path: Path) -> None:
    out, told = tmp_path / "new", set[str]()
    labelling = KILLED.replace(
        'print(bench.draw(scene, [[10, 50], [90, 50]], actor="k").demo_id, flush=True)',
        'name = bench.draw(scene, [[10, 50], [90, 50]], actor="k").demo_id\n'
        '    bench.label(name, True, actor="k")\n'
        "    print(name, flush=True)",
    )
    assert "label" in labelling
    for kill in range(20):
        process = subprocess.Popen(
            [sys.executable, "-c", labelling, str(out)], stdout=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        told |= {process.stdout.readline().strip() for _ in range(1 + kill % 4)}
        os.kill(process.pid, signal.SIGKILL)
        told |= set(process.stdout.read().split("\n")[:-1])
        process.wait()
        process.stdout.close()
    bench = Workbench(out=out)
    accepted = {d.demo_id for d in bench.demonstrations if d.valid}
    bench.close()
    assert len(told) >= 50
    assert told <= accepted


def _write_often(out: str, times: int) -> None:
    bench = Workbench(out=Path(out))
    for _ in range(times):
        bench.draw(bench.scenes[0].scene_id, PATH, actor=str(os.getpid()))
        bench.write()
    bench.close()


def test_two_processes_write_one_set(tmp_path: Path) -> None:
    out = tmp_path / "new"
    Workbench(out=out).close()
    context = multiprocessing.get_context("spawn")
    workers = [context.Process(target=_write_often, args=(str(out), 4)) for _ in range(2)]
    for w in workers:
        w.start()
    for w in workers:
        w.join(60)
    assert [w.exitcode for w in workers] == [0, 0]
    assert len(read_set(out).demonstrations) == 8
    assert not list(tmp_path.glob(".new*"))


class AgainstAList(RuleBasedStateMachine):
    """The journal against a plain list with an undo pile."""

    def __init__(self) -> None:
        super().__init__()
        import tempfile

        self.folder = tempfile.TemporaryDirectory()
        self.bench = Workbench(out=Path(self.folder.name) / "new")
        self.scene = self.bench.scenes[0].scene_id
        self.past: list[dict[str, bool | None]] = []
        self.now: dict[str, bool | None] = {}
        self.future: list[dict[str, bool | None]] = []

    def act(self) -> None:
        self.past.append(dict(self.now))
        self.future.clear()

    @rule()
    def draw(self) -> None:
        self.act()
        self.now[self.bench.draw(self.scene, PATH, actor="a").demo_id] = None

    @rule(valid=st.sampled_from([True, False, None]), pick=st.integers(0, 9))
    def label(self, valid: bool | None, pick: int) -> None:
        if self.now:
            name = list(self.now)[pick % len(self.now)]
            self.act()
            self.bench.label(name, valid, actor="a")
            self.now[name] = valid

    @rule(pick=st.integers(0, 9))
    def delete(self, pick: int) -> None:
        if self.now:
            name = list(self.now)[pick % len(self.now)]
            self.act()
            self.bench.delete(name, actor="a")
            del self.now[name]

    @rule()
    def undo(self) -> None:
        assert (self.bench.undo("a") is None) == (not self.past)
        if self.past:
            self.future.append(dict(self.now))
            self.now = self.past.pop()

    @rule()
    def redo(self) -> None:
        assert (self.bench.redo("a") is None) == (not self.future)
        if self.future:
            self.past.append(dict(self.now))
            self.now = self.future.pop()

    @invariant()
    def agree(self) -> None:
        assert {d.demo_id: d.valid for d in self.bench.demonstrations} == self.now
        assert self.bench.journal.can("a") == (bool(self.past), bool(self.future))

    def teardown(self) -> None:
        self.bench.close()
        self.folder.cleanup()


AgainstAList.TestCase.settings = settings(deadline=None, max_examples=6, stateful_step_count=20)
TestAgainstAList = AgainstAList.TestCase


@settings(deadline=None, max_examples=20)
@given(st.text(max_size=40))
def test_any_text_goes_through_the_journal(text: str) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        journal = Journal(Path(folder) / "j", "x")
        body = {"demo_id": text, "n": [0.1, 1e-300]}
        try:
            journal.append("label", body, actor="a")
        except UnicodeEncodeError:  # a lone surrogate is no text
            assert not text.isascii()
        else:
            again = Journal(Path(folder) / "j", "x")
            assert again.events()[0].body == body
            again.close()
        journal.close()


def test_strokes_keep_their_numbers(tmp_path: Path) -> None:
    points = np.random.default_rng(0).uniform(0, 100, (50, 2))
    bench = Workbench(out=tmp_path / "new")
    bench.draw(bench.scenes[0].scene_id, points, actor="a")
    bench.close()
    again = Workbench(out=tmp_path / "new")
    assert np.array_equal(again.demonstrations[0].points, points)
    again.close()


def test_writing_the_set_keeps_nobody_from_the_journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The writer held the journal and waited for the table, a reader the other way round."""
    bench = Workbench(out=tmp_path / "taught")
    scene = bench.scenes[0]
    bench.draw(scene.scene_id, [scene.start[:2], scene.goal[:2]], actor="a", valid=True)
    reached, data = threading.Event(), bench.data

    def seen() -> DemonstrationSet | None:
        reached.set()
        return data()

    monkeypatch.setattr(bench, "data", seen)
    with ThreadPoolExecutor(2) as pool:
        with bench._lock:
            writer = pool.submit(bench.write)
            assert reached.wait(60)
            assert len(pool.submit(bench.journal.events).result(60)) == 13
        assert writer.result(60) == bench.out
    bench.close()


@pytest.mark.parametrize("body", ["{", "3", '{"demo_id": 1}', '{"scene_id": "x"}'])
def test_a_damaged_row_is_named(source: Path, tmp_path: Path, body: str) -> None:
    bench = Workbench(source, out=tmp_path / "new")
    file = bench.journal.file
    bench.close()
    with sqlite3.connect(file) as base:
        row = "INSERT INTO events (at, actor, kind, body) VALUES (0, 'tab', 'add', ?)"
        base.execute(row, (body,))
    base.close()
    with pytest.raises(InputError, match=r"new\.journal"):
        Workbench(source, out=tmp_path / "new")


def test_a_full_disk_is_said_and_nothing_is_half_kept(source: Path, tmp_path: Path) -> None:
    bench = Workbench(source, out=tmp_path / "new")
    count = len(bench.demonstrations)
    bench.journal._base.execute("PRAGMA max_page_count=1")  # as if no page more fitted
    with pytest.raises(OutputError, match="nothing was kept"):
        for _ in range(400):
            bench.draw(bench.scenes[0].scene_id, PATH * 40, actor="tab")
    kept = len(bench.demonstrations)
    again = Workbench(source, out=tmp_path / "new")
    assert len(again.demonstrations) == kept >= count
    bench.journal._base.execute("PRAGMA max_page_count=1000000")
    bench.draw(bench.scenes[0].scene_id, PATH, actor="tab")
    assert len(bench.demonstrations) == kept + 1
    for one in (bench, again):
        one.close()
