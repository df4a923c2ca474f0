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
# # freud and OVITO on our snapshots
#
# A run leaves snapshots in `snapshots/*.xyz`, which OVITO opens, and `trajectory(...).write("disks.gsd")` makes a GSD file, which freud reads.
# Here freud finds the pair correlations that our table has, and the clusters that it has not; OVITO counts neighbours and draws them.
#
# Needs `pip install gsd freud-analysis "ovito<3.16"` (later ones need Vulkan to draw). Open this file in Jupyter with jupytext, or run it as a
# script in the folder of the clone.

# %%
import freud
import gsd.hoomd
import matplotlib.pyplot as plt
import numpy as np
import stosszahl
from ovito.io import import_file
from ovito.modifiers import ColorCodingModifier, CoordinationAnalysisModifier
from ovito.vis import TachyonRenderer, Viewport

# %% [markdown]
# ## A run with snapshots
#
# Exact disks that keep six tenths of their approach speed cluster soon. One replica, so that tables are of the very snapshots.

# %%
times = [0, 5, 20, 80]
keys = {
    "gas.number": 1600,
    "gas.restitution": 0.6,
    "run.until": 80,
    "measure.snapshots": {"times": times, "engines": ["ed"]},
    "measure.pair_correlation.times": times,
}
results = stosszahl.run("cases/quick.toml", keys, replicas=1, out="results/freud", force=True)
frames = stosszahl.trajectory(results, engine="ed")
path = frames.write("results/freud/disks.gsd")

# %% [markdown]
# ## Pair correlations by freud
#
# freud takes the box and the positions of a frame as they are. Its g(r) counts the same pairs in the same bins as our table.

# %%
with gsd.hoomd.open(path) as file:
    systems = [(freud.box.Box.from_box(frame.configuration.box), frame.particles.position) for frame in file]
ours = results["pair_correlation"]
ours = {time: rows for time, rows in ours[ours["engine"] == "ed"].groupby("time")}
theirs = {}
for time, system in zip(times, systems):
    theirs[time] = freud.density.RDF(bins=len(ours[time]), r_max=6, normalization_mode="finite_size").compute(system)
difference = max(np.abs(theirs[time].rdf - ours[time]["g"]).max() for time in times)
print(f"g(r) of freud and of our table differ by {difference:.1e} at most")

# %% [markdown]
# ## Clusters by freud
#
# Disks belong together where their surfaces are nearer than a tenth of a diameter.

# %%
largest = []
for time, system in zip(times, systems):
    clusters = freud.cluster.Cluster().compute(system, neighbors={"r_max": 1.1})
    largest.append(np.bincount(clusters.cluster_idx).max())
    print(f"t = {time:2} t0: {clusters.num_clusters} clusters, the largest of {largest[-1]} disks")

# %% [markdown]
# ## Neighbours and a picture by OVITO
#
# The snapshots of the run itself, as in OVITO's window: colours are the neighbours within one and a half diameters.

# %%
pipeline = import_file(str(results.folder / "snapshots/ed-*.xyz"))
pipeline.modifiers.append(CoordinationAnalysisModifier(cutoff=1.5))
pipeline.modifiers.append(ColorCodingModifier(property="Coordination", start_value=0, end_value=6, gradient=ColorCodingModifier.Viridis()))
neighbours = [pipeline.compute(frame).particles["Coordination"][...] for frame in range(len(times))]
print("mean numbers of neighbours:", *(f"{one.mean():.2f}" for one in neighbours))
pipeline.add_to_scene()
view = Viewport(type=Viewport.Type.Top)
view.zoom_all((500, 500))
plain = TachyonRenderer(ambient_occlusion=False, shadows=False, antialiasing_samples=4)
pictures = [results.folder / f"ovito-{frame}.png" for frame in range(len(times))]
for frame, picture in enumerate(pictures):
    view.render_image(filename=str(picture), size=(500, 500), frame=frame, renderer=plain)

# %% [markdown]
# ## All together

# %%
figure, axes = plt.subplot_mosaic([[0, 1, 2, 3], ["g", "g", "c", "c"]], figsize=(14, 7.5), layout="constrained", height_ratios=(1.2, 1))
for frame, (time, picture) in enumerate(zip(times, pictures)):
    axes[frame].imshow(plt.imread(picture))
    axes[frame].set(title=f"t = {time} t0", xticks=[], yticks=[])
for colour, time in zip(["#443a83", "#31688e", "#35a55f", "#d59b00"], times):
    axes["g"].plot(theirs[time].bin_centers, theirs[time].rdf, color=colour, label=f"freud, {time} t0")
    axes["g"].plot(ours[time]["r_over_d"], ours[time]["g"], ".", color=colour, ms=3)
axes["g"].axhline(1, color="k", ls=":", lw=1)
axes["g"].set(xlabel="r/d", ylabel="g(r), dots: our table", xlim=(0.9, 6))
axes["g"].legend(frameon=False)
axes["c"].loglog(np.array(times) + 1, largest, "o-", color="#0060a8")
axes["c"].set(xlabel="1 + t/t0", ylabel="disks in the largest cluster")
plt.show()
