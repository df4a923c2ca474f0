"""Engines give the numbers of Rust, whatever Python does meanwhile."""

import concurrent.futures
import os
import pickle
import signal
import threading
import time

import numpy as np
import pytest
import stosszahl
from stosszahl import EventDriven, Gas, MonteCarlo


def gas(number=500, **keys):
    return Gas.disks(number, **{"packing_fraction": 0.25, "restitution": 0.9, "seed": 7, **keys})


def exact(number=500, equilibrate=5.0, **keys):
    engine = EventDriven(gas(number, **keys))
    engine.equilibrate(equilibrate)
    return engine


def same(a, b):
    return np.array_equal(a.positions, b.positions) and np.array_equal(a.velocities, b.velocities)


def test_the_bytes_are_those_of_the_program_in_rust(program):
    done = program("--package", "stosszahl-python", "--features", "states", "--example", "states")
    assert done.returncode == 0, done.stderr
    expected = np.array([line.split() for line in done.stdout.splitlines()], dtype=np.float64)
    engine = exact()
    chaos = MonteCarlo.from_state(engine.state(), "contact-point")
    engine.advance(5.0)
    chaos.advance(5.0)
    found = np.vstack([np.hstack([one.positions, one.velocities]) for one in (engine, chaos)])
    assert found.shape == expected.shape
    assert np.array_equal(found.view(np.uint64), expected.view(np.uint64))


@pytest.mark.parametrize("batch", [1, 100, 4096])
def test_an_observer_sees_every_collision_once_and_changes_nothing(batch):
    watched, alone = exact(), exact()
    before = watched.collisions
    seen = []
    watched.advance(5.0, lambda collisions: seen.append(collisions.copy()), batch=batch)
    alone.advance(5.0)
    assert same(watched, alone)
    all_ = np.concatenate(seen)
    assert len(all_) == watched.collisions - before > 1000
    assert {len(part) for part in seen[:-1]} <= {batch}
    assert np.all(np.diff(all_["time"]) >= 0) and all_["time"][-1] <= 5.0
    # Contact is at one diameter, but for rounding in coordinates up to the side of the box, 40.
    distance = np.linalg.norm(all_["line"], axis=1)
    assert np.abs(distance - 1.0).max() < 1e-10
    assert np.all(all_["restitution"] == 0.9) and np.all(all_["weight"] == 1.0) and np.all(all_["reduced_mass"] == 0.5)
    assert all_["pair"].max() < 500 and np.all(all_["pair"][:, 0] != all_["pair"][:, 1])
    # Partners approach, and their loss of energy is that of the gas, to rounding of 1e4 terms.
    along = np.einsum("ij,ij->i", all_["relative_velocity"], all_["line"])
    assert np.all(along < 0)
    lost = (0.5 * all_["reduced_mass"] * (1 - 0.81) * (along / distance) ** 2).sum()
    assert lost == pytest.approx(500 * (1.0 - watched.temperature), rel=1e-9)


def test_impact_parameters_of_python_and_rust_agree():
    python, rust = exact(), exact()
    u = []
    impact = stosszahl.ImpactParameters()
    python.advance(5.0, lambda collisions: u.append(stosszahl.impact_parameters(collisions)))
    rust.advance(5.0, impact)
    u = np.concatenate(u)
    assert impact.collisions == len(u)
    assert impact.slope == pytest.approx(12 * (u.mean() - 0.5), abs=1e-9)
    counts = np.rint(impact.densities * len(u) / 20)
    assert np.array_equal(counts, np.bincount((20 * u).astype(int), minlength=20))
    assert impact.slope_error == pytest.approx(12 * u.std() / len(u) ** 0.5, rel=1e-9)


def test_monte_carlo_shows_its_collisions_too():
    start = exact().state()
    for scheme in ("boltzmann", "free-volume", "enskog", "esmc", "stochastic-disks", "contact-point"):
        chaos, seen = MonteCarlo.from_state(start, scheme), []
        chaos.advance(1.0, lambda collisions: seen.append(len(collisions)))
        assert sum(seen) == chaos.collisions > 100, scheme
    spheres, impact = MonteCarlo(Gas.spheres(1000, restitution=0.8)), stosszahl.ImpactParameters(3)
    spheres.advance(5.0, impact)
    assert impact.collisions == spheres.collisions > 100
    assert spheres.velocities.shape == (1000, 3)


