"""Mistakes, and the exception of each: it says what was found and what is allowed, as the command line does."""

import re
from pathlib import Path

import numpy as np
import pytest
import stosszahl
from stosszahl import CaseError, EventDriven, Gas, GasError, MonteCarlo, ResultsError, Wall

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


def positions(values):
    return Gas.disks(2, box_size=(9, 9), positions=values)


def back():
    engine = EventDriven(Gas.disks(10))
    engine.advance(1)
    engine.advance(0.5)


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
    "outside": (
        lambda: Gas.disks(1, box_size=(9, 9), positions=[[1, 10]], walls={"y": (Wall(), Wall())}),
        GasError,
        "particle 0 at 10 along axis 1 of a box of 9; allowed: positions inside",
    ),
    "overlap": (overlapping, GasError, "overlap"),
    "scheme": (lambda: MonteCarlo.from_state(Gas.disks(10), "bolzmann"), GasError, 'scheme "bolzmann" is not known; allowed: .*boltzmann'),
    "exact spheres": (lambda: EventDriven(Gas.spheres(10)), GasError, "^exact dynamics of a gas without positions; use Monte Carlo, or a gas of disks$"),
    "no time": (lambda: EventDriven(Gas.disks(10)).advance(float("nan")), GasError, "time NaN from time 0; allowed: finite times"),
    "infinity": (lambda: EventDriven(Gas.disks(10)).advance(float("inf")), GasError, "time inf from time 0; allowed: finite times"),
    "years": (lambda: EventDriven(Gas.disks(10)).advance(1e308), GasError, "time 1e308 from time 0; allowed: times up to 1e100"),
    "years of steps": (lambda: MonteCarlo.from_state(Gas.disks(10)).advance(1e30), GasError, "allowed: times up to about"),
    "past": (back, GasError, "time 0.5 from time 1; allowed: the present time 1 or later"),
    "three of two": (
        lambda: Gas.disks(2, box_size=(9, 9), positions=np.zeros((3, 2))),
        GasError,
        "positions are 3 in a gas of 2 disks; allowed: one for each disk",
    ),
    "box twice": (lambda: Gas.disks(10, packing_fraction=0.1, box_size=(9, 9)), GasError, "together; give one of them"),
    "contact time": (lambda: Gas.disks(10, contact_time=-1), GasError, "contact time is -1; allowed: finite numbers from 0"),
    "masked": (lambda: positions(np.ma.masked_less([[1.0, 1.0], [4.0, 4.0]], 2)), GasError, "positions has masked entries"),
    "complex": (lambda: positions(np.ones((2, 2), dtype=complex)), GasError, "the type complex128; allowed: real numbers"),
    "dates": (lambda: positions(np.zeros((2, 2), dtype="datetime64[s]")), GasError, r"the type datetime64\[s\]; allowed"),
    "words": (lambda: positions([["1", "1"], ["4", "4"]]), GasError, "allowed: real numbers"),
    "ragged": (lambda: positions([[1], [4, 4]]), GasError, "positions is no array"),
    "memory": (lambda: Gas.spheres(4_000_000_000), stosszahl.OutOfMemoryError, "particles need .* GiB of memory; .* are free"),
    "an observer as a gas": (lambda: EventDriven(stosszahl.ImpactParameters()), GasError, "the start is <ImpactParameters"),
    "observer": (lambda: EventDriven(Gas.disks(10)).advance(1, 5), GasError, "observer is 5; allowed: a function"),
    "in the middle": (at_work, stosszahl.EngineError, "the engine is at work"),
    "no case": (lambda: stosszahl.check("nowhere.toml"), CaseError, "nowhere.toml: there is no such file, and no bundled case of that name"),
    "unknown key": (lambda: stosszahl.check({**CASE, "gaz": {}}), CaseError, "unknown key gaz.*did you mean gas"),
    "bad value": (lambda: stosszahl.check(CASE, {"gas.restitution": 1.5}), CaseError, r"--set gas.restitution=1.5: gas.restitution = 1.5 is refused; the rule: a number from 0 to 1"),
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


