"""Cost of Python: collisions per second of exact disks in Rust, from Python, and through observers.

    cargo build --release -p stosszahl-python --features states --example speed
    chrt -f 1 python python/benchmarks/speed.py target/release/examples/speed [DISKS] [TURNS] [WAYS]
    chrt -f 1 python python/benchmarks/speed.py target/release/examples/speed pairs [DISKS] [TURNS] [COLLISIONS]

All ways advance one gas of elastic disks at packing 0.25 to one end, by turns and in an order that changes from turn to turn, so that other
load on the machine affects all of them; with WAYS, only the first WAYS ways. Times are of the advance alone. Medians over the turns are
printed with quartiles.

With `pairs`, Rust and Python take many short turns, each in its own process, in the order Rust, Python, Python, Rust. The median of the
quotient over all turns of two of each is printed, with its 95 % interval by order statistics.
"""

import subprocess
import sys
import time
from statistics import median, quantiles

import numpy as np
from stosszahl import CollisionLog, EventDriven, Gas, ImpactParameters, impact_parameters

COLLISIONS = 1_500_000
PACKING, SEED, FORGET = 0.25, 7, 5.0


def exact(disks):
    engine = EventDriven(Gas.disks(disks, packing_fraction=PACKING, restitution=1.0, seed=SEED))
    engine.equilibrate(FORGET)
    return engine


def end_of(disks, collisions=COLLISIONS):
    """Time until which there are about `collisions` collisions."""
    engine = exact(disks)
    before = engine.collisions
    engine.advance(20.0)
    return round(20.0 * collisions / (engine.collisions - before), 1)


def in_rust(program, disks, until):
    done = subprocess.run([program, str(disks), repr(until)], capture_output=True, text=True, check=True)
    collisions, seconds = done.stdout.split()
    return int(collisions), float(seconds)


def in_python(disks, until, observer=None):
    engine = exact(disks)
    before, began = engine.collisions, time.perf_counter()
    engine.advance(until, observer)
    return engine.collisions - before, time.perf_counter() - began


def pairs(program, disks=5000, turns=40, collisions=400_000):
    """Prints the quotient of the speeds, each measured in a new process."""
    until = end_of(disks, collisions)
    rust, python = [program], [sys.executable, __file__, "one"]
    quotients, seconds, counts = [], {"Rust": [], "Python": []}, set()
    for turn in range(turns + 1):
        times = {"Rust": 0.0, "Python": 0.0}
        for name in ("Rust", "Python", "Python", "Rust"):
            done = subprocess.run([*(rust if name == "Rust" else python), str(disks), repr(until)], capture_output=True, text=True, check=True)
            count, took = done.stdout.split()
            counts.add(count)
            times[name] += float(took)
        # Without the first turn, which fills the file caches.
        if turn > 0:
            quotients.append(times["Rust"] / times["Python"])
            for name, took in times.items():
                seconds[name].append(took / 2)
    (count,) = counts
    quotients.sort()
    # Bounds of the median with 95 %: the binomial distribution in its normal limit.
    rank = max(int(turns / 2 - 0.98 * turns**0.5), 0)
    low, high = quotients[rank], quotients[turns - 1 - rank]
    speeds = {name: int(count) / median(all_) / 1e6 for name, all_ in seconds.items()}
    print(f"{disks} disks, {count} collisions until {until}, {turns} turns; M/s: {speeds['Rust']:.3f} Rust, {speeds['Python']:.3f} Python")
    print(f"Python over Rust: {median(quotients):.4f} ({low:.4f} to {high:.4f}); least times {min(seconds['Rust']) / min(seconds['Python']):.4f}")


def counting():
    """Returns a minimal NumPy observer: number of collisions and sum of squared relative velocities."""
    sums = np.zeros(2)

    def observe(collisions):
        relative = collisions["relative_velocity"]
        sums[0] += len(collisions)
        sums[1] += np.einsum("ij,ij->", relative, relative)

    return observe


def binned():
    """Returns an observer that makes a histogram of impact parameters."""
    bins = np.zeros(20, dtype=int)

    def observe(collisions):
        u = impact_parameters(collisions)
        bins[:] += np.bincount((20 * u).astype(np.intp).clip(0, 19), minlength=20)

    return observe


def main():
    program = sys.argv[1]
    if program == "one":
        print(*in_python(int(sys.argv[2]), float(sys.argv[3])))
        return
    if sys.argv[2:3] == ["pairs"]:
        pairs(program, *map(int, sys.argv[3:]))
        return
    given = [int(word) for word in sys.argv[2:]]
    disks, turns, most = given + [5000, 15, 7][len(given) :]
    until = end_of(disks)
    ways = {
        "Rust": lambda: in_rust(program, disks, until),
        "Python": lambda: in_python(disks, until),
        "ImpactParameters (in Rust)": lambda: in_python(disks, until, ImpactParameters()),
        "a function that does nothing": lambda: in_python(disks, until, lambda collisions: None),
        "a sum of squares in NumPy": lambda: in_python(disks, until, counting()),
        "a histogram in NumPy": lambda: in_python(disks, until, binned()),
        "CollisionLog": lambda: in_python(disks, until, CollisionLog(COLLISIONS)),
    }
    order, counts = list(ways)[:most], {}
    seconds = {name: [] for name in order}
    for turn in range(turns + 1):
        for name in order:
            collisions, took = ways[name]()
            if turn > 0:
                seconds[name].append(took)
            counts[name] = collisions
        order = order[1:] + order[:1]
    count = counts["Python"]
    assert set(counts.values()) == {count}, counts
    print(f"{disks} disks, {count} collisions until {until}, {turns} turns")
    for name, all_ in seconds.items():
        low, _, high = quantiles(all_, n=4)
        extra = 1e6 * (median(all_) - median(seconds["Python"])) / count
        print(f"{name:<30} {count / median(all_) / 1e6:6.3f} M/s ({count / high / 1e6:.3f} to {count / low / 1e6:.3f}), {extra:+.3f} us a collision over Python alone")
    ratios = [rust / python for rust, python in zip(seconds["Rust"], seconds["Python"])]
    low, middle, high = quantiles(ratios, n=4)
    print(f"Python over Rust: {median(seconds['Rust']) / median(seconds['Python']):.4f} of medians; by turns {middle:.4f} ({low:.4f} to {high:.4f})")


main()
