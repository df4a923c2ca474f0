"""Notebooks run from the first cell to the last and find what they say."""

import runpy
import subprocess
import sys

import matplotlib.pyplot as plt
import numpy as np


def test_broken_chaos(root, monkeypatch):
    monkeypatch.setattr(plt, "show", lambda: None)
    found = runpy.run_path(str(root / "python/notebooks/broken_chaos.py"))
    (exact, error), (chaos, _) = found["slopes"]["exact"][-1], found["slopes"]["Monte Carlo"][-1]
    # Grazing collisions are in excess in the exact gas, by far more than the error and than in Monte Carlo.
    assert exact > 10 * error and exact > 3 * abs(chaos)
    assert np.mean(found["again"]) > np.mean(found["first"])
    assert found["figure"].axes[0].has_data()
    plt.close(found["figure"])


def test_ensemble(root):
    script = root / "python/notebooks/ensemble.py"
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert sum(line.startswith("T(") for line in lines) == 3
    assert lines[-1].endswith(("the same numbers from Dask: True", "not installed"))