def test_a_pickled_state_goes_on_to_the_same_bytes():
    engine = exact(species=[(100, 1.0, 4.0)], walls={"y": (stosszahl.Wall(temperature=1.0), stosszahl.Wall(restitution=0.9))})
    engine.advance(1.0)
    state = engine.state()
    copy = pickle.loads(pickle.dumps(state))
    assert same(state, copy) and copy.time == 1.0 and copy.box == state.box and copy.periodic == (True, False)
    assert np.array_equal(copy.radii, state.radii) and np.array_equal(copy.species, state.species)
    for engine in (EventDriven, MonteCarlo.from_state):
        here, there = engine(state), engine(copy)
        here.advance(2.0)
        there.advance(2.0)
        assert here.collisions > 100 and same(here, there)


def test_rough_disks_keep_their_spin_in_a_pickle():
    engine = EventDriven(gas(tangential_restitution=0.5))
    engine.advance(2.0)
    copy = pickle.loads(pickle.dumps(engine.state()))
    assert np.any(copy.spins != 0.0) and np.array_equal(copy.spins, engine.spins)


def cool(state):
    engine = EventDriven(state)
    engine.advance(3.0)
    return engine.temperature


def test_threads_and_processes():
    states = [gas(seed=seed) for seed in range(4)]
    expected = [cool(state) for state in states]
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        assert list(pool.map(cool, states)) == expected
    with concurrent.futures.ProcessPoolExecutor(2) as pool:
        assert list(pool.map(cool, states)) == expected


