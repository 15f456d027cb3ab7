"""Claims about a forwarder in the closed loop: what pressed oil and load feedback are worth to it."""

import pytest

from forest_control.valve import valve_driver_parameters
from forest_control.valve.inlet_oil import FreeAir, Holding
from forest_study.notebook import closed_loop


@pytest.fixture(autouse=True)
def remake(monkeypatch):
    """Parameters are kept while file and settings stay: have them made without what a test leaves out."""
    make = valve_driver_parameters.parameters.__wrapped__
    monkeypatch.setattr(valve_driver_parameters, "parameters", make)


def test_pressed_oil_takes_a_third_of_what_the_tip_of_a_forwarder_falls_behind_by(monkeypatch):
    """Its swing's ports are empty, and its stick's valve is opened by 13 MPa."""

    def furthest():
        path = [(6.0, 0.0, 0.5), (6.0, 1.5, 0.5)]
        return closed_loop("forwarder").follow(path, speed=0.5).score.governed_max_mm

    pressed = furthest()
    monkeypatch.setattr(valve_driver_parameters, "free_air", lambda *_: FreeAir())
    monkeypatch.setattr(valve_driver_parameters, "holding", lambda _: Holding())
    assert furthest() > 1.5 * pressed


def test_a_forwarder_that_lowers_rocks_less_than_half_as_much(monkeypatch):
    """Its counterbalance valves and compensators make boom and stick swing at 2 Hz."""

    def error():
        score = closed_loop("forwarder").follow("radial", speed=0.5).score
        return score.velocity_rms

    calm = error()
    monkeypatch.setattr(valve_driver_parameters, "load_feedback", lambda *_: 0.0)
    assert calm < 0.08
    assert error() > 2.0 * calm
