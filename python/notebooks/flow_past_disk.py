# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # A flow past a disk, in ParaView's library
#
# A fast stream of inelastic disks meets a fixed disk. A hot shock forms before it, and a thin wake behind. We run a smaller form of
# `cases/flow-past-disk.toml`, write fields and particles for ParaView, and read them here with `vtk`, the library that ParaView is made of.
# In ParaView itself one opens `fields.pvd` and `particles.pvd` and presses play.
#
# Needs `pip install vtk`. Open this file in Jupyter with jupytext, or run it as a script in the folder of the clone.

# %%
from pathlib import Path
from xml.etree import ElementTree

import matplotlib
import numpy as np
import stosszahl
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

# %% [markdown]
# ## The run
#
# The obstacle, the walls and the stream stand in the case. Here fields are averaged over three windows of time and over the last quarter,
# and simulators are seen at three times.

# %%
windows = [[0, 4], [4, 8], [8, 16]]
keys = {
    "gas.number": 20000,
    "run.samples": 200,
    "measure.fields": {"cells": [80, 40], "blocks": 20, "windows": windows},
    "measure.snapshots.times": [end for _, end in windows],
}
results = stosszahl.run("cases/flow-past-disk.toml", keys, until=20, replicas=1, out="results/past-disk", force=True)
disk = results.case["obstacle"][0]["circle"]

# %% [markdown]
# ## Files for ParaView

# %%
folder = Path("results/past-disk/paraview")
fields = stosszahl.write_fields(results, folder)
particles = stosszahl.write_particles(stosszahl.trajectory(results), folder)


def in_time(collection, reader):
    """Reads the times and data of a .pvd file."""
    for one in ElementTree.parse(collection).iter("DataSet"):
        reader.SetFileName(str(collection.parent / one.attrib["file"]))
        reader.Update()
        data = reader.GetOutput().NewInstance()
        data.DeepCopy(reader.GetOutput())
        yield float(one.attrib["timestep"]), data


images = list(in_time(fields, vtk.vtkXMLImageDataReader()))
clouds = list(in_time(particles, vtk.vtkXMLUnstructuredGridReader()))
print([f"{image.GetNumberOfCells()} cells around time {time:g}" for time, image in images])
print([f"{cloud.GetNumberOfPoints()} simulators at time {time:g}" for time, cloud in clouds])

# %% [markdown]
# ## The picture
#
# Temperature in three windows of time, with arrows along the mean velocity, and half of the simulators at the end, ten times as large as
# they are. `vtk` draws without a screen.

# %%
STREAM = 0.5  # temperature of what flows in


def colours_of(name, limits):
    table = vtk.vtkLookupTable(table_range=limits, number_of_table_values=256)
    for number in range(256):
        table.SetTableValue(number, *matplotlib.colormaps[name](number))
    return table


def shown(mapper, **look):
    return vtk.vtkActor(mapper=mapper, property=vtk.vtkProperty(lighting=False, **look))


def legend(colours, title):
    text = vtk.vtkTextProperty(color=(0, 0, 0), font_size=16, shadow=False, italic=False, bold=False)
    bar = vtk.vtkScalarBarActor(lookup_table=colours, title=title, number_of_labels=4, label_format="{:.0f}", unconstrained_font_size=True)
    bar.SetTitleTextProperty(text), bar.SetLabelTextProperty(text)
    bar.SetOrientationToHorizontal()
    bar.SetPosition(0.3, 0.02), bar.SetWidth(0.4), bar.SetHeight(0.15)
    return bar


