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
# # An ensemble on all cores, or on a cluster
#
# A `Gas` can be pickled, so whatever sends work to processes sends gases too. Replicas share a seed and differ in `replica`.

# %%
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from stosszahl import EventDriven, Gas


def temperatures(gas, times):
    """Returns the temperature of an exact gas at some times."""
    engine = EventDriven(gas)
    engine.equilibrate(10)
    found = []
    for time in times:
        engine.advance(time)
        found.append(engine.temperature)
    return found


def mean_and_error(all_):
    return np.mean(all_, axis=0), np.std(all_, axis=0, ddof=1) / np.sqrt(len(all_))


# %% [markdown]
# ## Processes of this machine

# %%
if __name__ == "__main__":
    gases = [Gas.disks(400, packing_fraction=0.1, restitution=0.9, seed=5, replica=replica) for replica in range(8)]
    times = [gases[0].haff_time * number for number in (1, 2, 4)]
    with ProcessPoolExecutor(2) as pool:
        here = mean_and_error(list(pool.map(temperatures, gases, [times] * len(gases))))
    for time, mean, error in zip(times, *here):
        print(f"T({time:6.2f}) = {mean:.4f} +- {error:.4f}")

# %% [markdown]
# ## Workers of a cluster, with Dask
#
# Here they are on this machine; `Client("tcp://scheduler:8786")` has others. Numbers are the same bytes.

# %%
if __name__ == "__main__":
    try:
        from dask.distributed import Client
    except ImportError:
        print("dask.distributed is not installed")
    else:
        with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
            there = mean_and_error(client.gather(client.map(temperatures, gases, times=times)))
        print("the same numbers from Dask:", np.array_equal(here, there))
