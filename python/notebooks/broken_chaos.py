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
# # Where chaos breaks, in ten minutes
#
# Molecular chaos says that particles about to collide know nothing of each other. Then every impact parameter b of two disks
# of diameter d is equally likely, from central (b = 0) to grazing (b = d). Dissipation breaks that. We let one and the same
# gas cool twice: exactly, and by Monte Carlo, which draws partners at random.
#
# Open this file in Jupyter with jupytext, or run it as a script.

# %%
import matplotlib.pyplot as plt
import numpy as np
from stosszahl import EventDriven, Gas, ImpactParameters, MonteCarlo, impact_parameters

# %% [markdown]
# ## One microstate for two engines
#
# 2000 disks cover a quarter of the box. A collision keeps six tenths of the normal approach speed. Elastic collisions first, so that
# the gas forgets how its disks were placed.

# %%
gas = Gas.disks(2000, packing_fraction=0.25, restitution=0.6, seed=1)
exact = EventDriven(gas)
exact.equilibrate(20)
chaos = MonteCarlo.from_state(exact.state(), "contact-point")
t0 = gas.haff_time
print(exact, chaos, f"Haff's time t0 = {t0:.3f}", sep="\n")

# %% [markdown]
# ## Both cool, window by window
#
# `ImpactParameters` counts in Rust. Its slope is zero under chaos, and positive where grazing collisions are in excess.

# %%
windows = np.array([0, 2, 5, 10, 20, 40, 80])
temperatures, slopes = {"exact": [], "Monte Carlo": []}, {"exact": [], "Monte Carlo": []}
last = {}
for end in windows[1:]:
    for name, engine in (("exact", exact), ("Monte Carlo", chaos)):
        last[name] = ImpactParameters()
        engine.advance(end * t0, last[name])
        slopes[name].append((last[name].slope, last[name].slope_error))
        temperatures[name].append(engine.temperature)
    print(f"until {end:3} t0: slope exact {slopes['exact'][-1][0]:+.3f}, Monte Carlo {slopes['Monte Carlo'][-1][0]:+.3f}")

# %% [markdown]
# ## An observer of one's own
#
# Any function of an array of collisions will do. Which pairs meet again in the exact gas, and do they graze? Those of an elastic
# gas at this packing do, too, and as often; its first meetings make up for it, so that all together are uniform. The measure
# `contacts` of cases has both gases side by side.

# %%
met, again, first = set(), [], []


def watch(collisions):
    grazing = impact_parameters(collisions)
    for pair, b in zip(map(tuple, np.sort(collisions["pair"], axis=1).tolist()), grazing):
        (again if pair in met else first).append(b)
        met.add(pair)


exact.advance(exact.time + 20 * t0, watch)
print(f"{len(first)} first meetings with mean b/d {np.mean(first):.3f}, {len(again)} further ones with {np.mean(again):.3f}")

# %% [markdown]
# ## The picture
#
# Haff's law, T = T(0)/(1 + t/t0)^2, is of a gas without structure: both gases leave it when they begin to flow and to cluster.
# Only the exact one leaves chaos. The slope of Monte Carlo is not quite zero in dense clusters, as one simulator for each disk
# meets the same partners again now and then; cases choose more of them.

# %%
figure, (left, middle, right, box) = plt.subplots(1, 4, figsize=(16, 4), layout="constrained")
left.loglog(windows[1:], (1.0 + windows[1:]) ** -2.0, "k--", lw=1, label="Haff")
centres = 0.5 * (windows[1:] + windows[:-1])
for name, colour, marker in (("exact", "#0060a8", "o"), ("Monte Carlo", "#c8500a", "s")):
    left.loglog(windows[1:], temperatures[name], color=colour, marker=marker, label=name)
    middle.errorbar(centres, *np.transpose(slopes[name]), color=colour, marker=marker, label=name)
    right.stairs(last[name].densities, np.linspace(0, 1, 21), color=colour, label=name)
left.set(xlabel="t/t0", ylabel="T/T(0)", title="cooling")
middle.axhline(0, color="k", ls=":", lw=1)
middle.set(xlabel="t/t0", ylabel="slope of P(b/d)", title="departure from chaos")
right.axhline(1, color="k", ls=":", lw=1)
right.set(xlabel="b/d", ylabel="P(b/d)", title=f"impact parameters, {windows[-2]} to {windows[-1]} t0", ylim=(0, None))
for axes in (left, middle, right):
    axes.legend(frameon=False)
for axes in (left, middle):
    axes.set_xscale("log")
    axes.set_xticks(windows[1:], windows[1:])
    axes.minorticks_off()
x, y = exact.positions.T
box.scatter(x, y, s=4, c=np.linalg.norm(exact.velocities, axis=1), cmap="viridis")
box.set(title="the exact gas at the end, by speed", aspect="equal", xticks=[], yticks=[])
plt.show()
