"""The coded equations of motion against Appendix B, and the energy that they must conserve."""

import math

import appendix_b
import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_sim.equations.appendix_b import from_array, thesis_state_derivative, to_array
from forest_sim.equations.plant import transmissions
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import valve_ports
from forest_sim.hydraulics.port import Port
from forest_sim.solver.equilibrium import equilibrium

THESIS = load_machine("c180_thesis")
SUPPLY = 3000 * 6894.7


def random_state(rng):
    x = np.zeros(18)
    x[0::6] = rng.uniform((-3.0, -0.6, -2.1), (3.0, 1.2, -0.9))
    x[1::6] = rng.normal(0.0, 0.5, 3)
    for axis in range(3):
        x[6 * axis + 2 : 6 * axis + 4] = rng.uniform(0.0, SUPPLY, 2)
        x[6 * axis + 4 : 6 * axis + 6] = rng.normal(0.0, 2e-3, 2)
    return x


def test_derivative_equals_the_corrected_appendix_b():
    rng = np.random.default_rng(20)
    for _ in range(300):
        x, c_r = random_state(rng), 10.0 ** rng.uniform(10.0, 16.0, 6)
        ours, theirs = (
            thesis_state_derivative(x, c_r, SUPPLY, THESIS),
            appendix_b.state_derivative(x, c_r, SUPPLY),
        )
        assert np.max(np.abs(ours - theirs)) < 1e-11 * np.max(np.abs(theirs))
        # The largest component hides the small ones; the joint accelerations are compared on their own.
        np.testing.assert_allclose(ours[1::6], theirs[1::6], rtol=1e-8, atol=1e-8)


def test_the_default_machine_differs_from_the_thesis_only_where_it_says():
    """Stick's I and C are right, inertias such that bodies can have them: stick's hoses and swing differ.

    The port valves rest, and the inertias about the links' own axes reach boom and stick only through the
    swing's rate.
    """
    x = random_state(np.random.default_rng(3))
    x[1], x[2::6], x[3::6] = 0.0, 5e6, 4e6  # inside the port valves' range
    c_r = np.full(6, 1e13)
    thesis, ours = (thesis_state_derivative(x, c_r, SUPPLY, m) for m in (THESIS, load_machine("c180_hoses")))
    same = [i for i in range(18) if i not in (1, 14, 15, 16, 17)]
    np.testing.assert_allclose(ours[same], thesis[same], rtol=1e-12)
    assert 0.95 < ours[1] / thesis[1] < 1.0
    ratio_1, ratio_2 = 3.8 / 4, 4.9 / 4
    np.testing.assert_allclose(ours[14:18] / thesis[14:18], [ratio_1, ratio_2, ratio_1, ratio_2], rtol=1e-9)


@pytest.mark.parametrize(
    ("x", "c_r", "p_s", "named"),
    [
        (np.zeros(17), np.ones(6), 1e7, "18"),
        (np.full(18, math.nan), np.ones(6), 1e7, "18 finite"),
        (np.zeros(18), np.ones(5), 1e7, "6 resistances"),
        (np.zeros(18), -np.ones(6), 1e7, "at least 0"),
        (np.zeros(18), np.ones(6), math.inf, "p_s"),
    ],
)
def test_bad_input_is_named(x, c_r, p_s, named):
    with pytest.raises(ValueError, match=named):
        thesis_state_derivative(x, c_r, p_s, THESIS)


def test_a_shut_crane_in_equilibrium_has_no_derivative():
    rest = equilibrium((0.3, 0.5, -1.5), plant_parameters(THESIS))
    derivative = thesis_state_derivative(to_array(rest.plant), np.full(6, math.inf), SUPPLY, THESIS)
    np.testing.assert_allclose(derivative, np.zeros(18), atol=1e-9)


def test_array_and_state_are_inverse():
    x = np.arange(18.0)
    np.testing.assert_array_equal(to_array(from_array(x, SUPPLY)), x)
    assert from_array(x, SUPPLY).supply == (SUPPLY, SUPPLY)


def test_spool_connects_port_1_to_supply_forwards_and_port_2_backwards():
    p = plant_parameters(THESIS)
    forward, backward, shut = (valve_ports(v, p.valves[0].law) for v in (5.0, -5.0, 0.5))
    c_r = forward.port_1.to_supply
    assert c_r < math.inf
    assert forward[:2] == (Port(c_r, math.inf, 0.0), Port(math.inf, c_r, 0.0))
    assert backward[:2] == (Port(math.inf, c_r, 0.0), Port(c_r, math.inf, 0.0))
    assert (forward.sensed, backward.sensed, shut.sensed) == ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0))
    assert shut[:2] == (Port(math.inf, math.inf, 0.0),) * 2


def test_lever_arms_are_the_derivative_of_the_cylinder_lengths():
    p, h = plant_parameters(THESIS), 1e-6
    for boom, stick in np.random.default_rng(4).uniform((-0.6, -2.1), (1.2, -0.9), (50, 2)):
        here = transmissions(0.3, boom, stick, p)
        above, below = transmissions(0.3, boom + h, stick + h, p), transmissions(0.3, boom - h, stick - h, p)
        for t, a, b in zip(here[1:], above[1:], below[1:], strict=True):
            assert t.arm == pytest.approx((a.position - b.position) / (2 * h), rel=1e-8)
        assert here[0].position == 0.3
        assert here[0].arm == 1.0


