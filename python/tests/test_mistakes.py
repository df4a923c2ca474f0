"""Mistakes, and the exception of each: it says what was found and what is allowed, as the command line does."""

import re
from pathlib import Path

import numpy as np
import pytest
import stosszahl
from stosszahl import CaseError, EventDriven, Gas, GasError, MonteCarlo, ResultsError

CASE = {
    "format": 2,
    "title": "Cooling",
    "gas": {"number": 100, "restitution": 0.9},
    "box": {"packing_fraction": 0.1},
    "run": {"until": 1},
    "engine": {"ed": {}},
}


def overlapping():
    gas = Gas.disks(2, box_size=(10, 10), positions=[[1, 1], [1.5, 1]])
    EventDriven(gas)


def at_work():
    engine = EventDriven(Gas.disks(100))
    engine.advance(10.0, lambda collisions: engine.time, batch=10)


MISTAKES = {
    "restitution": (lambda: Gas.disks(10, restitution=1.5), GasError, "restitution.* is 1.5.*; allowed"),
    "negative temperature": (lambda: Gas.disks(10, temperature=-1), GasError, "temperature is -1.*; allowed: finite numbers above 0"),
    "too dense": (lambda: Gas.disks(100, packing_fraction=0.95), GasError, "do not fit.*allowed"),
    "half a disk": (lambda: Gas.disks(10.5), GasError, "number is 10.5; allowed: whole numbers"),
    "no such axis": (lambda: Gas.disks(10, walls={"z": ("open", "open")}), GasError, "walls along 'z'; allowed: 'x' and 'y'"),
    "shape": (lambda: Gas.disks(2, box_size=(9, 9), positions=np.zeros(4)), GasError, r"positions has the shape \(4,\); allowed: \(any, 2\)"),
    "outside": (lambda: Gas.disks(1, box_size=(9, 9), positions=[[1, 10]]), GasError, "particle 0 at 10 along axis 1 of a box of 9; allowed: positions inside"),
    "overlap": (overlapping, GasError, "overlap"),
    "scheme": (lambda: MonteCarlo.from_state(Gas.disks(10), "bolzmann"), GasError, 'scheme "bolzmann" is not known; allowed: .*boltzmann'),
    "exact spheres": (lambda: EventDriven(Gas.spheres(10)), GasError, "^exact dynamics of a gas without positions; use Monte Carlo, or a gas of disks$"),
    "no time": (lambda: EventDriven(Gas.disks(10)).advance(float("nan")), GasError, "no number; allowed: a time"),
    "observer": (lambda: EventDriven(Gas.disks(10)).advance(1, 5), GasError, "observer is 5; allowed: a function"),
    "in the middle": (at_work, stosszahl.EngineError, "the engine is at work"),
    "no case": (lambda: stosszahl.check("nowhere.toml"), CaseError, "nowhere.toml: the case file cannot be read"),
    "unknown key": (lambda: stosszahl.check({**CASE, "gaz": {}}), CaseError, "unknown key gaz.*did you mean gas"),
    "bad value": (lambda: stosszahl.check(CASE, {"gas.restitution": 1.5}), CaseError, r"--set gas.restitution=1.5: .*not allowed"),
    "threads": (lambda: stosszahl.run(CASE, threads=0, out="never", progress=False), stosszahl.RunError, "0 threads; allowed: from 1"),
    "no results": (lambda: stosszahl.Results("/"), ResultsError, "neither manifest.json nor sweep.json"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistake(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    make, kind, message = MISTAKES[name]
    with pytest.raises(kind) as caught:
        make()
    assert re.search(message, str(caught.value), re.DOTALL), caught.value
    assert isinstance(caught.value, stosszahl.Error)
    assert list(tmp_path.iterdir()) == []


def rows_of_the_docs():
    text = (Path(__file__).resolve().parents[2] / "docs/python.md").read_text(encoding="utf-8")
    return re.findall(r"^\| `(.+)` \| `(\w+Error)` \| (.+) \|$", text.partition("## Errors")[2], re.MULTILINE)


def test_the_docs_have_ten_mistakes():
    assert len(rows_of_the_docs()) == 10 and {kind for _, kind, _ in rows_of_the_docs()} > {"GasError", "CaseError", "ResultsError"}


@pytest.mark.parametrize(("code", "kind", "message"), rows_of_the_docs())
def test_a_mistake_of_the_docs(root, tmp_path, monkeypatch, code, kind, message):
    (tmp_path / "cases").symlink_to(root / "cases")
    monkeypatch.chdir(tmp_path)
    names = {**vars(stosszahl), "engine": EventDriven(Gas.disks(100))}
    with pytest.raises(stosszahl.Error) as caught:
        exec(code, names)
    assert type(caught.value).__name__ == kind and str(caught.value).splitlines()[0] == message
    assert [path.name for path in tmp_path.iterdir()] == ["cases"]


def test_the_message_is_that_of_the_command_line(program, tmp_path):
    case = tmp_path / "bad.toml"
    case.write_text('format = 2\ntitle = "x"\n[gas]\nnumber = 10\nrestitution = 1.5\n[box]\npacking_fraction = 0.1\n')
    said = program("--", "check", str(case))
    assert said.returncode == 2
    with pytest.raises(CaseError) as caught:
        stosszahl.check(case)
    assert f"error: {caught.value}" == said.stderr.rstrip("\n")
    error = caught.value
    assert (error.key, error.line) == ("gas.restitution", 5)


def test_messages_of_results_are_those_of_the_command_line(program, tmp_path):
    said = program("--", "report", str(tmp_path))
    with pytest.raises(ResultsError) as caught:
        stosszahl.Results(tmp_path)
    assert f"error: {caught.value}" == said.stderr.rstrip("\n")
