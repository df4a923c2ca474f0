"""Cases and results: the folders of the command line, as frames and arrays."""

import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
import threading

import numpy as np
import pandas as pd
import pytest
import stosszahl

SMALL = {"gas.number": 400, "run.until": 10}


def tables(results):
    return {path.name: path.read_bytes() for path in results.folder.glob("*.csv")}


def test_the_folder_is_that_of_the_command_line(program, root, quick, tmp_path):
    keys = [word for key, value in SMALL.items() for word in ("--set", f"{key}={value}")]
    done = program("--", "run", "cases/quick.toml", "--replicas", "4", "--out", str(tmp_path / "there"), *keys)
    assert done.returncode == 0, done.stderr
    there = stosszahl.Results(tmp_path / "there")
    assert tables(there) == tables(quick) and len(tables(quick)) >= 8
    assert there.verdicts == quick.verdicts
    assert quick.report.exists()


def test_a_bundled_case_runs_by_its_name(quick, tmp_path, monkeypatch):
    # From a folder without cases, as after an installation.
    monkeypatch.chdir(tmp_path)
    named = stosszahl.run("quick", {"gas.number": 400, "run.until": 10}, replicas=4, progress=False)
    assert named.folder.resolve() == tmp_path / "results/quick" and tables(named) == tables(quick)
    with pytest.raises(stosszahl.CaseError, match=r"quik: there is no such file, .* \(did you mean quick\?\); `stosszahl cases` lists them"):
        stosszahl.check("quik")


