"""Claims about the spool that the driver knows: it is the simulated one, and the play's inverse undoes it."""

import math

import numpy as np
import pytest

from forest_control.valve import valve_driver, valve_driver_parameters
from forest_control.valve.spool_model import LEFT, SpoolLaw, after, before_play, behind_play
from forest_control.valve.valve_driver import REST, STILL, UNSEEN
from forest_description.machine import load_machine
from forest_sim.hydraulics.spool_dynamics import Spool, SpoolLag, spool_after

PERIOD = 0.005
REAL = load_machine("c180_real")
PLAY = REAL.valve.hysteresis
NEVER = math.inf


@pytest.mark.parametrize("lag", [0.0, 0.0133])
@pytest.mark.parametrize("play", [0.0, 0.4])
@pytest.mark.parametrize("slew", [NEVER, 250.0, 40.0])
def test_the_drivers_spool_is_the_simulated_one(lag, play, slew):
    rng = np.random.default_rng(3)
    simulated = SpoolLag(1.0 / lag if lag > 0.0 else math.inf, 0.0, play, slew)
    law, spool, u, y = SpoolLaw(lag, play, slew), Spool(0.0, 0.0), 0.0, 0.0
    for voltage, dt in zip(rng.normal(0.0, 3.0, 400), rng.uniform(0.0, 0.02, 400), strict=True):
        spool = spool_after(spool, voltage, dt, simulated)
        u = behind_play(u, voltage, play)
        y = after(y, u, law, dt)
        assert y == pytest.approx(spool.position, abs=1e-12)


def test_behind_the_play_stands_what_the_inverse_was_asked_for():
    """Within `LEFT` of the play, over reversals as they come; from where the play is not known, too."""
    rng, u, voltage = np.random.default_rng(4), 0.5 * PLAY, 0.0
    for wanted in np.cumsum(rng.normal(0.0, 0.1, 1000)):
        voltage = before_play(u, wanted, voltage, PLAY)
        u = behind_play(u, voltage, PLAY)
        assert abs(u - wanted) <= LEFT * PLAY
    assert before_play(0.3, 0.7, 0.1, 0.0) == 0.7  # without play, to the last bit


def test_a_wish_that_hardly_turns_leaves_the_voltage_where_it_is():
    assert before_play(1.5, 1.5 - 0.9 * LEFT * PLAY, 1.7, PLAY) == 1.7
    assert before_play(1.5, 1.5 - 1.1 * LEFT * PLAY, 1.7, PLAY) == pytest.approx(
        1.5 - 1.1 * LEFT * PLAY - 0.2
    )


def test_the_driver_of_a_valve_with_hysteresis_turns_back_by_its_width():
    """In motion each axis' command goes up, and back by a tenth: the simulated spool follows to 20 mV."""
    p = valve_driver_parameters.parameters(REAL, valve_driver_parameters.Settings())
    plain = tuple(axis._replace(spool=SpoolLaw()) for axis in p.axes)
    state, without, targets = REST, REST, [0.0, 0.0, 0.0]
    for k in range(200):
        command = (3.0 + math.sin(0.05 * k),) * 3
        state, volts = valve_driver.step(state, command, UNSEEN, STILL, p, PERIOD)
        without, wished = valve_driver.step(without, command, UNSEEN, STILL, p._replace(axes=plain), PERIOD)
        targets = [behind_play(u, v, PLAY) for u, v in zip(targets, volts, strict=True)]
        if k > 20:  # across the overlap
            assert targets == pytest.approx(wished, abs=1.01 * LEFT * PLAY)


def test_without_what_lies_beyond_the_valve_the_driver_knows_no_hysteresis():
    p = valve_driver_parameters.parameters(REAL, valve_driver_parameters.Settings(beyond_valve=False))
    assert all(axis.spool == SpoolLaw() for axis in p.axes)


@pytest.mark.parametrize(("name", "play"), [("c180_real", 0.4), ("forwarder", 0.0), ("c180", 0.0)])
def test_the_hysteresis_of_a_spool_that_flow_forces_push_is_not_inverted(name, play):
    p = valve_driver_parameters.parameters(load_machine(name), valve_driver_parameters.Settings())
    assert [axis.spool.play for axis in p.axes] == [play] * 3
