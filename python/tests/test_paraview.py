"""Files for ParaView, read by its library VTK and by meshio."""

import xml.etree.ElementTree as Xml

import numpy as np
import pytest
import stosszahl
from stosszahl import EventDriven, Gas, trajectory, write_particles

TIMES = [0.0, 1.5, 3.0]


@pytest.fixture(scope="module")
def frames():
    """Rough disks of two species between walls, at rest as for spin in the first frame."""
    walls = {"y": (stosszahl.Wall(), stosszahl.Wall())}
    gas = Gas.disks(80, species=[(40, 0.8, 2.0)], box_size=(30, 20), restitution=0.9, tangential_restitution=0.4, walls=walls)
    return trajectory(EventDriven(gas), TIMES)


def sets(collection):
    """Times and files of a ``.pvd``, as ParaView reads it."""
    root = Xml.parse(collection).getroot()
    assert root.attrib["type"] == "Collection"
    found = [(float(one.attrib["timestep"]), collection.parent / one.attrib["file"]) for one in root.iter("DataSet")]
    assert all(file.exists() for _, file in found)
    return found


def read(path, kind):
    vtk = pytest.importorskip("vtk")
    reader = {"vtu": vtk.vtkXMLUnstructuredGridReader, "vti": vtk.vtkXMLImageDataReader}[kind]()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0
    return reader.GetOutput()


def arrays(data):
    from vtk.util.numpy_support import vtk_to_numpy

    return {data.GetArrayName(number): vtk_to_numpy(data.GetArray(number)) for number in range(data.GetNumberOfArrays())}


def expected(one):
    return {
        "id": np.arange(len(one)),
        "velocity": one.velocities,
        "diameter": 2.0 * one.radii,
        "mass": one.masses,
        "species": one.species,
        "angular_velocity": one.spins,
    }


def test_particles_with_vtk(frames, tmp_path):
    collection = write_particles(frames, tmp_path / "disks")
    assert [time for time, _ in sets(collection)] == TIMES
    assert {path.name for path in collection.parent.iterdir()} == {"particles.pvd", *(file.name for _, file in sets(collection))}
    for one, (time, file) in zip(frames, sets(collection), strict=True):
        grid = read(file, "vtu")
        assert np.array_equal([grid.GetPoint(number) for number in range(len(one))], one.positions)
        found, wanted = arrays(grid.GetPointData()), expected(one)
        assert list(found) == list(wanted) and all(np.array_equal(found[name], wanted[name]) for name in wanted)
        assert grid.GetNumberOfCells() == len(one)
        assert all(grid.GetCellType(number) == 1 and grid.GetCell(number).GetPointId(0) == number for number in range(len(one)))
        about = arrays(grid.GetFieldData())
        assert about["TimeValue"].tolist() == [time] and about["box"].tolist() == [[30, 20, 1]] and about["periodic"].tolist() == [[1, 0, 0]]
    assert np.any(frames[2].spins) and set(frames[0].species) == {0, 1} and set(2 * frames[0].radii) == {1.0, 1.6}


def test_particles_with_meshio(frames, tmp_path):
    meshio = pytest.importorskip("meshio")
    collection = write_particles(frames[2:], tmp_path, name="rough")
    ((time, file),) = sets(collection)
    assert time == TIMES[2] and file.name == "rough-0.vtu"
    mesh, wanted = meshio.read(file), expected(frames[2])
    assert np.array_equal(mesh.points, frames[2].positions)
    assert list(mesh.cells_dict) == ["vertex"] and np.array_equal(mesh.cells_dict["vertex"][:, 0], wanted["id"])
    assert all(np.array_equal(mesh.point_data[name], wanted[name]) for name in wanted)


def test_smooth_disks_of_one_kind_and_numbers_that_differ(quick, tmp_path):
    (ours,) = trajectory(quick, engine="ed")
    write_particles(trajectory(quick, engine="ed"), tmp_path, name="run")
    grid = read(tmp_path / "run-0.vtu", "vtu")
    assert list(arrays(grid.GetPointData())) == ["id", "velocity", "diameter", "mass"]
    assert np.array_equal(arrays(grid.GetPointData())["velocity"], ours.velocities)
    # Gases in place of snapshots, with different numbers of particles.
    write_particles((Gas.disks(number) for number in (3, 5)), tmp_path, name="few")
    assert [read(file, "vtu").GetNumberOfPoints() for _, file in sets(tmp_path / "few.pvd")] == [3, 5]


def test_nothing_to_write(tmp_path):
    with pytest.raises(stosszahl.ResultsError, match=r"none/particles.pvd: there is no snapshot to write; allowed: one or more"):
        write_particles([], tmp_path / "none")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").touch()
    with pytest.raises(stosszahl.ResultsError, match="file: cannot be made: .*; allowed: a folder"):
        write_particles([Gas.disks(2)], tmp_path / "file")


def test_fields_with_vtk(flow, tmp_path):
    collection = stosszahl.write_fields(flow, tmp_path / "fields")
    table = flow["fields"]
    table = table[table["engine"] == table["engine"].iloc[0]]
    # Two windows of the case, of which the second ends with the run as the steady state does: [3.75, 5].
    times, files = zip(*sets(collection))
    assert times == (1.25, 3.75, 4.375) and set(files) == set(collection.parent.glob("*.vti"))
    image = read(files[-1], "vti")
    last = table[table["window_start"] == 3.75]
    assert image.GetNumberOfCells() == len(last) > 1
    values = arrays(image.GetCellData())["number_density"]
    for cell in range(image.GetNumberOfCells()):
        low, high = np.reshape(image.GetCell(cell).GetBounds(), (3, 2)).T
        middle = 0.5 * (low + high)
        nearest = last.iloc[np.hypot(last["x"] - middle[0], last["y"] - middle[1]).argmin()]
        assert abs(nearest["x"] - middle[0]) + abs(nearest["y"] - middle[1]) < 1e-9
        assert values[cell] == nearest["number_density"]


def test_fields_are_replaced_whole_or_not_at_all(flow, tmp_path, monkeypatch):
    stosszahl.write_fields(flow, tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def fail(source, target):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", fail)
    with pytest.raises(stosszahl.ResultsError, match="vti: cannot be written: .*No space left.*; allowed: a file in a folder"):
        stosszahl.write_fields(flow, tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
