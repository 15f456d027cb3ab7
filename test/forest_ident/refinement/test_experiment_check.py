"""A record under another experiment's name is refused by name."""

import dataclasses

import numpy as np
import pytest

from forest_description.geometry.linkage import cylinder_length
from forest_description.machine import load_machine
from forest_ident.measurements.session import Session, SessionError
from forest_ident.refinement import experiment_check
from forest_ident.refinement.experiment_check import AGAINST, demand, demand_machine
from forest_ident.refinement.identification import identify

C180 = load_machine("c180_hoses")


def record(name, driven, roll=None):
    """Return a record that drives some axes, with the platform's roll."""
    volts = np.zeros((100, 3))
    volts[20:80, list(driven)] = 4.0
    readings = {} if roll is None else {"platform_roll": np.full(100, roll)}
    return Session(name, 0.005 * np.arange(100), volts, readings)


@pytest.mark.parametrize(
    ("name", "driven", "roll", "sentence"),
    [
        ("motor_internal", (0,), None, "motor_internal: the record drives swing; allowed: none: all valves"),
        ("motor_external", (), None, "drives no axis; allowed: the swing: is it motor_internal's"),
        (
            "damping_boom",
            (2,),
            None,
            "damping_boom: the record drives stick; allowed: only boom: is it another",
        ),
        ("gravity", (0, 1), None, "gravity: the record drives swing; allowed: only boom and stick"),
        ("motor_internal", (), 0.0, "motor_internal: the platform rolls 0.000 rad; allowed: a tilted one"),
        ("motor_external", (0,), 0.15, "motor_external: the platform rolls 0.150 rad; allowed: a level one"),
    ],
)
def test_a_record_of_another_experiment_is_named(name, driven, roll, sentence):
    with pytest.raises(SessionError, match=sentence):
        demand(C180, record(name, driven, roll))


@pytest.mark.parametrize(
    ("name", "driven", "roll"),
    [
        ("motor_internal", (), 0.15),
        ("motor_external", (0,), 0.0),
        ("gravity", (1, 2), None),
        ("damping_boom", (1,), None),
        ("validation", (0, 1, 2), None),
        ("valve", (0,), None),
    ],
)
def test_a_record_of_its_experiment_passes(name, driven, roll):
    demand(C180, record(name, driven, roll))
    demand(C180, dataclasses.replace(record(name, driven), readings={}))


def of_a_crane(lengthened=0.0, turned=0.0):
    """Return a held-out record of the boom from -0.3 to 0.9 rad, with its cylinder's length."""
    angles = np.linspace(-0.3, 0.9, 100)
    length = [cylinder_length(angle, C180.boom.linkage) + lengthened for angle in angles]
    readings = {"boom_resolver": angles + turned, "boom_transducer": np.array(length)}
    return Session("validation", 0.005 * np.arange(100), np.zeros((100, 3)), readings)


@pytest.mark.parametrize(
    ("odd", "sentence"),
    [
        ({"lengthened": 0.15}, "the boom's cylinder is 0.15 m longer or shorter than c180_hoses's"),
        (
            {"turned": 0.5},
            r"boom goes from 0.20 to 1.40 rad; allowed on c180_hoses: -0.64 \.\. 1.26: is it an",
        ),
    ],
)
def test_another_machines_record_is_refused(odd, sentence):
    demand_machine(C180, of_a_crane(lengthened=0.03))  # a tape's errors
    with pytest.raises(SessionError, match=sentence):
        demand_machine(C180, of_a_crane(**odd))


@pytest.mark.parametrize(("name", "laminar"), [("hose", 1.0), ("hose_laminar", 0.0)])
def test_a_hoses_record_with_the_other_hoses_facts_is_refused(name, laminar):
    facts = {"laminar": laminar, "hose_axis": 0.0}
    demand(C180, dataclasses.replace(record(name, (0,)), metadata={**facts, "laminar": 1.0 - laminar}))
    with pytest.raises(
        SessionError, match=f"{name}: its experiment.yaml says laminar {laminar:g}; allowed: "
    ):
        demand(C180, dataclasses.replace(record(name, (0,)), metadata=facts))


@pytest.mark.parametrize(("name", "pressure"), [("damping_boom", 2.2e6), ("valve", 2.2e6), ("gravity", 45e6)])
def test_a_record_whose_supply_rests_where_this_pump_does_not_is_refused(name, pressure):
    read = np.full(100, C180.pump.idle_pressure)
    one = dataclasses.replace(record(name, (1,)), readings={"supply_pressure": 0.6 * read})
    demand_machine(C180, one)  # a pump that a person set otherwise
    strange = dataclasses.replace(one, readings={"supply_pressure": np.full(100, pressure)})
    said = (
        rf"{name}: the supply stands at {1e-6 * pressure:.3g} MPa before a valve opens; allowed on c180_hoses"
        rf": {1e-6 * read[0] / 2.0:.3g} \.\. {1e-6 * read[0] * 2.0:.3g} MPa"
    )
    with pytest.raises(SessionError, match=said):
        demand_machine(C180, strange)
    moving = np.full((100, 3), 4.0)  # with a valve open from the first row, the supply tells nothing
    demand_machine(C180, dataclasses.replace(strange, voltages=moving))


