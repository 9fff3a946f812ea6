"""E of a step, and its derivatives."""

import numpy as np
import pytest

import supple
from conftest import pressed


@pytest.fixture()
def potential(finger):
    """A pressed, tracked finger some steps on its way, moved off by a little."""
    sim = pressed(finger)
    sim.track(np.zeros((3, 3)), rotation=(1.0, 0.01), position=(1e3, 1.0))
    for _ in range(3):
        sim.step(0.01)
    off = np.random.default_rng(5).normal(scale=1e-4, size=finger.dofs)
    return sim.potential(0.01).moved(off)


def test_the_gradient_is_that_of_the_energy(potential):
    gradient = potential.gradient()
    step = 1e-6
    for k in range(0, potential.dofs, 5):
        e = np.zeros(potential.dofs)
        e[k] = step
        expected = (potential.moved(e).energy() - potential.moved(-e).energy()) / (2 * step)
        # Central differences: the third derivative's share, and the energy's rounding.
        assert gradient[k] == pytest.approx(expected, abs=1e-5 * np.abs(gradient).max()), k
    assert sum(potential.energies().values()) == pytest.approx(potential.energy(), rel=1e-12)


def test_the_exact_hessian_is_that_of_the_gradient(potential):
    exact = potential.hessian("exact", dense=True)
    step = 1e-6
    chosen = np.r_[0:18, 18 : potential.dofs : 11]
    columns = []
    for k in chosen:
        e = np.zeros(potential.dofs)
        e[k] = step
        ahead, behind = potential.moved(e).gradient(), potential.moved(-e).gradient()
        columns.append((ahead - behind)[chosen] / (2 * step))
    # Rotations do not commute: off equilibrium only the symmetric part is a second derivative.
    expected = np.array(columns)
    expected = 0.5 * (expected + expected.T)
    found = exact[np.ix_(chosen, chosen)]
    assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max()


def test_the_solvers_hessian_is_convex_and_sparse(potential):
    dense = potential.hessian(dense=True)
    assert np.abs(dense - dense.T).max() < 1e-14 * np.abs(dense).max()
    lowest = np.linalg.eigvalsh(dense)[0]
    assert lowest > -1e-10 * np.abs(dense).max()
    sparse = pytest.importorskip("scipy.sparse")
    found = potential.hessian()
    assert sparse.issparse(found) and found.format == "csr"
    assert np.array_equal(found.toarray(), dense)
    assert found.nnz < dense.size


def test_a_step_ends_at_the_minimum(finger):
    sim = pressed(finger, solver="converged")
    sim.step(0.01)
    potential = sim.potential(0.01)
    free = ~potential.fixed
    # All bones are pinned: what is free are the handles.
    assert free.sum() == 3 * len(finger.handles)
    before = np.abs(potential.gradient()[free]).max()
    sim.step(0.01)
    after = np.abs(potential.at_state_of(sim).gradient()[free]).max()
    assert before > 1e-6 and after < 1e-3 * before, (before, after)


def test_a_newton_step_of_ones_own_is_the_simulations(finger):
    """The whole step from Python: scipy solves, and lands where the engine does."""
    sim = pressed(finger, solver="converged")
    for _ in range(3):
        sim.step(0.01)
    potential = sim.potential(0.01)
    free = np.flatnonzero(~potential.fixed)
    here = potential
    for _ in range(30):
        gradient, hessian = here.gradient()[free], here.hessian(dense=True)[np.ix_(free, free)]
        delta = np.zeros(here.dofs)
        delta[free] = np.linalg.solve(hessian, -gradient)
        here = here.moved(delta)
    step = sim.step(0.01)
    assert np.abs(here.handles - step.handles).max() < 1e-7


def test_a_potential_stays_when_the_simulation_goes_on(finger):
    sim = pressed(finger)
    potential = sim.potential(0.01)
    before = potential.gradient()
    sim.step(0.01)
    assert np.array_equal(potential.gradient(), before)


def test_what_cannot_be_asked_is_named(finger, potential):
    with pytest.raises(supple.InvalidError, match=r"delta: has the shape \(3,\); expected \(dofs="):
        potential.moved([0, 0, 0])
    with pytest.raises(supple.InvalidError, match="form: "):
        potential.hessian("newton")
    with pytest.raises(supple.InvalidError, match="dt: "):
        supple.Simulation(finger, "cpu").potential(0.0)
