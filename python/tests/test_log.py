"""Logs of collisions, and their files, each read by the program that it is for."""

import sys

import numpy as np
import pandas as pd
import pytest
import stosszahl
from stosszahl import CollisionLog, EventDriven, Gas, MonteCarlo

MOST = 1000


def logged(engine, until, most=MOST):
    log = CollisionLog(most)
    before = engine.collisions
    engine.advance(until, log)
    assert log.seen == engine.collisions - before > 0
    return log


@pytest.fixture(scope="module")
def log():
    """Log of fewer collisions than were seen, of two species."""
    engine = EventDriven(Gas.disks(300, species=[(200, 0.7, 3.0)], packing_fraction=0.25, restitution=0.9, seed=7))
    return logged(engine, 5.0)


def by_hand(one):
    """Computes impact parameter, relative speed and normal speed of one collision in the plainest way."""
    relative, line = one["relative_velocity"].tolist(), one["line"].tolist()
    speed, distance = sum(v * v for v in relative) ** 0.5, sum(x * x for x in line) ** 0.5
    normal = -sum(v * x for v, x in zip(relative, line)) / distance
    return max(1.0 - (normal / speed) ** 2, 0.0) ** 0.5, speed, normal


def test_a_log_is_bounded(log):
    assert log.seen > MOST and len(log.collisions) == MOST
    assert np.all(np.diff(log.collisions["time"]) >= 0)
    nothing = CollisionLog(0)
    nothing(log.collisions)
    assert nothing.seen == MOST and len(nothing.collisions) == 0
    for most in (-1, 1.5):
        with pytest.raises(stosszahl.GasError, match=f"most is {most}; allowed: whole numbers from 0"):
            CollisionLog(most)


def test_npz(log, tmp_path):
    read = np.load(log.write(tmp_path / "log.npz"))
    assert set(read) == {*stosszahl.COLLISION.names, "impact_parameter", "relative_speed", "normal_speed", "seen"}
    for name in stosszahl.COLLISION.names:
        assert np.array_equal(read[name], log.collisions[name])
    assert read["seen"] == log.seen and read["pair"].shape == (MOST, 2)
    found = np.column_stack([read[name] for name in ("impact_parameter", "relative_speed", "normal_speed")])
    # Rounding of a few terms of the size of one; under the square root of a central collision that is 1e-8.
    assert np.abs(found - [by_hand(one) for one in log.collisions]).max() < 1e-7


def test_parquet_with_pyarrow_and_pandas(log, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    path = log.write(tmp_path / "log.parquet")
    table, kept = parquet.read_table(path), log.collisions
    assert table.schema.metadata[b"seen"] == str(log.seen).encode()
    frame = pd.read_parquet(path)
    assert frame.shape == (MOST, table.num_columns) == table.shape and list(frame) == table.column_names
    assert np.array_equal(frame[["first", "second"]], kept["pair"])
    assert np.array_equal(frame[["first_species", "second_species"]], kept["species"]) and set(frame["second_species"]) == {0, 1}
    for name in ("time", "reduced_mass", "restitution", "weight"):
        assert np.array_equal(frame[name], kept[name])
    for name in ("position", "relative_velocity", "line"):
        assert np.array_equal(frame[[f"{name}_{axis}" for axis in "xyz"]], kept[name])
    arrays = np.load(log.write(tmp_path / "log.npz"))
    for name in ("impact_parameter", "relative_speed", "normal_speed"):
        assert np.array_equal(frame[name], arrays[name])


def test_parquet_in_parts_without_partners_and_empty(tmp_path, monkeypatch):
    parquet = pytest.importorskip("pyarrow.parquet")
    monkeypatch.setattr("stosszahl.log.ROWS", 64)
    log = logged(MonteCarlo(Gas.spheres(500, restitution=0.8)), 2.0, most=200)
    file = parquet.ParquetFile(log.write(tmp_path / "log.parquet"))
    assert [file.metadata.row_group(number).num_rows for number in range(file.num_row_groups)] == [64, 64, 64, 8]
    table = file.read()
    assert np.array_equal(table["time"], log.collisions["time"])
    unknown = log.collisions["pair"] == 2**32 - 1
    assert np.array_equal([table[name].is_null() for name in ("first", "second")], unknown.T)
    empty = parquet.read_table(CollisionLog().write(tmp_path / "empty.parquet"))
    assert empty.num_rows == 0 and empty.schema.equals(table.schema)


def test_an_ending_that_is_not_known(log, tmp_path):
    with pytest.raises(stosszahl.ResultsError, match="no format has the ending '.csv'; allowed: .npz, .parquet"):
        log.write(tmp_path / "log.csv")
    with pytest.raises(stosszahl.ResultsError, match="no format has the ending ''; allowed"):
        log.write(tmp_path / "log")
    with pytest.raises(stosszahl.ResultsError, match="nowhere/log.npz: cannot be written.*allowed: a file in a folder that exists"):
        log.write(tmp_path / "nowhere/log.npz")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("ending", "module"), [("npz", "numpy.savez_compressed"), ("parquet", "pyarrow.parquet.ParquetWriter.write_table")])
def test_a_file_is_replaced_whole_or_not_at_all(log, tmp_path, monkeypatch, ending, module):
    if ending == "parquet":
        pytest.importorskip("pyarrow.parquet")
    path = log.write(tmp_path / f"log.{ending}")
    before = path.read_bytes()

    def fail(*_, **__):
        assert [one.name for one in tmp_path.iterdir() if one != path] == [f".partial-log.{ending}"]
        raise MemoryError

    monkeypatch.setattr(module, fail)
    with pytest.raises(MemoryError):
        log.write(path)
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]


def test_a_package_that_is_missing(log, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(stosszahl.PackageError, match=r"files .parquet need the package pyarrow.*pip install pyarrow") as caught:
        log.write(tmp_path / "log.parquet")
    assert isinstance(caught.value, ImportError) and caught.value.name == "pyarrow" and list(tmp_path.iterdir()) == []
