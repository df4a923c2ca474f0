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
# # A case of one's own, and a sweep
#
# A case says what is measured and why; a run of it leaves a folder that anybody can make again. Here a case is written as a dictionary,
# checked, run, looked at, and swept over its restitution. The question: how early does a cooling gas leave Haff's law when it loses more in
# each collision, and does Monte Carlo see it?
#
# Open this file in Jupyter with jupytext, or run it as a script.

# %%
import matplotlib.pyplot as plt
import numpy as np
import stosszahl

# %% [markdown]
# ## A case
#
# The same tables and keys as in a case file: `docs/case-file.md` explains them, and `stosszahl.schema()` lists them. Times are in units of
# Haff's cooling time t0.

# %%
case = {
    "format": 2,
    "title": "Cooling disks, packing 0.2",
    "gas": {"number": 1000, "restitution": 0.8},
    "box": {"packing_fraction": 0.2},
    "run": {"until": 60},
    "replicas": 4,
    "seed": 2,
    "engine": {"ed": {}, "dsmc-contact-point": {"simulators_per_particle": 2}},
}

# %% [markdown]
# ## What it means, before it runs
#
# `check` tells derived quantities, memory, time and warnings. A mistake is an exception that names the key and what is allowed.

# %%
(outline,) = stosszahl.check(case)
for one in outline["derived"]:
    print(f"{one['name']:<30} {one['value']:.4g} {one['unit']}")
print(f"some {outline['seconds']:.1f} s, {outline['bytes'] / 1e6:.0f} MB")
try:
    stosszahl.check(case, {"gas.restitution": 1.2})
except stosszahl.CaseError as error:
    print(f"\nrefused because of {error.key}:\n{error}")

# %% [markdown]
# ## One run
#
# Ctrl-C would stop it; `resume=True` would go on. `force=True` replaces what an earlier run of this notebook has left.

# %%
results = stosszahl.run(case, out="results/own", force=True)
for verdict in results.verdicts:
    print(verdict)
energy = results["energy"]
print(results.columns("energy").loc[["time", "energy_ratio"], ["unit", "meaning"]])
results.figure("energy")

# %% [markdown]
# ## A sweep
#
# Any keys, each with a list of values; all combinations are run. Tables of a sweep have the values of the points in front.

# %%
restitutions = [0.6, 0.8, 0.95]
sweep = stosszahl.sweep(case, {"gas.restitution": restitutions}, out="results/own-sweep", force=True)
energy = sweep["energy"]
haff = (1 + energy["time"]) ** -2.0
energy = energy.assign(over_haff=energy["energy_ratio"] / haff, over_haff_se=energy["energy_ratio_se"] / haff)
last = energy[energy["time"] == energy["time"].max()]
print(last.pivot(index="gas.restitution", columns="engine", values="over_haff").round(3))

# %% [markdown]
# ## The picture
#
# Left: energy over Haff's law, which is of a gas without structure. A gas that loses more leaves it by more, the exact one
# and that of Monte Carlo alike: streams and clusters need no broken chaos. Right: the slope of the distribution of impact parameters in the
# last window, which is zero where chaos holds. Only the exact gas departs from it.

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
looks = {"ed": ("-", "o", "exact"), "dsmc-contact-point": ("--", "s", "Monte Carlo")}
colours = dict(zip(restitutions, ["#443a83", "#21918c", "#d59b00"]))
for (restitution, engine), rows in energy.groupby(["gas.restitution", "engine"]):
    line, _, name = looks[engine]
    left.errorbar(rows["time"], rows["over_haff"], rows["over_haff_se"], color=colours[restitution], ls=line, label=f"r = {restitution}, {name}")
left.set(xscale="log", xlabel="t/t0", ylabel="E/E(0) (1 + t/t0)^2")
left.axhline(1, color="k", ls=":", lw=1)
left.legend(frameon=False, fontsize=8)
slopes = sweep["impact_parameter_summary"]
slopes = slopes[slopes["window_end"] == slopes["window_end"].max()]
for engine, rows in slopes.groupby("engine"):
    line, marker, name = looks[engine]
    right.errorbar(rows["gas.restitution"], rows["slope"], rows["slope_se"], color="k", ls=line, marker=marker, label=name)
right.axhline(0, color="k", ls=":", lw=1)
right.set(xlabel="restitution", ylabel="slope of P(b/d) in the last window")
right.legend(frameon=False)
plt.show()