def test_other_threads_run_while_an_engine_does():
    engine, ticks, done = exact(5000, 1.0), [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    began = time.monotonic()
    engine.advance(50.0)
    ended = time.monotonic()
    done.set()
    thread.join()
    # With the lock held there would be no tick in between.
    assert sum(began < tick < ended for tick in ticks) >= 5


def interrupted(work):
    """Does work, and stops it by Ctrl-C."""
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        work()
    timer.join()


def test_ctrl_c_stops_exact_dynamics_which_goes_on_to_the_same_bytes():
    # Elastic: a gas that cools has few collisions left, and may reach any time before it is stopped.
    stopped, alone = exact(2000, 1.0, restitution=1.0), exact(2000, 1.0, restitution=1.0)
    interrupted(lambda: stopped.advance(1e6))
    assert 0 < stopped.time < 1e6
    later = stopped.time + 1.0
    stopped.advance(later)
    alone.advance(later)
    assert same(stopped, alone)


def monte_carlo():
    """Two engines of a gas without positions, and two in cells, which stop between steps."""
    spheres = Gas.spheres(1000, restitution=1.0)
    start = exact(2000, 1.0, restitution=1.0).state()
    return (MonteCarlo(spheres), MonteCarlo(spheres)), (MonteCarlo.from_state(start), MonteCarlo.from_state(start))


def test_ctrl_c_stops_monte_carlo_after_a_step():
    for engine, _ in monte_carlo():
        interrupted(lambda: engine.advance(1e9))
        middle, energy = engine.time, engine.temperature
        assert 0 < middle < 1e9
        engine.advance(middle + 1.0)
        # Elastic, so that a state in the middle of a step would show: rounding of some 1e6 collisions.
        assert engine.time == middle + 1.0 and abs(engine.temperature / energy - 1.0) < 1e-9


def test_monte_carlo_that_ctrl_c_has_stopped_goes_on_to_the_same_bytes():
    for stopped, alone in monte_carlo():
        before = time.monotonic()
        alone.advance(100.0)
        # So far that Ctrl-C comes about in the middle.
        until = 100.0 + 100.0 * 0.6 / (time.monotonic() - before)
        timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
        stopped.advance(100.0)
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            stopped.advance(until)
            # It was faster than before.
            signal.pause()
        timer.join()
        stopped.advance(until)
        alone.advance(until)
        assert stopped.time == alone.time == until and np.array_equal(stopped.velocities, alone.velocities)


def test_ctrl_c_leaves_a_gas_that_is_being_equilibrated_as_it_was():
    engine = EventDriven(gas(2000))
    before = engine.positions.copy()
    interrupted(lambda: engine.equilibrate(1e9))
    assert np.array_equal(engine.positions, before)


def test_an_exception_of_an_observer_stops_the_engine():
    engine, calls = exact(), []

    def observer(collisions):
        calls.append(len(collisions))
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        engine.advance(1e6, observer, batch=10)
    assert calls == [10] and engine.time < 1e6
    engine.advance(engine.time + 0.1)


def test_an_exception_of_an_observer_stops_at_the_same_time_and_the_gas_goes_on_to_the_same_bytes():
    until = 100.0

    def stopped(engine, seconds):
        seen = []

        def observer(collisions):
            seen.append(len(collisions))
            time.sleep(seconds)
            if len(seen) == 20:
                raise RuntimeError("enough")

        with pytest.raises(RuntimeError, match="enough"):
            engine.advance(until, observer, batch=100)
        assert len(seen) == 20
        return engine.time

    start, spheres = exact(2000, 1.0, restitution=1.0).state(), Gas.spheres(1000, restitution=1.0)
    for make in (lambda: EventDriven(start), lambda: MonteCarlo.from_state(start), lambda: MonteCarlo(spheres)):
        one, other, alone = make(), make(), make()
        # The speed of the observer does not matter; exact dynamics checks every 50000 collisions.
        assert 0 < stopped(one, 0.0) == stopped(other, 0.003) < until
        one.advance(until)
        alone.advance(until)
        assert one.collisions == alone.collisions and np.array_equal(one.velocities, alone.velocities)


def test_a_collapse_is_told_again_until_something_changes_and_a_contact_time_prevents_it():
    dense = {"packing_fraction": 0.5, "restitution": 0.3}
    engine, said = EventDriven(Gas.disks(300, **dense)), []
    for _ in range(3):
        with pytest.raises(stosszahl.GasError, match="inelastic collapse .* a contact time above zero") as caught:
            engine.advance(100.0)
        said.append((engine.time, str(caught.value)))
    assert said[0] == said[1] == said[2]
    engine.kick(np.zeros((300, 2)))
    with pytest.raises(stosszahl.GasError, match="inelastic collapse"):
        engine.advance(100.0)
    regular = EventDriven(Gas.disks(300, **dense, contact_time=1e-3))
    regular.advance(100.0)
    assert regular.time == 100.0
    # It is part of the gas: what goes on from a pickled state has it too.
    again = EventDriven(pickle.loads(pickle.dumps(regular.state())))
    again.advance(101.0)


def test_positions_in_any_image_are_taken_into_a_periodic_box():
    gas = Gas.disks(2, box_size=(8, 4), positions=[[-3.0, 17.0], [2.0, 4.0]])
    assert gas.positions.tolist() == [[5.0, 1.0], [2.0, 0.0]]


def test_a_gas_that_particles_have_left_can_be_pickled():
    start = gas(300, species=[(100, 1.0, 4.0)], walls={"y": ("open", "open")})
    chaos = MonteCarlo.from_state(start, "boltzmann")
    chaos.advance(20.0)
    state = chaos.state()
    copy = pickle.loads(pickle.dumps(state))
    assert len(copy) == len(state) < 400 and np.array_equal(copy.species, state.species) and same(copy, state)


def test_observers_say_what_they_have_seen():
    impact, log = stosszahl.ImpactParameters(), stosszahl.CollisionLog(50)
    assert (len(impact), len(log)) == (0, 0) and impact and log
    assert repr(impact) == "<ImpactParameters of 0 collisions>" and repr(log) == "<CollisionLog of 0 collisions, 0 seen>"
    engine = exact()
    before = engine.collisions
    engine.advance(5.0, impact)
    assert len(impact) == impact.collisions == engine.collisions - before
    assert repr(impact) == f"<ImpactParameters of {len(impact)} collisions, slope {impact.slope:.4g}>"
    engine.advance(6.0, log)
    assert len(log) == 50 and repr(log) == f"<CollisionLog of 50 collisions, {log.seen} seen>"


def test_kicks_displacements_and_velocities_of_ones_own():
    engine = exact()
    engine.track_displacements()
    before = engine.velocities.copy()
    engine.kick(np.full((500, 2), [0.5, 0.0]))
    # One addition is rounded in each.
    assert np.abs(engine.velocities - before - [0.5, 0.0]).max() < 1e-14
    engine.scale_velocities(2.0)
    engine.advance(engine.time + 0.5)
    assert engine.displacements.shape == (500, 2)
    # Momentum is that of the kick, 500 times 2 times 0.5.
    assert np.allclose(engine.velocities.sum(axis=0) / 500, [1.0, 0.0], atol=1e-10)
    turned = engine.state().with_velocities(-engine.velocities)
    assert np.array_equal(turned.velocities, -engine.velocities)


def test_a_start_of_ones_own():
    positions = [[2.0, 5.0], [6.0, 5.0]]
    pair = Gas.disks(2, box_size=(10, 10), restitution=0.5, positions=positions, velocities=[[1, 0], [-1, 0]])
    engine = EventDriven(pair)
    engine.advance(2.0)
    # They meet at 1.5, then fly apart at half the speed.
    assert engine.collisions == 1
    assert np.allclose(engine.positions, [[3.25, 5.0], [4.75, 5.0]], atol=1e-14)
    assert np.allclose(engine.velocities, [[-0.5, 0], [0.5, 0]], atol=1e-15)


def test_arrays_cannot_be_written_to():
    with pytest.raises(ValueError):
        gas().positions[0] = 0.0
    with pytest.raises(ValueError):
        exact().velocities[0] = 0.0


def test_laws_of_restitution():
    cold = {"packing_fraction": 0.1, "temperature": 0.01, "seed": 2}
    heated = Gas.disks(200, restitution=stosszahl.DeltaModel(0.8, 0.1), **cold)
    assert heated.haff_time is None and pickle.loads(pickle.dumps(heated)).temperature == heated.temperature
    for engine in (EventDriven(heated), MonteCarlo.from_state(heated, "enskog")):
        engine.advance(400)
        # T = 0.207 for a Maxwellian; 200 disks fluctuate by 1/sqrt(N) = 7 %, here allowed fivefold.
        assert engine.temperature == pytest.approx(0.207, rel=0.35)
    # No disk is as fast as the threshold, so that all contacts are elastic.
    slow = EventDriven(Gas.disks(200, restitution=stosszahl.ThresholdModel(0.5, 100.0), packing_fraction=0.1))
    before = slow.temperature
    slow.advance(20)
    assert slow.collisions > 500 and slow.temperature == pytest.approx(before, rel=1e-12)
    for law, words in [
        (stosszahl.DeltaModel(0.9, -1), "added speed Delta"),
        (stosszahl.ThresholdModel(1.5, 1), "coefficient of restitution"),
    ]:
        with pytest.raises(stosszahl.GasError, match=words):
            Gas.disks(10, restitution=law)


def test_a_sheared_gas_goes_on_from_its_pickled_state():
    gas = Gas.disks(200, packing_fraction=0.3, restitution=0.9, shear_rate=0.7, seed=3)
    assert gas.shear_offset == 0 and gas.haff_time is None
    exact = EventDriven(gas)
    exact.equilibrate(5)
    exact.advance(3.3)
    state = exact.state()
    assert state.shear_offset == pytest.approx(0.7 * 3.3 * state.box[1] % state.box[0], rel=1e-12)
    again = EventDriven(pickle.loads(pickle.dumps(state)))
    exact.advance(3.8)
    again.advance(3.8)
    # Rounding of 1e-14, which some ten collisions of a disk raise by a factor of ten each at most.
    assert again.collisions > 100 and np.abs(again.velocities - exact.velocities).max() < 1e-4
    assert MonteCarlo.from_state(state, "enskog").temperature == state.temperature
    with pytest.raises(stosszahl.GasError, match="equilibration of a shear flow that has begun"):
        exact.equilibrate(1)
    across = MonteCarlo.from_state(state)
    across.advance(4.3)
    assert across.collisions > 100 and across.state().shear_offset != state.shear_offset
    with pytest.raises(stosszahl.GasError, match="shear rate is 0"):
        Gas.disks(10, shear_rate=0)
