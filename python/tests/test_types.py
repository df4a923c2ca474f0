"""Types: the package is typed throughout, its stubs are those of the module, and a user's mistakes are found."""

import subprocess
import sys

PROGRAM = """
from stosszahl import EventDriven, Gas

engine = EventDriven(Gas.disks(100, packing_fraction=0.1, restitution=0.9))
engine.advance(1.0, lambda collisions: None)
temperature: float = engine.temperature
"""


def checked(*arguments):
    return subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True, timeout=300)


def test_the_package_is_typed():
    found = checked("mypy", "--strict", "--ignore-missing-imports", "--package", "stosszahl")
    assert found.returncode == 0, found.stdout


def test_stubs_are_those_of_the_module():
    found = checked("mypy.stubtest", "stosszahl._native", "--ignore-disjoint-bases")
    assert found.returncode == 0, found.stdout


def test_a_program_is_checked(tmp_path):
    for line, fault in (("", None), ("number: int = engine.positions\n", "Incompatible types in assignment")):
        path = tmp_path / "program.py"
        path.write_text(PROGRAM + line)
        found = checked("mypy", "--strict", "--ignore-missing-imports", str(path))
        assert (found.returncode != 0) == (fault is not None), found.stdout
        assert fault is None or fault in found.stdout, found.stdout
