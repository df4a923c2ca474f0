"""Files, each opened by its program; programs that are not installed are skipped."""

import json
import sys

import numpy as np
import pytest
import stosszahl
from stosszahl import EventDriven, Gas, MonteCarlo, Trajectory, trajectory

TIMES = [0.0, 1.0, 2.0]


@pytest.fixture(scope="module")
def frames():
    engine = EventDriven(Gas.disks(200, box_size=(30, 20), restitution=0.9, walls={"y": (stosszahl.Wall(), stosszahl.Wall())}))
    return trajectory(engine, TIMES)


def same(frames, time, read):
    return [np.array_equal(one.positions, positions) for one, positions in zip(frames, read)] == [True] * len(TIMES) and np.array_equal(time, TIMES)


def test_npz(frames, tmp_path):
    read = np.load(frames.write(tmp_path / "x.npz"))
    assert same(frames, read["time"], read["positions"]) and read["periodic"].tolist() == [True, False, False]
    assert np.array_equal(read["box"], [[30, 20, 1]] * 3)


def test_extended_xyz_with_ase(frames, tmp_path):
    ase_io = pytest.importorskip("ase.io")
    read = ase_io.read(frames.write(tmp_path / "x.xyz"), index=":")
    assert same(frames, [one.info["Time"] for one in read], [one.positions for one in read])
    assert np.array_equal(read[1].arrays["velo"], frames[1].velocities) and np.array_equal(read[0].arrays["radius"], frames[0].radii)
    assert read[0].pbc.tolist() == [True, False, False] and read[0].cell.lengths().tolist() == [30, 20, 1]


def test_dump_with_ase_and_as_a_start(frames, tmp_path):
    ase_io = pytest.importorskip("ase.io")
    read = ase_io.read(frames.write(tmp_path / "x.dump"), index=":", format="lammps-dump-text")
    assert [np.array_equal(one.positions, atoms.positions) for one, atoms in zip(frames, read)] == [True] * len(TIMES)
    assert read[0].pbc.tolist() == [True, False, False] and read[0].cell.lengths().tolist() == [30, 20, 1]
    # One frame is a start file: the same microstate in an engine.
    file = frames[2:].write(tmp_path / "one.dump")
    case = {
        "format": 2,
        "title": "a start from a dump",
        "replicas": 1,
        "gas": {"restitution": 0.9},
        "start": {"placement": "file", "velocities": "file", "file": str(file)},
        "box": {},
        "walls": {"bottom": {"restitution": 1.0}, "top": {"restitution": 1.0}},
        "run": {"time_unit": "case", "until": 1.0},
        "engine": {"ed": {}},
        "measure": {"snapshots": {"times": [0.0]}},
    }
    results = stosszahl.run(case, out=tmp_path / "out")
    assert np.array_equal(results.snapshots[0].positions, frames[2].positions)
    assert np.array_equal(results.snapshots[0].velocities, frames[2].velocities)


def test_gsd(frames, tmp_path):
    hoomd = pytest.importorskip("gsd.hoomd")
    with hoomd.open(frames.write(tmp_path / "x.gsd")) as file:
        assert len(file) == 3
        for one, frame in zip(frames, file):
            # Single precision, around the middle of the box.
            assert np.abs(frame.particles.position + [15, 10, 0] - one.positions).max() < 30 * 2**-23
            assert frame.configuration.dimensions == 2 and frame.configuration.box[:2].tolist() == [30, 20]
            assert np.all(frame.particles.diameter == 1) and frame.log["time"] == one.time