ODD = [None, "four", b"4", True, 1 + 2j, [1], {}, object(), np.datetime64("2026-01-01"), float("nan"), 10**400]
"""Values of the wrong type, or out of every range."""
CALLS = {
    "number": lambda x: Gas.disks(x),
    "packing_fraction": lambda x: Gas.disks(10, packing_fraction=x),
    "box_size": lambda x: Gas.disks(10, box_size=x),
    "half of box_size": lambda x: Gas.disks(10, box_size=(9, x)),
    "restitution": lambda x: Gas.disks(10, restitution=x),
    "viscoelastic": lambda x: Gas.disks(10, restitution=stosszahl.Viscoelastic(x)),
    "coefficient": lambda x: Gas.disks(10, restitution=stosszahl.DeltaModel(x, 0.1)),
    "delta": lambda x: Gas.disks(10, restitution=stosszahl.DeltaModel(0.9, x)),
    "elastic_below": lambda x: Gas.disks(10, restitution=stosszahl.ThresholdModel(0.9, x)),
    "shear_rate": lambda x: Gas.disks(10, shear_rate=x),
    "tangential_restitution": lambda x: Gas.disks(10, tangential_restitution=x),
    "species": lambda x: Gas.disks(10, species=x),
    "one species": lambda x: Gas.disks(10, species=[(10, x, 1)]),
    "walls": lambda x: Gas.disks(10, walls=x),
    "faces": lambda x: Gas.disks(10, walls={"y": x}),
    "wall": lambda x: Gas.disks(10, walls={"y": (Wall(restitution=x), Wall(vibration=x))}),
    "gravity": lambda x: Gas.disks(10, gravity=x),
    "contact_time": lambda x: Gas.disks(10, contact_time=x),
    "temperature": lambda x: Gas.spheres(10, temperature=x),
    "seed": lambda x: Gas.disks(10, seed=x),
    "replica": lambda x: Gas.disks(10, replica=x),
    "positions": lambda x: Gas.disks(10, box_size=(9, 9), positions=x),
    "velocities": lambda x: Gas.disks(10).with_velocities(x),
    "gas": lambda x: EventDriven(x),
    "gas without positions": lambda x: MonteCarlo(x),
    "gas in cells": lambda x: MonteCarlo.from_state(x),
    "scheme": lambda x: MonteCarlo.from_state(Gas.disks(10), x),
    "cell_size": lambda x: MonteCarlo.from_state(Gas.disks(10), cell_size=x),
    "until": lambda x: EventDriven(Gas.disks(10)).advance(x),
    "observer": lambda x: EventDriven(Gas.disks(10)).advance(1, x),
    "batch": lambda x: EventDriven(Gas.disks(10)).advance(1, len, batch=x),
    "collisions": lambda x: EventDriven(Gas.disks(10)).equilibrate(x),
    "kick": lambda x: EventDriven(Gas.disks(10)).kick(x),
    "factor": lambda x: EventDriven(Gas.disks(10)).scale_velocities(x),
    "dimension": lambda x: stosszahl.ImpactParameters(x),
    "bins": lambda x: stosszahl.ImpactParameters(2, x),
    "most": lambda x: stosszahl.CollisionLog(x),
    "path of a log": lambda x: stosszahl.CollisionLog().write(x),
    "case": lambda x: stosszahl.check(x),
    "keys": lambda x: stosszahl.check(CASE, x),
    "value": lambda x: stosszahl.check(CASE, {"gas.restitution": x}),
    "value of a table": lambda x: stosszahl.check({**CASE, "gas": x}),
    "until of a case": lambda x: stosszahl.check(CASE, until=x),
    "replicas": lambda x: stosszahl.check(CASE, replicas=x),
    "seed of a case": lambda x: stosszahl.check(CASE, seed=x),
    "threads": lambda x: stosszahl.check(CASE, threads=x),
    "out": lambda x: stosszahl.run(CASE, out=x, threads=0, progress=False),
    "progress": lambda x: stosszahl.run(CASE, progress=x, threads=0, out="never"),
    "sweep": lambda x: stosszahl.sweep(CASE, x, threads=0, out="never", progress=False),
    "values": lambda x: stosszahl.sweep(CASE, {"gas.restitution": x}, threads=0, out="never", progress=False),
    "folder": lambda x: stosszahl.Results(x),
    "report": lambda x: stosszahl.report(x),
    "trajectory": lambda x: stosszahl.trajectory(x),
    "times": lambda x: stosszahl.trajectory(EventDriven(Gas.disks(10)), x),
    "snapshots": lambda x: stosszahl.Trajectory(x),
}
FINE = {
    "None": {"packing_fraction", "box_size", "tangential_restitution", "walls", "gravity", "shear_rate", "positions", "cell_size", "observer", "keys", "threads"}
    | {"until of a case", "replicas", "seed of a case"},
    "{}": {"walls", "species", "keys", "times", "snapshots"},
    "[1]": {"times"},
}
"""Names of calls for which a value is allowed after all."""


@pytest.mark.parametrize("name", CALLS)
def test_wrong_types_are_errors_of_the_package(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for value in ODD:
        try:
            CALLS[name](value)
        except stosszahl.Error:
            continue
        assert name in FINE.get(str(value), set()), value
    assert list(tmp_path.iterdir()) == []


def test_memory_that_is_not_there_is_an_error_of_memory():
    import resource

    with pytest.raises(MemoryError):
        Gas.disks(4_000_000_000)
    # A limit of the process counts too, not only the end of memory.
    limit, hard = resource.getrlimit(resource.RLIMIT_AS)
    taken = int(next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmSize"))) * 1024
    resource.setrlimit(resource.RLIMIT_AS, (taken + 2**28, hard))
    try:
        with pytest.raises(MemoryError, match="particles need"):
            Gas.spheres(10_000_000)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
