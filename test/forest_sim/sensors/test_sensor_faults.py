"""Claims about the text that names faults: what it may say, and what its errors say."""

import math

import pytest

from forest_sim.sensors.sensor_faults import ALLOWED, parse_faults
from forest_sim.sensors.sensor_model import ABSENT, DROPPED, FROZEN, WORKS
from forest_sim.sensors.sensor_suite import CHANNELS, Fault


@pytest.mark.parametrize(
    ("text", "name", "rest"),
    [
        ("swing_flow: absent", "swing_flow", (ABSENT, 0.0, 1.0, 0.0, math.inf)),
        ("boom_resolver: frozen from 2 s", "boom_resolver", (FROZEN, 0.0, 1.0, 2.0, math.inf)),
        ("boom_resolver:frozen until 2.5s", "boom_resolver", (FROZEN, 0.0, 1.0, 0.0, 2.5)),
        (
            "stick_pressure_1_valve: bias 0.5 MPa",
            "stick_pressure_1_valve",
            (WORKS, 5e5, 1.0, 0.0, math.inf),
        ),
        (
            "engine_speed: bias -30 rpm from 1 s until 1e1 s",
            "engine_speed",
            (WORKS, pytest.approx(-math.pi), 1.0, 1.0, 10.0),
        ),
        ("boom_transducer: drop 20 %", "boom_transducer", (DROPPED, 0.0, 0.2, 0.0, math.inf)),
        ("boom_transducer: drop 12.5% from 3 s", "boom_transducer", (DROPPED, 0.0, 0.125, 3.0, math.inf)),
        ("boom_resolver: noise 500 % from 1 s", "boom_resolver", (WORKS, 0.0, 1.0, 1.0, math.inf, 5.0)),
        ("boom_transducer: drop from 1 s until 2 s", "boom_transducer", (DROPPED, 0.0, 1.0, 1.0, 2.0)),
    ],
)
def test_words_become_faults(text, name, rest):
    assert parse_faults(text) == (Fault(CHANNELS.index(name), *rest),)


@pytest.mark.parametrize("text", ["", "  ", ";", "\n ; \n"])
def test_no_words_are_no_faults(text):
    assert parse_faults(text) == ()


def test_faults_are_separated_by_semicolons_and_lines_in_their_order():
    faults = parse_faults("swing_flow: absent; boom_resolver: frozen\nboom_resolver: bias 1 deg;")
    assert [CHANNELS[fault.channel] for fault in faults] == ["swing_flow", "boom_resolver", "boom_resolver"]
    assert [fault.mode for fault in faults] == [ABSENT, FROZEN, WORKS]


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("boom_resolvr: frozen", ["no sensor 'boom_resolvr'", ", ".join(CHANNELS)]),
        ("frozen", ["no sensor 'frozen'", "boom_resolver"]),
        ("swing_flow: absent; boom: frozen", ["'boom: frozen': there is no sensor 'boom'"]),
        ("boom_resolver: froze", ["'froze' is no fault", ALLOWED]),
        ("boom_resolver:", ["'' is no fault", ALLOWED]),
        ("boom_resolver: frozen since 2 s", ["'frozen since 2 s' is no fault", ALLOWED]),
        ("boom_resolver: frozen from 2", ["'frozen from 2' is no fault", ALLOWED]),
        ("boom_resolver: frozen 2 s", ["'frozen' takes no amount", ALLOWED]),
        ("boom_resolver: absent until 3 s from 1 s", ["is no fault", ALLOWED]),
        ("boom_resolver: noise", ["noise needs a share; allowed: 0 .. 1e+06 %"]),
        ("boom_resolver: noise 5 deg", ["noise needs a share; allowed: 0 .. 1e+06 %"]),
        ("boom_resolver: noise 2e6 %", ["noise needs a share; allowed: 0 .. 1e+06 %"]),
        ("boom_resolver: bias", ["bias needs a number and a unit; allowed: rad, deg"]),
        ("boom_resolver: bias 0.5", ["'bias 0.5' is no fault", "bias NUMBER UNIT"]),
        ("boom_resolver: bias 0.5 MPa", ["allowed: rad, deg"]),
        ("supply_pressure: bias 0.5 m", ["allowed: Pa, MPa, bar, psi"]),
        ("supply_pressure: bias 1e999 Pa", ["bias inf; allowed: up to 1e+09 Pa"]),
        ("boom_resolver: bias nan rad", ["is no fault"]),
        ("boom_resolver: drop 120 %", ["drop 120 %; allowed: 0 .. 100 %"]),
        ("boom_resolver: drop 2 rad", ["drop 2 rad; allowed: 0 .. 100 %"]),
        ("boom_resolver: frozen from 3 s until 2 s", ["from 3 s until 2 s; allowed: a time from 0 s on"]),
        ("boom_resolver: frozen from -1 s", ["from -1 s", "from 0 s on"]),
    ],
)
def test_an_error_names_the_fault_and_what_is_allowed(text, parts):
    with pytest.raises(ValueError, match="'") as caught:
        parse_faults(text)
    for part in parts:
        assert part in str(caught.value)
    assert "\n" not in str(caught.value)