def test_h5md(frames, tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(frames.write(tmp_path / "x.h5")) as file:
        group = file["particles/all"]
        assert same(frames, group["position/time"][:], group["position/value"][:])
        assert np.array_equal(group["velocity/value"][2], frames[2].velocities)
        assert [one.decode() for one in group["box"].attrs["boundary"]] == ["periodic", "none", "none"]
        assert np.array_equal(group["velocity/step"][:], group["box/edges/step"][:])


@pytest.fixture(scope="module")
def mixture():
    """Rough disks of two species, of which none spins in the first frame."""
    gas = Gas.disks(80, species=[(40, 0.8, 2.0)], box_size=(30, 20), restitution=0.9, tangential_restitution=0.4)
    frames = trajectory(EventDriven(gas), TIMES)
    assert not np.any(frames[0].spins) and np.any(frames[2].spins) and set(frames[0].species) == {0, 1}
    return frames


def test_species_and_spins_in_all_formats(mixture, tmp_path):
    last = mixture[2]
    arrays = np.load(mixture.write(tmp_path / "x.npz"))
    assert np.array_equal(arrays["species"][2], last.species) and np.array_equal(arrays["spins"][2], last.spins)
    atoms = pytest.importorskip("ase.io").read(mixture.write(tmp_path / "x.xyz"), index=2)
    assert np.array_equal(atoms.arrays["type"], last.species) and np.array_equal(atoms.arrays["angular_velocity"], last.spins)
    with pytest.importorskip("gsd.hoomd").open(mixture.write(tmp_path / "x.gsd")) as file:
        assert np.array_equal(file[2].particles.typeid, last.species) and file[2].particles.types == ["0", "1"]
    with pytest.importorskip("h5py").File(mixture.write(tmp_path / "x.h5")) as file:
        group = file["particles/all"]
        assert np.array_equal(group["species"], last.species) and np.array_equal(group["angular_velocity/value"][2], last.spins)


def test_neighbours_with_freud(tmp_path):
    freud = pytest.importorskip("freud")
    hoomd = pytest.importorskip("gsd.hoomd")
    engine = EventDriven(Gas.disks(400, packing_fraction=0.3, seed=3))
    engine.equilibrate(20)
    state = engine.state()
    (frame,) = Trajectory([state])
    with hoomd.open(Trajectory([state]).write(tmp_path / "x.gsd")) as file:
        box, points = freud.box.Box.from_box(file[0].configuration.box), file[0].particles.position
    found = freud.locality.AABBQuery(box, points).query(points, {"r_max": 1.5, "exclude_ii": True}).toNeighborList()
    away = frame.positions[:, None] - frame.positions[None]
    away -= np.array(frame.box) * np.round(away / frame.box)
    near = np.linalg.norm(away, axis=2) < 1.5
    assert len(found) == near.sum() - len(frame) > 400


def test_files_of_a_sheared_gas_have_its_lattice(tmp_path):
    ase_io, freud, hoomd = pytest.importorskip("ase.io"), pytest.importorskip("freud"), pytest.importorskip("gsd.hoomd")
    frames = trajectory(EventDriven(Gas.disks(200, box_size=(30, 20), shear_rate=0.5, restitution=0.9)), [0.0, 2.0, 4.0])
    # 0.5 * 20 * 2 = 20 and 40, folded into the width.
    assert [one.shear_offset for one in frames] == pytest.approx([0, 20, 10], abs=1e-12)

    def neighbours(one):
        away = one.positions[:, None] - one.positions[None]
        boxes = np.round(away[..., 1] / 20)
        away[..., 0] -= boxes * one.shear_offset
        away[..., 1] -= boxes * 20
        away[..., 0] -= 30 * np.round(away[..., 0] / 30)
        # In reach of 5 the nearest image by axis is the nearest of all.
        return {(int(i), int(j)) for i, j in zip(*np.nonzero(np.linalg.norm(away, axis=2) < 2.5)) if i < j}

    with hoomd.open(frames.write(tmp_path / "x.gsd")) as file:
        for one, frame in zip(frames, file):
            box, points = freud.box.Box.from_box(frame.configuration.box), frame.particles.position
            found = freud.locality.AABBQuery(box, points).query(points, {"r_max": 2.5, "exclude_ii": True}).toNeighborList()
            pairs = {(int(i), int(j)) for i, j in found[:] if i < j}
            # Single precision moves a distance by 1e-6, over which none of 700 pairs lies here.
            assert len(pairs) > 300 and pairs == neighbours(one)
            # All are in the cell already: freud moves them by its rounding alone.
            assert np.abs(box.wrap(points) - points).max() < 1e-4
    for name, kind in (("x.xyz", {}), ("x.dump", {"format": "lammps-dump-text"})):
        for one, atoms in zip(frames, ase_io.read(frames.write(tmp_path / name), index=":", **kind)):
            distances = atoms.get_all_distances(mic=True)
            pairs = {(int(i), int(j)) for i, j in zip(*np.nonzero(distances < 2.5)) if i < j}
            assert pairs == neighbours(one), name
    with pytest.importorskip("h5py").File(frames.write(tmp_path / "x.h5")) as file:
        assert file["particles/all/box/edges/value"].shape == (3, 3, 3)


FORMATS = {"xyz": "xyz", "lammps": "dump", "gsd": "gsd", "h5md": "h5"}


@pytest.fixture(scope="module", params=["walls", "shear"])
def written(request, tmp_path_factory):
    """Snapshots that a run wrote in all formats, of two species: between walls, and in a shear flow."""
    case = {
        "format": 2,
        "title": "files of a run",
        "replicas": 1,
        "seed": 4,
        "gas": {"restitution": 0.9},
        "species": [{"number": 150}, {"number": 50, "diameter": 0.8, "mass": 2.0}],
        "box": {"size": [30, 20]},
        "run": {"time_unit": "case", "until": 2.0},
        "engine": {"ed": {}},
        "measure": {"snapshots": {"times": [0.0, 2.0], "formats": [*FORMATS]}},
    }
    if request.param == "walls":
        case["walls"] = {"bottom": {"restitution": 0.9}, "top": {"restitution": 0.9}}
        case["measure"]["fields"] = {"cells": [2, 2], "blocks": 1}
        case["run"]["samples"] = 2
    else:
        case["box"]["shear_rate"] = 0.35
    results = stosszahl.run(case, out=tmp_path_factory.mktemp("written") / "out", progress=False)
    one = results.snapshots[1]
    # Of each snapshot one is read, the one with all digits.
    assert [(one.time, one.species.max()) for one in results.snapshots] == [(0, 1), (2, 1)]
    assert one.shear_offset == pytest.approx(14 if request.param == "shear" else 0, abs=1e-12)
    files = {name: results.folder / f"snapshots/ed-1.{ending}" for name, ending in FORMATS.items()}
    assert sorted(results.folder.glob("snapshots/ed-1.*")) == sorted(files.values())
    return one, files


def tilt_of(one):
    width = one.box[0]
    return one.shear_offset - width * round(one.shear_offset / width)


def assert_particles(one, positions, rounding):
    """Positions are those of a snapshot, but for whole widths that a tilted box adds, and rounding."""
    away = np.asarray(positions, dtype=np.float64) - one.positions
    away[:, 0] -= one.box[0] * np.round(away[:, 0] / one.box[0])
    assert np.abs(away).max() <= rounding
    if not one.shear_offset:
        assert np.abs(positions - one.positions).max() <= rounding


# Rounding of a position of at most 30 by single precision, from the middle of the box; and of three numbers of all digits.
SINGLE, DOUBLE = 30 * 2**-24, 3 * 30 * 2**-53


def test_files_of_a_run_with_gsd(written):
    one, files = written
    with pytest.importorskip("gsd.hoomd").open(files["gsd"]) as file:
        (frame,) = file
    box, tilt = frame.configuration.box, tilt_of(one)
    assert box.tolist() == pytest.approx([30, 20, 0, tilt / 20, 0, 0], rel=2**-23)
    assert (frame.configuration.step, frame.configuration.dimensions, frame.particles.N) == (1, 2, 200)
    assert_particles(one, frame.particles.position + np.array([(30 + tilt) / 2, 10, 0]), 2 * SINGLE)
    assert np.array_equal(frame.particles.velocity, one.velocities.astype(np.float32))
    assert np.array_equal(frame.particles.diameter, (2 * one.radii).astype(np.float32))
    assert np.array_equal(frame.particles.mass, one.masses.astype(np.float32))
    assert frame.particles.types == ["0", "1"] and np.array_equal(frame.particles.typeid, one.species)
    assert frame.log["time"] == pytest.approx([2.0], rel=1e-14) and frame.log["periodic"].astype(bool).tolist() == list(one.periodic)


def test_files_of_a_run_with_ase(written):
    ase_io = pytest.importorskip("ase.io")
    one, files = written
    for name, kind in (("xyz", {}), ("lammps", {"format": "lammps-dump-text"})):
        atoms = ase_io.read(files[name], **kind)
        assert_particles(one, atoms.positions, DOUBLE)
        assert tuple(atoms.pbc) == one.periodic
        assert atoms.cell.array.diagonal() == pytest.approx(one.box, rel=2**-51)
        assert (atoms.cell.array[1, 0] - one.shear_offset + 1) % 30 == pytest.approx(1, abs=DOUBLE)
        # ASE takes velocities of dumps to be in units of LAMMPS.
        speeds = atoms.arrays["velo"] if name == "xyz" else None
        assert speeds is None or np.array_equal(speeds, one.velocities)
        assert np.array_equal(atoms.arrays["type"] - (name == "lammps"), one.species)


def test_files_of_a_run_with_ovito(written):
    pytest.importorskip("ovito.data", exc_type=ImportError)
    from ovito.io import import_file

    one, files = written
    # OVITO reads no H5MD.
    for name, path in ((name, path) for name, path in files.items() if name != "h5md"):
        data = import_file(str(path)).compute()
        particles, rounding = data.particles, {"gsd": 4 * SINGLE}.get(name, 30 * 2**-50)
        assert_particles(one, particles.positions - data.cell[:, 3], rounding)
        assert np.array_equal(particles.particle_types - (name == "lammps"), one.species)
        assert np.abs(particles.velocities - one.velocities).max() <= 8 * 2 ** (-24 if name == "gsd" else -50)
        # OVITO has radii of single precision.
        assert np.abs(particles["Radius"] - one.radii).max() <= 2**-24
        assert np.abs(particles.masses - one.masses).max() <= 2 ** (-24 if name == "gsd" else -50)
        # HOOMD takes all axes to be periodic.
        assert name == "gsd" or tuple(data.cell.pbc) == one.periodic
        assert (data.cell[0, 1] - one.shear_offset + 1) % 30 == pytest.approx(1, abs=rounding)


def test_files_of_a_run_with_h5py(written):
    one, files = written
    with pytest.importorskip("h5py").File(files["h5md"]) as file:
        assert file["h5md"].attrs["version"].tolist() == [1, 1]
        group = file["particles/all"]
        assert group["position/value"].shape == (1, 200, 3)
        assert group["position/step"][:].tolist() == [1]
        assert group["position/time"][:].tolist() == pytest.approx([2.0], rel=1e-12)
        assert_particles(one, group["position/value"][0], DOUBLE)
        assert np.array_equal(group["velocity/value"][0], one.velocities)
        assert np.array_equal(group["radius"], one.radii)
        assert np.array_equal(group["mass"], one.masses)
        assert np.array_equal(group["species"], one.species)
        edges = group["box/edges/value"][0]
        assert np.diag(edges if edges.ndim == 2 else np.diag(edges)).tolist() == list(one.box)
        assert tuple(kind == b"periodic" for kind in group["box"].attrs["boundary"]) == one.periodic


@pytest.mark.filterwarnings("ignore")
def test_h5md_of_a_run_with_mdanalysis(written):
    analysis = pytest.importorskip("MDAnalysis")
    pytest.importorskip("h5py")
    one, files = written
    universe = analysis.Universe.empty(200, trajectory=False)
    universe.load_new(str(files["h5md"]), format="H5MD", convert_units=False)
    (frame,) = universe.trajectory
    assert_particles(one, frame.positions, 4 * SINGLE)
    assert np.array_equal(frame.velocities, one.velocities.astype(np.float32))
    assert frame.triclinic_dimensions[1, 0] == pytest.approx(tilt_of(one), abs=1e-5)


@pytest.mark.filterwarnings("ignore")
def test_files_of_a_run_with_mdanalysis(written):
    analysis = pytest.importorskip("MDAnalysis")
    one, files = written
    for name, ending in (("lammps", "LAMMPSDUMP"), ("gsd", "GSD")):
        universe = analysis.Universe(str(files[name]), format=ending, topology_format=ending)
        frame = universe.trajectory[0]
        # MDAnalysis has single precision, and the origin of HOOMD in the middle of the box.
        shift = np.array([(30 + tilt_of(one)) / 2, 10, 0]) if name == "gsd" else 0
        assert_particles(one, frame.positions + shift, 4 * SINGLE)
        assert len(universe.atoms) == 200
        assert np.array_equal(universe.atoms.types.astype(int) - (name == "lammps"), one.species)


def test_files_of_a_run_with_freud(written):
    freud, hoomd = pytest.importorskip("freud"), pytest.importorskip("gsd.hoomd")
    one, files = written
    with hoomd.open(files["gsd"]) as file:
        box, points = freud.box.Box.from_box(file[0].configuration.box), file[0].particles.position
    # HOOMD, and so freud, takes all axes to be periodic.
    found = freud.locality.AABBQuery(box, points).query(points, {"r_max": 2.5, "exclude_ii": True}).toNeighborList()
    away = one.positions[:, None] - one.positions[None]
    boxes = np.round(away[..., 1] / 20)
    away[..., 0] -= boxes * one.shear_offset
    away[..., 1] -= boxes * 20
    away[..., 0] -= 30 * np.round(away[..., 0] / 30)
    wanted = {(int(i), int(j)) for i, j in zip(*np.nonzero(np.linalg.norm(away, axis=2) < 2.5)) if i < j}
    # Single precision moves a distance by 1e-6, over which none of 700 pairs lies here.
    assert {(int(i), int(j)) for i, j in found[:] if i < j} == wanted and len(wanted) > 300


def test_each_format_of_a_run_reads_back(written):
    from stosszahl.snapshots import read_snapshot

    one, files = written
    for name, path in files.items():
        read = read_snapshot(path, {"engine": "ed", "time": 2.0})
        rounding = 2 * SINGLE if name == "gsd" else DOUBLE
        assert_particles(one, read.positions, rounding)
        assert read.periodic == one.periodic and read.box[:2] == pytest.approx(one.box[:2], rel=2**-51)
        assert np.array_equal(read.species, one.species)
        assert (read.shear_offset - one.shear_offset + 1) % 30 == pytest.approx(1, abs=2 * rounding)
        if name != "gsd":
            assert np.array_equal(read.velocities, one.velocities) and np.array_equal(read.radii, one.radii)


def test_tables_of_a_run_as_parquet(tmp_path, program):
    parquet, polars = pytest.importorskip("pyarrow.parquet"), pytest.importorskip("polars")
    out = tmp_path / "out"
    settings = ["--set", "gas.number=100", "--set", "run.until=2", "--set", "replicas=2"]
    done = program("--features", "parquet", "--", "run", "quick", "--out", str(out), "--tables", "parquet", *settings)
    assert done.returncode == 0, done.stderr
    results = stosszahl.Results(out)
    assert len(results.tables) > 3
    for name, table in results.tables.items():
        path = out / f"{name}.parquet"
        read = parquet.read_table(path)
        assert read.column_names == list(table.columns)
        told = read.schema.metadata
        assert told[b"about"].decode() == table.attrs["about"]
        columns = {one["name"]: one for one in json.loads(told[b"columns"])}
        for column, about in results.columns(name).to_dict("index").items():
            assert columns[column]["unit"] == about["unit"] and columns[column]["meaning"] == about["meaning"]
            numbers = read[column].to_pandas()
            same = numbers.fillna(-1).tolist() == table[column].fillna(-1).tolist() if columns[column]["unit"] else True
            assert same, (name, column)
        assert polars.read_parquet(path).height == len(table)


def test_pair_correlations_and_structure_factors_with_freud(root, tmp_path):
    """One replica, so that its snapshot is all that tables are of."""
    freud = pytest.importorskip("freud")
    end = {"gas.number": 900, "run.until": 3, "measure.structure_factor.times": [3], "measure.pair_correlation.times": [3]}
    one = stosszahl.run(root / "cases/quick.toml", end, out=tmp_path / "one", replicas=1, progress=False)
    (frame,) = trajectory(one, engine="ed")
    side = frame.box[0]
    ours = {name: one[name] for name in ("pair_correlation", "structure_factor")}
    ours = {name: table[table["engine"] == "ed"] for name, table in ours.items()}
    # freud works in single precision, which moves distances by some 1e-6 d. There are 900 r pairs for each d at a distance r, so that 0.3
    # of them are expected to pass one of the 120 edges of bins; more than six do once in 10^8.
    box = freud.box.Box(side, side, is2D=True)
    points = box.wrap(frame.positions * [1, 1, 0])
    found = freud.density.RDF(bins=len(ours["pair_correlation"]), r_max=6, normalization_mode="finite_size").compute((box, points))
    rings = np.pi * np.diff(found.bin_edges.astype(float) ** 2)
    pairs = len(points) * (len(points) - 1) / 2 * rings / side**2
    # Each pair that moves is missing in one bin and too many in another; single precision of g comes to 0.1.
    assert (np.abs(found.rdf - ours["pair_correlation"]["g"]) * pairs).sum() < 12.2
    # freud knows structure factors of boxes in space, and takes waves of the first quadrant only; a plain sum has both.
    count = np.arange(-6, 7)
    waves = np.stack(np.meshgrid(count, count), axis=-1).reshape(-1, 2)
    power = np.abs(np.exp(2j * np.pi / side * points[:, :2] @ waves.T).sum(axis=0)) ** 2 / len(points)
    shell = np.rint(np.hypot(*waves.T))
    unit = 2 * np.pi / side
    of_freud = freud.diffraction.StaticStructureFactorDirect(bins=5, k_max=5.5 * unit, k_min=0.5 * unit)
    of_freud.compute((freud.box.Box(side, side, 1), points))
    for number in range(1, 6):
        first = (shell == number) & (waves >= 0).all(axis=1)
        assert of_freud.S_k[number - 1] == pytest.approx(power[first].mean(), rel=1e-4)
        # Our structure factor is that of a lattice of at least 128 sites a side, whose waves n and 128 - n mix by (n/(128 - n))^2 at most.
        mixed = 2 * (number / (128 - number)) ** 2
        value = ours["structure_factor"]["structure_factor"].iloc[number - 1]
        assert value == pytest.approx(power[shell == number].mean(), rel=mixed)


def test_snapshots_of_a_run_with_ase(quick, tmp_path):
    ase_io = pytest.importorskip("ase.io")
    path = next(quick.folder.glob("snapshots/ed-*.xyz"))
    (ours,) = trajectory(quick, engine="ed")
    read = ase_io.read(path)
    assert np.array_equal(read.positions, ours.positions) and np.array_equal(read.arrays["velo"], ours.velocities)
    assert read.pbc.tolist() == list(ours.periodic) == [True, True, False]


@pytest.fixture(scope="module")
def chosen(root, tmp_path_factory):
    """Snapshots of one engine, of two replicas, with less than all quantities; and logs of collisions."""
    keys = {
        "gas.number": 100,
        "run.until": 4,
        "measure.snapshots": {"interval": 2, "engines": ["ed"], "replicas": [0, 2], "quantities": ["velocity", "species"]},
        "measure.collision_log": {"most": 300, "from": 1, "replicas": "all"},
    }
    out = tmp_path_factory.mktemp("results") / "chosen"
    return stosszahl.run(root / "cases/quick.toml", keys, out=out, replicas=3, progress=False)


def test_snapshots_that_a_case_chooses(chosen, tmp_path):
    ase_io = pytest.importorskip("ase.io")
    assert [(one.engine, one.replica, one.time) for one in chosen.snapshots] == [("ed", replica, time) for replica in (0, 2) for time in (0, 2, 4)]
    second = trajectory(chosen, replica=2)
    assert second[0].radii is None and second[0].masses is None and second[0].species.tolist() == [0] * 100
    assert not np.array_equal(second[2].positions, trajectory(chosen)[2].positions)
    read = ase_io.read(second.write(tmp_path / "x.xyz"), index=":")
    assert same(second, [one.info["Time"] / 2 for one in read], [one.positions for one in read])
    assert set(read[0].arrays) >= {"velo", "type"} and not {"radius", "mass"} & set(read[0].arrays)
    with pytest.importorskip("gsd.hoomd").open(second.write(tmp_path / "x.gsd")) as file:
        assert np.array_equal(file[1].particles.velocity, second[1].velocities.astype(np.float32))
    with pytest.importorskip("h5py").File(second.write(tmp_path / "x.h5")) as file:
        assert "mass" not in file["particles/all"] and file["particles/all/velocity/value"].shape == (3, 100, 3)
    grid = stosszahl.write_particles(second, tmp_path / "vtk")
    assert b'Name="velocity"' in (grid.parent / "particles-0.vtu").read_bytes()
    with pytest.raises(stosszahl.ResultsError, match="no snapshots of replica 1; there are some of: 0, 2"):
        trajectory(chosen, replica=1)


def test_a_log_that_a_case_asks_for(chosen, tmp_path):
    parquet, polars = pytest.importorskip("pyarrow.parquet"), pytest.importorskip("polars")
    log = chosen["collision_log"]
    sizes = log.groupby(["engine", "replica"]).size()
    assert set(sizes.index.get_level_values("replica")) == {0, 1, 2} and (sizes == 300).all()
    assert log["time"].between(1, 4).all() and log["impact_parameter"].between(0, 1).all()
    exact = log[log["engine"] == "ed"]
    assert (exact["first"] != exact["second"]).all() and exact["first"].between(0, 99).all()
    parquet.write_table(chosen.arrow("collision_log"), tmp_path / "log.parquet")
    read = polars.read_parquet(tmp_path / "log.parquet")
    assert read.height == len(log) and read["relative_speed"].to_list() == log["relative_speed"].tolist()


def test_a_gas_without_positions(tmp_path):
    case = {
        "format": 2,
        "title": "Spheres",
        "gas": {"dimension": 3, "number": 500, "volume": 1e4, "restitution": 0.9},
        "run": {"until": 2},
        "measure": {"snapshots": {"interval": 1}},
    }
    results = stosszahl.run(case, out=tmp_path / "spheres", replicas=2, progress=False)
    frames = trajectory(results)
    engine = trajectory(MonteCarlo(Gas.spheres(50, restitution=0.9)), TIMES)
    for all_, number in ((frames, 500), (engine, 50)):
        assert [one.positions for one in all_] == [None] * 3 and all_[0].box == ()
        read = np.load(all_.write(tmp_path / "x.npz"))
        assert "positions" not in read and read["velocities"].shape == (3, number, 3)
        assert np.array_equal(read["velocities"][2], all_[2].velocities) and np.array_equal(read["time"], TIMES)
        for ending in ("xyz", "gsd", "h5"):
            with pytest.raises(stosszahl.ResultsError, match="no positions; allowed: formats that need none, .npz"):
                all_.write(tmp_path / f"x.{ending}")
        with pytest.raises(stosszahl.ResultsError, match="no positions; allowed: a gas in a box"):
            stosszahl.write_particles(all_, tmp_path / "vtk")


def test_files_that_cannot_be_written(frames, quick, tmp_path):
    with pytest.raises(stosszahl.ResultsError, match="no format has the ending '.pdb'; allowed: .xyz"):
        frames.write(tmp_path / "x.pdb")
    with pytest.raises(stosszahl.ResultsError, match="no snapshot"):
        Trajectory([]).write(tmp_path / "x.xyz")
    with pytest.raises(stosszahl.ResultsError, match="differ in the number of particles"):
        Trajectory([Gas.disks(2), Gas.disks(3)]).write(tmp_path / "x.npz")
    with pytest.raises(stosszahl.ResultsError, match="without times"):
        trajectory(EventDriven(Gas.disks(2)))
    with pytest.raises(stosszahl.ResultsError, match="no snapshots of 'dsmc-esmc'; there are some of: ed"):
        trajectory(quick, engine="dsmc-esmc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("ending", "module"), [("gsd", "gsd.hoomd"), ("h5", "h5py")])
def test_packages_that_are_missing(frames, tmp_path, monkeypatch, ending, module):
    monkeypatch.setitem(sys.modules, module, None)
    package = module.partition(".")[0]
    with pytest.raises(stosszahl.PackageError, match=f"files .{ending} need the package {package}: .*; pip install {package}") as caught:
        frames.write(tmp_path / f"x.{ending}")
    assert isinstance(caught.value, ImportError) and caught.value.name == package and list(tmp_path.iterdir()) == []


def test_neighbours_with_ovito(frames, tmp_path):
    ovito = pytest.importorskip("ovito.data", exc_type=ImportError)
    from ovito.io import import_file

    data = import_file(str(frames.write(tmp_path / "x.xyz")), multiple_frames=True).compute(2)
    one = frames[2]
    # OVITO reads decimal numbers to a few units of the last place.
    assert np.abs(data.particles.positions - one.positions).max() < 30 * 2**-50
    assert np.array_equal(data.particles["Radius"], one.radii) and tuple(data.cell.pbc) == one.periodic
    finder = ovito.CutoffNeighborFinder(1.5, data)
    found = sum(1 for index in range(data.particles.count) for _ in finder.find(index))
    away = one.positions[:, None] - one.positions[None]
    away[..., 0] -= 30 * np.round(away[..., 0] / 30)
    assert found == (np.linalg.norm(away, axis=2) < 1.5).sum() - len(one) > 100


def test_species_with_ovito(mixture, tmp_path):
    pytest.importorskip("ovito.data", exc_type=ImportError)
    from ovito.io import import_file

    for ending in ("xyz", "gsd"):
        particles = import_file(str(mixture.write(tmp_path / f"x.{ending}")), multiple_frames=True).compute(2).particles
        assert np.array_equal(particles.particle_types, mixture[2].species)


@pytest.mark.parametrize("ending", [".xyz", ".npz", ".gsd", ".h5"])
def test_files_have_the_permissions_of_any_new_file(ending, tmp_path):
    (tmp_path / "any").touch()
    engine = EventDriven(Gas.disks(10))
    written = trajectory(engine, [1.0]).write(tmp_path / f"disks{ending}")
    assert written.stat().st_mode == (tmp_path / "any").stat().st_mode


def test_a_trajectory_says_what_it_is():
    shown = trajectory(EventDriven(Gas.disks(10)), [1.0, 2.5])
    assert len(shown) == 2 and repr(shown) == "<Trajectory of 2 snapshots, times 1 to 2.5>"
    assert repr(stosszahl.Trajectory([])) == "<Trajectory of 0 snapshots>"


def test_files_of_other_libraries_are_starts(tmp_path):
    """GSD by the package of HOOMD-blue, extended XYZ and data files of LAMMPS by ASE: the microstate that was given to them."""
    hoomd, ase = pytest.importorskip("gsd.hoomd"), pytest.importorskip("ase")
    ase_io = pytest.importorskip("ase.io")
    random = np.random.default_rng(3)
    places = np.array([[3.0 * x + 2, 3.0 * y + 2, 0] for x in range(9) for y in range(6)]) + random.uniform(-0.9, 0.9, (54, 3)) * [1, 1, 0]
    speeds = random.normal(size=(54, 3)) * [1, 1, 0]
    frame = hoomd.Frame()
    frame.configuration.box, frame.configuration.dimensions = [30, 20, 0, 0, 0, 0], 2
    frame.particles.N, frame.particles.position, frame.particles.velocity = 54, places - [15, 10, 0], speeds
    frame.particles.diameter = np.full(54, 0.9)
    with hoomd.open(str(tmp_path / "start.gsd"), "w") as file:
        file.append(frame)
    atoms = ase.Atoms("Ar54", positions=places, cell=[30, 20, 1], pbc=[True, False, False])
    atoms.arrays["velo"], atoms.arrays["radius"] = speeds, np.full(54, 0.45)
    ase_io.write(tmp_path / "start.xyz", atoms, format="extxyz")
    atoms.set_velocities(speeds)
    ase_io.write(tmp_path / "start.data", atoms, format="lammps-data", atom_style="atomic", masses=True, velocities=True, units="metal")
    # ASE writes eight digits of XYZ, and of data files eight digits after the point, in its own units of velocity.
    unit = ase.units.Ang / (1e-12 * ase.units.s)
    for name, rounding, speed in (("start.gsd", 2 * SINGLE, 1.0), ("start.xyz", 1e-8, 1.0), ("start.data", 1e-8, 1 / unit)):
        case = {
            "format": 2,
            "title": "a start of another program",
            "replicas": 1,
            "gas": {"restitution": 0.9},
            "start": {"placement": "file", "velocities": "file", "file": str(tmp_path / name)},
            "box": {},
            "walls": {"bottom": {"restitution": 1.0}, "top": {"restitution": 1.0}},
            "run": {"time_unit": "case", "until": 0.1, "samples": 2},
            "engine": {"ed": {}, "dsmc-boltzmann": {"simulators_per_particle": 1}},
            "measure": {"snapshots": {"times": [0.0]}, "fields": {"cells": [2, 2], "blocks": 1}},
        }
        if name == "start.data":
            case["gas"]["diameter"] = 0.9
        results = stosszahl.run(case, out=tmp_path / f"{name}-out", progress=False)
        assert len(results.snapshots) == 2
        for one in results.snapshots:
            # Order of simulators is the engine's own.
            order, wanted = np.lexsort(one.positions.T), np.lexsort(places.T)
            assert np.abs(one.positions[order] - places[wanted]).max() <= rounding
            scale = speed * np.abs(speeds).max()
            assert np.abs(one.velocities[order] - speed * speeds[wanted]).max() <= rounding * scale
            assert np.abs(one.radii - 0.45).max() <= 2**-24
