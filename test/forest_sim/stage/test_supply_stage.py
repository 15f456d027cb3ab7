"""The manifold's equation of a stage against its own slopes: by P_s and by every joint's rate."""

import pytest

from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.midpoint.load_sensing import load_weights
from forest_sim.solver import integrator
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.stage import stage_equations
from forest_sim.stage.supply_stage import AxisDraw, load_sensing

CASES = [("loader", (0.0, 3.0, 0.0)), ("loader", (0.0, 0.0, -3.0)), ("forwarder", (0.0, 0.0, -3.0))]  # [V]


def last_equations(machine, volts, monkeypatch):
    """The manifold's equation after 0.1 s of motion, as a function of the iterate; and an iterate."""
    given, inner = [], stage_equations.equations_at

    def recorded(*arguments):
        given[:] = arguments
        return inner(*arguments)

    p = plant_parameters(load_machine(machine))
    moving = integrator.advance(equilibrium((0.0, 0.5, -1.5), p), volts, 5e-3, 20, p)
    monkeypatch.setattr(stage_equations, "equations_at", recorded)
    integrator.step(moving, volts, 1e-3, p)
    base, near, iterate, *rest = given
    return lambda at: inner(base, near, at, *rest)[0].supply, iterate


def at_pressure(iterate, more):
    return iterate._replace(supply=iterate.supply._replace(pressure=iterate.supply.pressure + more))


def at_rates(iterate, axis, more, machine):
    """An iterate with another rate of a joint; the forwarder's actuators are behind play and links."""
    moved = tuple(u + more * (i == axis) for i, u in enumerate(iterate.rates))
    if machine == "forwarder":
        return iterate._replace(rates=moved)
    return iterate._replace(rates=moved, root_rates=moved, motor_rate=moved[0])


@pytest.mark.parametrize(("machine", "volts"), CASES)
def test_the_manifolds_slopes_are_its_equations(machine, volts, monkeypatch):
    supply, iterate = last_equations(machine, volts, monkeypatch)
    here = supply(iterate)
    low, high = (supply(at_pressure(iterate, d)) for d in (-100.0, 100.0))
    assert (high.residual - low.residual) / 200.0 == pytest.approx(here.slope, rel=1e-4)
    followed = (high.state.reference - low.state.reference) / 200.0
    assert followed == pytest.approx(here.control.by_supply, rel=1e-4)
    assert followed > 0.0
    for axis in range(3):
        low, high = (supply(at_rates(iterate, axis, d, machine)) for d in (-1e-5, 1e-5))
        by_rate, near = (high.residual - low.residual) / 2e-5, 1e-3 * max(map(abs, here.by_rate))
        assert by_rate == pytest.approx(here.by_rate[axis], rel=1e-2, abs=near)
        if machine == "loader":
            followed = (high.state.reference - low.state.reference) / 2e-5
            assert followed == pytest.approx(here.control.by_rate[axis], rel=1e-2, abs=1e-2)


def test_a_load_counts_by_its_share_of_the_step():
    assert load_weights((5.0, 3.0, 0.0), (1.0, 1.0, 0.0)) == (1.0, 0.0, 0.0)
    assert load_weights((5.0, 3.0, 7.0), (0.25, 1.0, 0.0)) == (0.25, 0.75, 0.0)
    assert load_weights((1.0, 3.0, 7.0), (0.25, 1.0, 0.0)) == (0.0, 1.0, 0.0)
    assert load_weights((4.0, 3.0, 7.0), (0.5, 0.0, 0.0)) == (0.5, 0.0, 0.0)
    assert load_weights((-4.0, 0.0, 0.0), (1.0, 0.5, 0.0)) == (0.0, 0.0, 0.0)


def draw(load, share):
    """An axis that shows a load [Pa] for a share of the step, and more with P_s and with its speed."""
    return AxisDraw(1e-3, 0.0, 0.0, load, 0.5, 1e6, share, (0.0, 0.0))


def test_a_load_above_the_lines_relief_counts_by_its_share_of_the_step_too():
    """The line's relief valve leaves 21.6 MPa of 29: they count for a quarter of the step."""
    pump = plant_parameters(load_machine("forwarder")).supply

    def after(load, share):
        return load_sensing(
            14e6, draw(load, share), draw(12e6, 1.0), draw(0.0, 0.0), (1.0, 1.0, 1.0), 3e-4, pump
        )

    (none, _), (quarter, control), (whole, _) = after(0.0, 0.0), after(29e6, 0.25), after(29e6, 1.0)
    assert whole - none > 5e4
    assert quarter - none == pytest.approx(0.25 * (whole - none), rel=1e-9)
    assert control.by_rate[0] == 0.0 < control.by_rate[1]
    assert after(20e6, 0.25)[1].by_rate[0] > 0.0
