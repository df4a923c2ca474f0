"""Support for all tests: the clone that they are in, and the program that was built in it."""

import signal
import subprocess
from pathlib import Path

import matplotlib
import pytest

matplotlib.use("Agg")
# Default handler: processes that a shell starts in the background may ignore Ctrl-C, and tests of it would never end.
signal.signal(signal.SIGINT, signal.default_int_handler)

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def program():
    """Runs a program of the workspace, in the profile that the wheel was built in."""

    def run(*arguments: str) -> subprocess.CompletedProcess:
        command = ["cargo", "run", "--quiet", "--release", *arguments]
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=1200)

    return run


@pytest.fixture(scope="session")
def quick(tmp_path_factory, root):
    """Results of a small bundled case."""
    import stosszahl

    out = tmp_path_factory.mktemp("results") / "quick"
    keys = {"gas.number": 400, "run.until": 10}
    return stosszahl.run(root / "cases/quick.toml", keys, out=out, replicas=4, progress=False)


@pytest.fixture(scope="session")
def flow(root, tmp_path_factory):
    """Results of a flow in a channel, with fields."""
    import stosszahl

    fields = {"cells": [12, 8], "blocks": 20, "windows": [[0, 2.5], [2.5, 5]]}
    keys = {"measure.fields": fields, "engine.dsmc-contact-point.simulators_per_particle": 1, "run.samples": 20}
    out = tmp_path_factory.mktemp("results") / "flow"
    return stosszahl.run(root / "cases/channel-disks.toml", keys, out=out, replicas=1, until=5, progress=False)
