"""Large sets in parts: the verdicts of one process, from a folder or from a store by URL."""

from __future__ import annotations

import json

import numpy as np
import pytest

from demospec.demonstrations import cut_rows, read_part, read_set, simulate_set, write_set
from demospec.errors import InputError
from demospec.files import write_json
from demospec.specification import load_model, predict, predict_parts


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("parts")
    data, truth = simulate_set(train_scenes=4, test_scenes=2, demonstrations=4, seed=3)
    write_set(data, folder / "set")
    write_json(folder / "truth.json", truth)
    return folder


def test_parts_put_together_are_the_set(place):
    whole = read_set(place / "set").demonstrations
    cuts = cut_rows(str(place / "set"), rows=17)
    assert cuts[0][0] == 0
    assert cuts[-1][1] == len(whole)
    parts = [read_part(str(place / "set"), *cut).demonstrations for cut in cuts]
    assert [i for part in parts for i in part.demo_id] == list(whole.demo_id)
    assert np.array_equal(np.concatenate([part.flat for part in parts]), whole.flat)


def test_rows_are_found_in_files_of_many_row_groups(place, tmp_path):
    import pyarrow.parquet as pq

    write_set(read_set(place / "set"), tmp_path / "set")
    file = tmp_path / "set" / "demonstrations.parquet"
    pq.write_table(pq.read_table(file), file, row_group_size=7)
    for cut in ((0, 5), (5, 21), (13, 14), (69, 72)):
        one = read_part(str(tmp_path / "set"), *cut).demonstrations
        assert (
            one.demo_id.tolist()
            == read_set(place / "set").demonstrations.demo_id[slice(*cut)].tolist()
        )
        same = read_part(str(place / "set"), *cut).demonstrations
        assert np.array_equal(one.flat, same.flat)
        assert np.array_equal(one.offsets, same.offsets)


@pytest.mark.parametrize("by_url", [False, True])
def test_workers_say_what_one_process_says(place, by_url):
    pytest.importorskip("fsspec")
    store = (place / "set").as_uri() if by_url else str(place / "set")
    model = str(place / "truth.json")
    whole = predict(load_model(model), read_set(place / "set"))
    for workers in (1, 2):
        parts = list(predict_parts(model, store, rows=20, workers=workers))
        assert len(parts) == 4
        assert tuple(item for part in parts for item in part.items) == whole.items


def test_a_demonstration_in_two_parts_is_refused(place, tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    write_set(read_set(place / "set"), tmp_path / "set")
    file = tmp_path / "set" / "demonstrations.parquet"
    table = pq.read_table(file)
    pq.write_table(pa.concat_tables([table, table.slice(0, 1)]), file)
    with pytest.raises(InputError, match="each demonstration once"):
        list(predict_parts(str(place / "truth.json"), str(tmp_path / "set"), rows=30))


def test_command_writes_the_same_file_with_workers(place, tmp_path, monkeypatch):
    from demospec.cli import main

    monkeypatch.setattr("demospec.cli._predict.LARGE", 10)
    written = []
    for i, more in enumerate(([], ["--workers", "2"])):
        out = tmp_path / f"{i}.json"
        with pytest.raises(SystemExit) as ended:
            main(
                ["predict", str(place / "truth.json"), str(place / "set"), "--out", str(out), *more]
            )
        assert ended.value.code == 0
        written.append(out.read_bytes())
    assert written[0] == written[1]
    assert len(json.loads(written[0])["predictions"]) == 72


class Killed(BaseException):
    """What no handler of errors sees, as kill -9 would not be seen."""


def test_a_killed_run_goes_on_where_it_was(place, tmp_path):
    model, store = str(place / "truth.json"), str(place / "set")
    whole = predict(load_model(model), read_set(place / "set"))
    judged = []

    def given_out(most):
        def iterate(judge, tasks, **spread):
            for done, rows in enumerate(tasks):
                if done == most:
                    raise Killed
                judged.append(rows)
                yield judge(rows)

        return iterate

    def parts(rows, most=None):
        kept = tmp_path / "kept"
        return list(predict_parts(model, store, rows=rows, keep=kept, iterate=given_out(most)))

    with pytest.raises(Killed):
        parts(20, most=2)
    found = parts(20)
    assert judged == cut_rows(store, rows=20)  # none twice
    assert tuple(item for part in found for item in part.items) == whole.items
    # Another cut is another job, and so is a model that was changed since.
    parts(30)
    assert judged[4:] == cut_rows(store, rows=30)


def test_the_command_leaves_no_parts_behind(place, tmp_path, monkeypatch):
    import pyarrow as pa
    import pyarrow.parquet as pq

    from demospec.cli import main

    monkeypatch.setattr("demospec.cli._predict.LARGE", 10)
    for store, status in ((place / "set", 0), (tmp_path / "broken", 2)):
        if status:
            write_set(read_set(place / "set"), store)
            table = pq.read_table(store / "demonstrations.parquet")
            doubled = pa.concat_tables([table, table.slice(0, 1)])
            pq.write_table(doubled, store / "demonstrations.parquet")
        with pytest.raises(SystemExit) as ended:
            main(["predict", str(place / "truth.json"), str(store), "--out",
                  str(tmp_path / "out.json")])  # fmt: skip
        assert ended.value.code == status
        assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


def test_stores_that_do_not_exist_are_named(place, tmp_path):
    for store in (str(tmp_path / "none"), (tmp_path / "none").as_uri(), "nosuch://bucket/set"):
        with pytest.raises(InputError):
            list(predict_parts(str(place / "truth.json"), store))