def total_power_balance(x, c_r):
    """Return (rate of change of stored energy, power in minus losses) [W], from the derivative alone."""
    d = thesis_state_derivative(x, c_r, SUPPLY, THESIS)
    p = plant_parameters(THESIS)
    h = 1e-6
    energies = [kinetic_and_potential(x + s * h * np.where(np.arange(18) % 6 < 2, d, 0.0)) for s in (1, -1)]
    stored = (energies[0] - energies[1]) / (2 * h)
    power = 0.0
    state, arms = from_array(x, SUPPLY), transmissions(x[0], x[6], x[12], p)
    for i, (s, axis, t) in enumerate(zip(state[:3], (p.swing, p.boom, p.stick), arms, strict=True)):
        k = 6 * i
        stored += (
            axis.line_1.capacitance * s.pressure_1 * d[k + 2]
            + axis.line_2.capacitance * s.pressure_2 * d[k + 3]
        )
        stored += axis.line_1.inertance * s.flow_1 * d[k + 4] + axis.line_2.inertance * s.flow_2 * d[k + 5]
        power += SUPPLY * s.flow_1 - c_r[2 * i] * abs(s.flow_1) ** 3 - c_r[2 * i + 1] * abs(s.flow_2) ** 3
        power -= actuator_losses(i, s, t.arm * s.rate, axis)
    return stored, power


def actuator_losses(index, s, u, axis):
    """Return friction, hose and leakage losses [W], each from its own element, not from the reduced law."""
    if index:
        a, r_1, r_2 = (THESIS.boom, THESIS.stick)[index - 1], axis.line_1.resistance, axis.line_2.resistance
        return a.damping * u**2 + r_1 * abs(a.head_area * u) ** 3 + r_2 * abs(a.rod_area * u) ** 3
    drive, d = THESIS.swing, THESIS.swing.gear_ratio * THESIS.swing.motor_displacement
    r_1, r_2 = axis.line_1.resistance, axis.line_2.resistance
    r_i, r_e = drive.internal_leakage_resistance, drive.external_leakage_resistance
    nodes = np.array([[1 / r_1 + 1 / r_i + 1 / r_e, -1 / r_i], [-1 / r_i, 1 / r_2 + 1 / r_i + 1 / r_e]])
    p_1, p_2 = np.linalg.solve(nodes, [s.pressure_1 / r_1 - d * u, s.pressure_2 / r_2 + d * u])
    hoses = (s.pressure_1 - p_1) ** 2 / r_1 + (p_2 - s.pressure_2) ** 2 / r_2
    return hoses + (p_1 - p_2) ** 2 / r_i + (p_1**2 + p_2**2) / r_e + drive.damping * u**2


def kinetic_and_potential(x):
    """Return the manipulator's energy [J] from point masses and inertias, not from M, V, G."""
    m = THESIS.manipulator
    q1, q2, q3 = x[0], x[6], x[12]
    u1, u2, u3 = x[1], x[7], x[13]
    bodies = (
        (m.boom_mass, m.boom_x, m.boom_y, m.boom_yy, m.boom_zz, 0.0, q2, u2),
        (m.stick_mass, m.stick_x, m.stick_y, m.stick_yy, m.stick_zz, m.boom_length, q2 + q3, u2 + u3),
        (m.head_mass, m.stick_length, 0.0, 0.0, 0.0, m.boom_length, q2 + q3, u2 + u3),
    )
    energy = 0.5 * (m.base_zz + m.base_mass * m.base_x**2) * u1**2
    for mass, along, across, i_yy, i_zz, carried, angle, turn in bodies:
        r = m.base_offset + carried * np.cos(q2) + along * np.cos(angle) - across * np.sin(angle)
        z = carried * np.sin(q2) + along * np.sin(angle) + across * np.cos(angle)
        v_r = -carried * np.sin(q2) * u2 - (along * np.sin(angle) + across * np.cos(angle)) * turn
        v_z = carried * np.cos(q2) * u2 + (along * np.cos(angle) - across * np.sin(angle)) * turn
        energy += 0.5 * mass * (v_r**2 + v_z**2 + (r * u1) ** 2) + mass * m.gravity * z
        energy += 0.5 * i_zz * turn**2 + 0.5 * i_yy * (np.cos(angle) * u1) ** 2
    return energy + q1 * 0.0


def test_stored_energy_changes_by_supplied_power_minus_losses():
    """The whole machine's power balance; at the head's I_yy shift Appendix B and point masses must agree.

    Appendix B folds I3yy with x offsets only and leaves I3xy out, so the swing's kinetic energy is compared
    with the swing at rest, where those terms do not enter.
    """
    rng = np.random.default_rng(7)
    for _ in range(50):
        x, c_r = random_state(rng), 10.0 ** rng.uniform(12.0, 14.0, 6)
        x[1] = 0.0
        stored, power = total_power_balance(x, c_r)
        assert stored == pytest.approx(power, rel=1e-6, abs=1.0)
