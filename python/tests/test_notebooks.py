"""Notebooks run from the first cell to the last and find what they say; their pictures show it."""

import ctypes.util
import importlib.util
import os
import runpy
import subprocess
import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest


@pytest.fixture
def notebook(root, tmp_path, monkeypatch):
    """Runs a notebook in a folder with the bundled cases."""
    (tmp_path / "cases").symlink_to(root / "cases")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(plt, "show", lambda: None)
    yield lambda name: runpy.run_path(str(root / f"python/notebooks/{name}.py"))
    plt.close("all")


def test_broken_chaos(notebook):
    found = notebook("broken_chaos")
    (exact, error), (chaos, _) = found["slopes"]["exact"][-1], found["slopes"]["Monte Carlo"][-1]
    # Grazing collisions are in excess in the exact gas, by far more than the error and than in Monte Carlo.
    assert exact > 10 * error and exact > 3 * abs(chaos)
    assert np.mean(found["again"]) > np.mean(found["first"])
    assert found["figure"].axes[0].has_data()


def test_case_and_sweep(notebook, capsys):
    found = notebook("case_and_sweep")
    said = capsys.readouterr().out
    assert "gas.restitution = 1.2 is refused" in said and "haff_time" in said and "differ " in said
    # Gases of lower restitution deviate more from Haff's law, by many errors.
    last = found["last"].set_index(["engine", "gas.restitution"])
    for engine in ("ed", "dsmc-contact-point"):
        much, little = last.loc[(engine, 0.6)], last.loc[(engine, 0.95)]
        assert much["over_haff"] - little["over_haff"] > 3 * np.hypot(much["over_haff_se"], little["over_haff_se"])
    assert set(found["sweep"].points) == {"restitution=0.6", "restitution=0.8", "restitution=0.95"}
    assert all(axes.has_data() for axes in found["figure"].axes)


def near(frame, reach):
    """Counts the neighbours of each disk within a distance, over all pairs."""
    away = frame.positions[:, None] - frame.positions[None]
    away -= np.array(frame.box) * np.round(away / frame.box)
    return (np.einsum("ijk,ijk->ij", away, away) < reach**2).sum(axis=1) - 1


def test_freud_and_ovito(notebook):
    for module in ("freud", "gsd.hoomd", "ovito.vis"):
        pytest.importorskip(module, exc_type=ImportError)
    found = notebook("freud_and_ovito")
    # freud has positions in single precision, so that a pair may be in the next bin: 1/70 where g is one near contact. Three of them.
    assert found["difference"] < 3 / 70
    assert found["largest"] == sorted(found["largest"]) and found["largest"][-1] > 100
    for frame, neighbours in zip(found["frames"], found["neighbours"], strict=True):
        assert np.array_equal(neighbours, near(frame, 1.5))
    # What has six neighbours or more is yellow, what has none is violet, in as many pixels as there are such disks.
    pictures = [plt.imread(path)[..., :3] for path in found["pictures"]]
    yellow = [np.mean((one[..., 0] > 0.8) & (one[..., 2] < 0.4)) for one in pictures]
    assert yellow[-1] > 10 * yellow[0] and yellow[-1] > 0.01
    assert all(0.05 < np.mean(one.min(axis=-1) < 0.7) < 0.3 for one in pictures)


def test_flow_past_disk(root, tmp_path):
    pytest.importorskip("vtk")
    if "DISPLAY" not in os.environ and not (ctypes.util.find_library("EGL") or ctypes.util.find_library("OSMesa")):
        pytest.skip("vtk finds neither EGL nor OSMesa to draw with")
    (tmp_path / "cases").symlink_to(root / "cases")
    script = root / "python/notebooks/flow_past_disk.py"
    done = subprocess.run([sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "3200 cells around time 12" in done.stdout
    picture = plt.imread(tmp_path / done.stdout.splitlines()[-1])[..., :3]
    assert picture.shape == (720, 1200, 3)
    # The disk is grey in the middle of each panel, 15 pixels are a unit of length, and (14, 10) lies at 210 and 150 from its corner.
    for x, y in ((0, 0), (600, 0), (0, 360), (600, 360)):
        assert np.allclose(picture[y + 150, x + 210], 0.6, atol=0.01)
    # Before the disk the shock is hot, which is bright; the stream is not.
    for x, y in ((0, 0), (600, 0), (0, 360)):
        before, stream = (picture[y + 135 : y + 165, x + at : x + at + 15].mean() for at in (150, 15))
        assert before > stream + 0.1


def test_ensemble(root):
    script = root / "python/notebooks/ensemble.py"
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert sum(line.startswith("T(") for line in lines) == 3
    has_dask = importlib.util.find_spec("distributed") is not None
    assert lines[-1] == ("the same numbers from Dask: True" if has_dask else "dask.distributed is not installed")