def test_a_crane_whose_boom_and_stick_have_no_resolvers_is_refused():
    sensors = dataclasses.replace(C180.sensors, joint_angles="linear_transducer")
    crane = dataclasses.replace(C180, sensors=sensors)
    with pytest.raises(
        SessionError, match="angles of boom and stick by its linear_transducer; allowed: a crane"
    ):
        demand_machine(crane, record("gravity", (1, 2)))
    demand_machine(crane, record("hose_laminar", ()))  # a rig has its own sensors


@pytest.mark.parametrize(
    "machine", [load_machine("c180_hoses"), load_machine("loader")], ids=lambda m: m.name
)
def test_a_cylinder_off_by_more_than_a_tenth_of_its_stroke_is_anothers(machine):
    drive = machine.boom
    angle = 0.5 * sum(drive.angles)
    for share, refused in ((0.095, False), (-0.095, False), (0.105, True), (-0.105, True)):
        read = np.full(500, cylinder_length(angle, drive.linkage) + share * drive.stroke)
        readings = {"boom_resolver": np.full(500, angle), "boom_transducer": read}
        session = Session("motion", np.arange(500) * 0.005, np.zeros((500, 3)), readings)
        if refused:
            with pytest.raises(SessionError, match="is it another machine's record"):
                experiment_check._demand_lengths(machine, session, "boom")
        else:
            experiment_check._demand_lengths(machine, session, "boom")


def of_a_valves_rig(against="", **others):
    """Return a record of the valve's rig, 4 V to and fro; some channels are against the voltage."""
    volts = np.zeros((100, 3))
    volts[20:50, 0], volts[60:90, 0] = 4.0, -4.0
    along = np.sign(volts[:, 0])
    readings = {
        "swing_flow": 1e-3 * along,
        "swing_spool": 4.0 * along,
        "swing_pressure_1_valve": 5e6 + 1e6 * along,
        "swing_pressure_2_valve": 5e6 - 1e6 * along,
        **others,
    }
    if against:
        readings[against] = 2.0 * readings[against][0] - readings[against]
    return Session("valve", 0.005 * np.arange(100), volts, readings)


@pytest.mark.parametrize(
    ("channel", "sentence"),
    [
        ("swing_flow", "valve: swing_flow is -0.001 in the mean of positive voltages; allowed: their sign"),
        (
            "swing_spool",
            r"swing_spool is -4 in the mean .*: is the voltage reversed, or is the spool's sensor\?",
        ),
    ],
)
def test_a_rigs_reading_against_the_voltage_is_named(channel, sentence):
    demand(C180, of_a_valves_rig())
    with pytest.raises(SessionError, match=sentence):
        demand(C180, of_a_valves_rig(channel))


def test_a_meter_without_a_sign_is_named():
    flow = of_a_valves_rig().readings["swing_flow"]
    with pytest.raises(SessionError, match=r"swing_flow is 0\.001 in the mean of negative voltages"):
        demand(C180, of_a_valves_rig(swing_flow=np.abs(flow)))


def test_exchanged_ports_are_named_and_a_drop_that_transducers_err_is_not():
    along = np.sign(of_a_valves_rig().voltages[:, 0])
    gauge = C180.sensors.pressure
    few = AGAINST * C180.pump.idle_pressure + 2.0 * gauge.accuracy * gauge.full_scale
    demand(
        C180,
        of_a_valves_rig(swing_pressure_1_valve=0.4 * few * -along, swing_pressure_2_valve=0.4 * few * along),
    )
    with pytest.raises(
        SessionError, match=r"swing_pressure_1_valve less swing_pressure_2_valve is .*are the ports"
    ):
        demand(
            C180,
            of_a_valves_rig(
                swing_pressure_1_valve=0.6 * few * -along, swing_pressure_2_valve=0.6 * few * along
            ),
        )


def test_a_rigs_oil_that_is_not_cooled_is_named():
    told = C180.oil.reference_temperature
    demand(C180, of_a_valves_rig(tank_temperature=np.full(100, told + 1.9)))
    with pytest.raises(SessionError, match=r"the rig's oil is at 315\.\d K; allowed: 313\.\d K within 2 K"):
        demand(C180, of_a_valves_rig(tank_temperature=np.full(100, told + 2.1)))


def test_a_thermocouple_in_degrees_celsius_is_named():
    demand(C180, of_a_valves_rig(pump_temperature=np.full(100, 313.15)))
    with pytest.raises(
        SessionError, match=r"pump_temperature reads 40 \.\. 40 K; .* is it in degrees Celsius"
    ):
        demand(C180, of_a_valves_rig(pump_temperature=np.full(100, 40.0)))


def test_an_identification_begins_with_these_checks():
    with pytest.raises(SessionError, match="damping_boom: the record drives stick; allowed: only boom"):
        identify(C180, [record("damping_boom", (2,))], refine=False)
    with pytest.raises(SessionError, match=r"boom goes from 0.20 to 1.40 rad; allowed on c180_hoses"):
        identify(C180, [of_a_crane(turned=0.5)], refine=False)
    assert identify(C180, [of_a_crane()], refine=False).held_out[0].name == "validation"