def temperature(image, title):
    """Draws the temperature over that of the stream, and arrows of the mean velocity (one unit of length for one of speed)."""
    cells = image.GetCellData()
    numbers = {name: vtk_to_numpy(cells.GetArray(name)) for name in ("temperature", "velocity_x", "velocity_y")}
    ratio = numpy_to_vtk(numbers["temperature"] / STREAM, deep=True)
    flow = numpy_to_vtk(np.column_stack([numbers["velocity_x"], numbers["velocity_y"], 0 * numbers["velocity_x"]]), deep=True)
    ratio.SetName("ratio"), flow.SetName("velocity")
    cells.AddArray(ratio), cells.AddArray(flow)
    cells.SetActiveScalars("ratio"), cells.SetActiveVectors("velocity")
    colours = colours_of("inferno", (0.0, 3.0))
    map_ = vtk.vtkDataSetMapper(lookup_table=colours, use_lookup_table_scalar_range=True)
    map_.SetInputData(image)
    centres = vtk.vtkCellCenters(input_data_object=image)
    some = vtk.vtkMaskPoints(input_connection=centres.output_port, on_ratio=37)
    arrow = vtk.vtkGlyphSource2D(center=(0.5, 0, 0), filled=False, glyph_type=9)
    arrows = vtk.vtkGlyph3D(input_connection=some.output_port, source_connection=arrow.output_port, scale_factor=0.7, vector_mode=0)
    arrows.SetScaleModeToScaleByVector(), arrows.SetVectorModeToUseVector()
    lines = vtk.vtkPolyDataMapper(input_connection=arrows.output_port, scalar_visibility=False)
    return [shown(map_), shown(lines, color=(1, 1, 1)), legend(colours, title)]


def simulators(cloud, title):
    """Draws some simulators as disks of ten times their diameter, coloured by their speed."""
    speed = numpy_to_vtk(np.linalg.norm(vtk_to_numpy(cloud.GetPointData().GetArray("velocity")), axis=1), deep=True)
    speed.SetName("speed")
    cloud.GetPointData().AddArray(speed)
    colours = colours_of("viridis", (0.0, 3.0))
    some = vtk.vtkMaskPoints(input_data_object=cloud, on_ratio=2)
    disk = vtk.vtkRegularPolygonSource(radius=0.5, number_of_sides=16, generate_polyline=False)
    disks = vtk.vtkGlyph3D(input_connection=some.output_port, source_connection=disk.output_port, scale_factor=10.0)
    disks.SetScaleModeToScaleByScalar()
    disks.SetInputArrayToProcess(0, 0, 0, 0, "diameter"), disks.SetInputArrayToProcess(3, 0, 0, 0, "speed")
    disks.SetColorModeToColorByScalar()
    map_ = vtk.vtkPolyDataMapper(input_connection=disks.output_port, lookup_table=colours, use_lookup_table_scalar_range=True)
    return [shown(map_), legend(colours, title)]


def obstacle():
    round_ = vtk.vtkRegularPolygonSource(center=(*disk["centre"], 0.01), radius=disk["radius"], number_of_sides=60)
    return shown(vtk.vtkPolyDataMapper(input_connection=round_.output_port), color=(0.6, 0.6, 0.6))


panels = [temperature(image, f"T over that of the stream, times {start} to {end}") for (start, end), (_, image) in zip(windows, images)]
panels += [simulators(cloud, f"speed, at time {time:g}") for time, cloud in clouds[-1:]]
window = vtk.vtkRenderWindow(size=(1200, 720), off_screen_rendering=True)
for number, props in enumerate(panels):
    x, y = 0.5 * (number % 2), 0.5 * (1 - number // 2)
    renderer = vtk.vtkRenderer(background=(1, 1, 1), viewport=(x, y, x + 0.5, y + 0.5))
    for prop in (*props, obstacle()):
        renderer.AddViewProp(prop)
    renderer.active_camera.SetParallelProjection(True)
    renderer.ResetCamera(0, 40, -4, 20, 0, 0)
    renderer.active_camera.SetParallelScale(12)
    window.AddRenderer(renderer)
window.Render()
picture = vtk.vtkWindowToImageFilter(input=window, read_front_buffer=False)
vtk.vtkPNGWriter(input_connection=picture.output_port, file_name=str(folder / "flow.png")).Write()
print(folder / "flow.png")
