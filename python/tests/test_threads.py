"""Beside other threads of Python: the GIL is released, Ctrl-C ends long work."""

import os
import pickle
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import supple
from conftest import pressed


class Counter:
    """A thread of Python that counts as fast as it is let."""

    def __enter__(self):
        self.count, self.on = 0, True
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()
        return self

    def run(self):
        while self.on:
            self.count += 1

    def __exit__(self, *_):
        self.on = False
        self.thread.join()


def test_a_bake_lets_other_threads_run(quick):
    with Counter() as counter:
        before = counter.count
        supple.Avatar.sample("finger", recipe=quick)
        # Held by the bake, it would stand still, but for the moments around the call.
        assert counter.count - before > 100_000


def test_a_step_lets_other_threads_run(finger):
    """Another thread runs in the midst of steps, by the step's own clock: after them it may always."""
    sim = pressed(finger)
    ticks, on = [0.0], [True]

    def run():
        while on:
            now = time.perf_counter()
            if now - ticks[-1] > 2e-5:
                ticks.append(now)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    inside = 0
    for _ in range(60):
        begun = time.perf_counter()
        seconds = 1e-3 * sim.step(0.01).report["ms"]["step"]
        within = np.array(ticks) - begun
        inside += bool(((within > 0.2 * seconds) & (within < 0.8 * seconds)).any())
    on.clear()
    thread.join()
    # All of them on a machine with nothing else to do; none if steps held the GIL.
    assert inside >= 6, inside


def test_simulations_in_threads_are_those_in_turn(finger):
    def run(softness):
        sim = pressed(finger, softness=softness)
        return [sim.step(0.01).vertices for _ in range(5)][-1]

    kinds = [0.5, 1.0, 2.0, 4.0]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(run, kinds))
    assert all(np.array_equal(a, run(kind)) for a, kind in zip(together, kinds))


def test_one_simulation_in_two_threads_is_refused_or_waits(finger):
    """Never undefined: a second thread that comes into a step is told so."""
    sim = supple.Simulation(finger, "cpu")
    refused = []

    def step(_):
        try:
            for _ in range(30):
                sim.step(0.005)
        except RuntimeError as error:
            refused.append(str(error))

    with ThreadPoolExecutor(3) as pool:
        list(pool.map(step, range(3)))
    assert all("borrowed" in text for text in refused), refused
    assert np.isfinite(sim.step(0.01).vertices).all()


@pytest.fixture
def ctrl_c():
    """SIGINT as a terminal has it: a process that was started in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(os.name == "nt", reason="no SIGINT to send to oneself on Windows")
def test_ctrl_c_ends_a_bake(ctrl_c):
    def interrupt():
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.4, interrupt)
    timer.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        # The finest of the samples, which takes much longer.
        supple.Avatar.sample("hand", recipe={"handles": [{"count": 150}], "cubature": {"points": 3000}})
        time.sleep(5.0)
    assert time.monotonic() - begun < 3.0
    timer.join()


@pytest.mark.skipif(os.name == "nt", reason="no SIGINT to send to oneself on Windows")
def test_ctrl_c_ends_a_clip(finger, ctrl_c):
    sim = supple.Simulation(finger, "cpu")
    timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        sim.simulate(duration=600.0, record=[])
    assert time.monotonic() - begun < 5.0
    timer.join()
    # It stands where it was, and goes on.
    assert sim.time > 0.0
    sim.step(0.01)


def test_what_a_progress_raises_ends_the_bake(quick):
    def progress(done, of, name):
        if name == "basis":
            raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        supple.Avatar.sample("finger", recipe=quick, progress=progress)


def test_errors_go_through_a_pool_of_processes():
    with pytest.raises(supple.Error) as caught:
        supple.Avatar.load("nowhere.npz")
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is supple.MissingFileError
    assert (str(again), again.path) == (str(caught.value), "nowhere.npz")
