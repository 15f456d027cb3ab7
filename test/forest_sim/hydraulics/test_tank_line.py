"""Claims about the tank line: what it passes at rest and how its pressure gets there."""

import pytest
from driven_pump import TANK_LINE
from scipy.integrate import solve_ivp

from forest_sim.hydraulics.tank_line import (
    DRAINED,
    NO_LINE,
    TankState,
    line_flow,
    pressure_after,
    pressure_at_stage,
    return_line,
)
from forest_sim.solver.integrator import GAMMA, WEIGHTS

LINE = return_line(TANK_LINE)


def steady(flow):
    return TANK_LINE.preload + TANK_LINE.resistance * flow**2


def after(pressure, flow, step):
    state = TankState(pressure, pressure)
    for weight in WEIGHTS:
        seen = pressure_at_stage(state, flow, 0.0, GAMMA * step, LINE)
        state = pressure_after(state._replace(seen=seen), flow, weight * step, LINE)
    return state.pressure


@pytest.mark.parametrize("flow", [1e-4, 1e-3, 4e-3])
def test_it_settles_where_it_passes_what_comes(flow):
    pressure = 0.0
    for _ in range(20000):
        pressure = after(pressure, flow, 1e-3)
    assert pressure == pytest.approx(steady(flow), rel=1e-9)
    assert line_flow(pressure, LINE) == pytest.approx(flow, rel=1e-9)


def test_a_long_stage_sees_the_steady_pressure_and_open_port_valves_do_not_change_it():
    assert pressure_at_stage(DRAINED, 2e-3, 0.0, 1e6, LINE) == pytest.approx(steady(2e-3), rel=1e-6)
    settled = TankState(steady(2e-3), steady(2e-3))
    assert pressure_at_stage(settled, 2e-3, 1e-7, 1e-3, LINE) == pytest.approx(steady(2e-3), rel=1e-12)


def test_it_holds_its_preload_and_is_never_drawn_empty():
    assert after(1.5e5, 0.0, 1e-3) == 1.5e5
    assert after(1e4, -1e-3, 1e-2) == 0.0
    assert line_flow(2e5, LINE) == line_flow(0.0, LINE) == line_flow(0.0, NO_LINE) == 0.0
    assert pressure_after(DRAINED, 0.0, 1e-3, LINE) == DRAINED


def test_what_comes_and_does_not_go_on_stays_in_it():
    """C dP_t is what the valves return less what the line passes at the pressure that they see."""
    state = TankState(2.5e5, 2.6e5)
    stored = LINE.capacitance * (pressure_after(state, 3e-3, 1e-3, LINE).pressure - 2.5e5)
    assert stored == pytest.approx(1e-3 * (3e-3 - (0.6e5 / 4.5e10) ** 0.5), rel=1e-12)


def test_what_port_valves_take_too_much_is_owed_and_made_good():
    """No oil is made while the line stands above zero; an open suction check gives what is missing."""
    taken = pressure_after(TankState(1e4, 5e3), -1e-3, 1e-3, LINE)
    assert taken.pressure == 0.0
    assert taken.owed == pytest.approx(1e4 - 1e-6 / LINE.capacitance, rel=1e-12)
    back = pressure_after(taken, 1e-3, 1e-3, LINE)
    assert back.pressure == pytest.approx(1e4, rel=1e-9)
    assert back.owed == 0.0
    assert pressure_after(TankState(1e4, 0.0), -1e-3, 1e-3, LINE) == TankState(0.0, 0.0)
    assert pressure_at_stage(taken, 0.0, 0.0, 1e-3, LINE) == 0.0


def test_its_rise_is_that_of_an_independent_integration_with_second_order():
    flow, end = 3e-3, 6e-3
    exact = solve_ivp(
        lambda _, p: (flow - max(0.0, (p[0] - 2e5) / 4.5e10) ** 0.5) / 1.5e-11,
        (0.0, end),
        [2.2e5],
        rtol=1e-11,
        atol=1e-6,
    ).y[0, -1]
    errors = []
    for count in (6, 12, 24):
        pressure = 2.2e5
        for _ in range(count):
            pressure = after(pressure, flow, end / count)
        errors.append(abs(pressure - exact))
    assert errors[0] < 5e-3 * exact
    assert errors[1] < 0.35 * errors[0]
    assert errors[2] < 0.35 * errors[1]