def test_every_bundled_case_is_in_the_package(root, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cases = stosszahl.bundled_cases()
    assert sorted(cases) == sorted(path.stem for path in (root / "cases").glob("*.toml"))
    assert all(question.endswith("?") for question in cases.values())
    for name in cases:
        assert stosszahl.check(name)
    swept = stosszahl.Case.of("quick").swept({"gas.restitution": [0.8, 0.9]})
    assert [point["point"] for point in stosszahl.check(swept)] == ["restitution=0.8", "restitution=0.9"]


def test_types_of_numpy_are_numbers_of_a_case(root):
    gas = {"number": np.int64(100), "restitution": np.float32(0.5), "temperature": np.array(2.0)}
    case = {"format": np.int8(2), "title": "x", "gas": gas, "box": {"size": np.array([20, 20])}, "run": {"until": np.float64(1)}, "engine": {"ed": {}}}
    assert stosszahl.check(case)
    swept = stosszahl.Case.of(case).swept({"gas.restitution": np.linspace(0.8, 0.9, 3), "gas.number": range(100, 102)})
    assert len(stosszahl.check(swept)) == 6
    assert stosszahl.check("quick", {"gas.number": np.int64(100), "gas.restitution": np.float64(0.9)}, replicas=np.int32(4))


def test_a_sweep_that_is_ended_from_outside_is_told():
    case = stosszahl.Case.of("quick").swept({"gas.restitution": [0.8, 0.9]})
    with pytest.warns(UserWarning, match="gas.restitution is set from outside, so that the sweep of the case over it is left out"):
        assert len(stosszahl.check(case, {"gas.restitution": 0.7})) == 1


def test_tables_are_frames_that_know_their_units(quick):
    energy = quick["energy"]
    entry = next(one for one in quick.manifest["tables"] if one["name"] == "energy")
    assert len(energy) == entry["rows"] and list(energy) == [column["name"] for column in entry["columns"]]
    assert pd.api.types.is_float_dtype(energy["energy_ratio"]) and set(energy["engine"]) >= {"ed", "dsmc-contact-point"}
    columns = quick.columns("energy")
    assert columns.loc["energy_ratio_se", "role"] == "standard-error" and columns.loc["energy_ratio", "unit"] == "1"
    assert energy.attrs["units"]["energy_ratio"] == "1"
    start = energy[energy["time"] == 0]
    assert len(start) == 0 or np.all(start["energy_ratio"] == 1)
    assert quick.derived and quick.case["gas"]["number"] == 400
    for name in quick.tables:
        assert len(quick.columns(name)) == quick[name].shape[1]


def test_tables_of_arrow_and_polars(quick, tmp_path, monkeypatch):
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    frame, table = quick["energy"], quick.arrow("energy")
    assert table.column_names == list(frame) and table.num_rows == len(frame)
    assert all(table[name].to_pandas().equals(frame[name].astype(table[name].to_pandas().dtype)) for name in frame)
    field = table.schema.field("energy_ratio_se")
    assert field.type == arrow.float64() and field.metadata[b"unit"] == b"1" and field.metadata[b"role"] == b"standard-error"
    # The same memory, not the same values only.
    (chunk,) = table["energy_ratio"].chunks
    assert chunk.buffers()[1].address + 8 * chunk.offset == frame["energy_ratio"].to_numpy().ctypes.data
    parquet.write_table(table, tmp_path / "energy.parquet")
    again = parquet.read_table(tmp_path / "energy.parquet")
    assert again.equals(table) and again.schema.field("time").metadata[b"meaning"] == table.schema.field("time").metadata[b"meaning"]
    polars = pytest.importorskip("polars").from_arrow(table)
    assert polars.columns == list(frame) and np.array_equal(polars["energy_ratio"].to_numpy(), frame["energy_ratio"])
    assert polars["engine"].to_list() == frame["engine"].to_list()
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(stosszahl.PackageError, match="tables of Arrow need the package pyarrow: .*pip install pyarrow"):
        quick.arrow("energy")


def test_verdicts_are_in_words(quick):
    assert quick.verdicts and all(one.kind in ("agree", "differ", "undecided", "void", "warning", "note") for one in quick.verdicts)
    assert quick.verdicts[0].sentence in quick._repr_html_()


def test_snapshots_are_arrays(quick):
    snapshot = next(one for one in quick.snapshots if one.engine == "ed")
    assert len(snapshot) == 400 and snapshot.positions.shape == snapshot.velocities.shape == (400, 3)
    side = np.array(snapshot.box[:2])
    assert np.all((snapshot.positions[:, :2] >= 0) & (snapshot.positions[:, :2] < side))
    away = snapshot.positions[:, None, :2] - snapshot.positions[None, :, :2]
    away -= side * np.round(away / side)
    distance = np.linalg.norm(away, axis=2)[np.triu_indices(400, 1)]
    # Disks of one diameter do not overlap, but for rounding.
    assert distance.min() >= 2 * snapshot.radii[0] - 1e-9


def test_snapshots_at_an_interval_of_chosen_engines(root, tmp_path):
    keys = {**SMALL, "measure.snapshots.interval": 2.5, "measure.snapshots.engines": ["ed"]}
    options = {"out": tmp_path / "quick", "replicas": 1, "progress": False}
    results = stosszahl.run(root / "cases/quick.toml", keys, **options)
    assert [(one.engine, one.time) for one in results.snapshots] == [("ed", time) for time in (0, 2.5, 5, 7.5, 10)]
    assert {one.periodic for one in results.snapshots} == {(True, True, False)}
    for bad in ({"interval": 1e-9}, {"times": [1]}, {"engines": ["dsmc-esmc"]}):
        keys = {"measure.snapshots.interval": 1.0, **{f"measure.snapshots.{key}": value for key, value in bad.items()}}
        with pytest.raises(stosszahl.CaseError, match="measure.snapshots"):
            stosszahl.check(root / "cases/quick.toml", keys)


def test_snapshots_name_the_species(root, tmp_path):
    options = {"out": tmp_path / "binary", "replicas": 1, "until": 1, "progress": False}
    keys = {"measure.impact_parameters.windows": [[0, 1]], "engine.dsmc-contact-point.simulators_per_particle": 1}
    results = stosszahl.run(root / "cases/binary-disks.toml", keys, **options)
    assert {one.engine for one in results.snapshots} == {"ed", "dsmc-contact-point"}
    for snapshot in results.snapshots:
        assert np.bincount(snapshot.species).tolist() == [200, 200]
        assert np.array_equal(snapshot.masses, np.array([1, 4])[snapshot.species])
        assert np.array_equal(snapshot.radii, np.array([0.5, 1])[snapshot.species])


def test_the_manifest_names_the_commit(quick, root):
    head = subprocess.run(["git", "rev-parse", "--short=12", "HEAD"], cwd=root, capture_output=True, text=True)
    if head.returncode == 0:
        assert re.fullmatch("[0-9a-f]{12}(, changed)?", quick.manifest["program"]["commit"])


def test_figures_for_papers_are_those_of_the_command_line(program, quick, tmp_path):
    assert quick.paper_figures["energy"] == "Energy"
    for columns, width in ((1, 86), (2, 178)):
        figure = quick.paper_figure("energy", columns)
        assert (figure.name, figure.title, figure.width) == ("energy", "Energy", pytest.approx(width)) and 40 < figure.height < 120
        for ending, contents in (("svg", figure.svg.encode()), ("pdf", figure.pdf)):
            there = tmp_path / f"there.{ending}"
            done = program("--", "figure", str(quick.folder), "energy", "--columns", str(columns), "--out", str(there))
            assert done.returncode == 0, done.stderr
            assert figure.save(tmp_path / f"here.{ending}").read_bytes() == there.read_bytes() == contents
    assert figure._repr_svg_() == figure.svg and figure.svg not in repr(figure)
    assert f'width="{120.5}mm"' in quick.paper_figure("energy", width=120.5).svg
    refusals = [
        (lambda: quick.paper_figure("enrgy"), r"no figure is called enrgy \(did you mean energy\?\); its figures are energy"),
        (lambda: quick.paper_figure("energy", 3), "number of columns is 3; allowed: whole numbers from 1 to 2"),
        (lambda: quick.paper_figure("energy", width=10), "a width of 10 mm; allowed is 60 to 400 mm"),
        (lambda: quick.paper_figure("energy", width="wide"), "width is 'wide'; allowed: a number"),
        (lambda: figure.save(tmp_path / "x.png"), r"allowed: a file that ends in .svg or .pdf"),
    ]
    for refused, words in refusals:
        with pytest.raises(stosszahl.ResultsError, match=words):
            refused()
    assert not (tmp_path / "x.png").exists()


def test_every_figure_can_be_drawn(quick, tmp_path):
    import matplotlib.pyplot as plt

    drawn = 0
    for entry in quick.manifest["tables"]:
        for number in range(len(entry["figures"])):
            figure = quick.figure(entry["name"], number)
            assert any(axes.has_data() for axes in figure.axes), entry["name"]
            plt.close(figure)
            drawn += 1
    assert drawn >= 5
    quick.figure("energy").savefig(tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 5000


def test_check_says_what_a_case_means(root):
    (outline,) = stosszahl.check(root / "cases/quick.toml", {"gas.restitution": 0.9}, replicas=2)
    assert outline["replicas"] == 2 and "ed" in outline["engines"] and outline["seconds"] > 0
    assert any(one["name"].replace("_", " ") == "mean free path" for one in outline["derived"])


def test_a_dictionary_is_a_case_and_a_sweep_has_points(tmp_path):
    case = {
        "format": 2,
        "title": "Cooling",
        "gas": {"number": 100, "restitution": 0.9},
        "box": {"packing_fraction": 0.1},
        "run": {"until": 2},
        "engine": {"ed": {}},
    }
    shares = []
    over = {"gas.restitution": np.array([0.7, 0.9])}
    results = stosszahl.sweep(case, over, out=tmp_path / "sweep", progress=lambda share, collisions: shares.append(share))
    assert results.is_sweep and list(results.points) == ["restitution=0.7", "restitution=0.9"]
    assert shares == sorted(shares) and shares[-1] == 1.0
    energy = results["energy"]
    assert list(energy)[0] == "gas.restitution" and set(energy["gas.restitution"]) == {0.7, 0.9}
    last = energy.groupby("gas.restitution")["energy_ratio"].last()
    assert last[0.7] > 0 and len(energy) == sum(len(point["energy"]) for point in results.points.values())
    if importlib.util.find_spec("pyarrow"):
        assert results.arrow("energy").column_names == list(energy)
    with pytest.raises(stosszahl.ResultsError, match="of one of its points"):
        results.figure("energy")
    assert stosszahl.report(tmp_path / "sweep") == results.report


def test_folders_are_refused_resumed_and_replaced(root, quick, tmp_path):
    keys, out = SMALL, tmp_path / "quick"
    shutil.copytree(quick.folder, out)
    options = {"out": out, "replicas": 4, "progress": False}
    with pytest.raises(stosszahl.ResultsError, match="exists"):
        stosszahl.run(root / "cases/quick.toml", keys, **options)
    again = stosszahl.run(root / "cases/quick.toml", keys, resume=True, **options)
    assert tables(again) == tables(quick)


def test_ctrl_c_leaves_a_folder_that_goes_on_to_the_same_tables(root, quick, tmp_path):
    out = tmp_path / "quick"
    options = {"out": out, "replicas": 4}

    def interrupt(share, collisions):
        if collisions > 0:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt, match="resume=True"):
        stosszahl.run(root / "cases/quick.toml", SMALL, progress=interrupt, **options)
    assert not (out / "manifest.json").exists() and (out / "run.json").exists()
    done = stosszahl.run(root / "cases/quick.toml", SMALL, resume=True, progress=False, **options)
    assert tables(done) == tables(quick)


def test_an_exception_in_progress_stops_the_run(root, tmp_path):
    def refuse(share, collisions):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        stosszahl.run(root / "cases/quick.toml", SMALL, out=tmp_path / "quick", progress=refuse)


def test_a_run_in_another_thread(root, quick, tmp_path):
    found = []
    thread = threading.Thread(
        target=lambda: found.append(
            stosszahl.run(root / "cases/quick.toml", SMALL, out=tmp_path / "quick", replicas=4, progress=False)
        )
    )
    thread.start()
    thread.join()
    assert tables(found[0]) == tables(quick)


def test_the_schema_is_json():
    assert "properties" in stosszahl.schema()
