"""Parameters of the simulator's and the commander's node, and the machine that the simulator's describe."""

from typing import Annotated, NamedTuple

from forest_description.derived.limits import pose_at
from forest_description.machine import Machine
from forest_description.types import Vec3
from forest_msgs_py.runtime.parameter_table import Parameter, ParameterError, tunable
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.sensors.sensor_suite import calibrated, sensor_suite
from forest_sim.simulation.disturbance import parse_disturbance
from forest_sim.simulation.load_schedule import GREATEST_LENGTH, GREATEST_MASS, LOG_LENGTH, parse_loads
from forest_sim.simulation.simulated_machine import SimulatedMachine


class SimulatorParameters(NamedTuple):
    """Of `simulator_node`; the machine's own numbers stand in its file."""

    initial_tip: Annotated[Vec3, Parameter("tip position at the start", "m")]
    plain_arrays: Annotated[bool, Parameter("publish Float64MultiArray without stamp")] = False
    oil_warms: Annotated[bool, Parameter("false: the oil stays as warm as the machine file says")] = True
    rig: Annotated[bool, Parameter("a test rig: the second flow meter behind the swing's hose 1")] = False
    noise_run: Annotated[
        str, Parameter("name of the run: another name draws other noise of the same sensors")
    ] = ""
    sensor_noise: Annotated[bool, Parameter("errors, noise, lag and rate as in the machine file")] = False
    seed: Annotated[int, Parameter("seed of the sensors' errors and noise", low=0)] = 0
    sensor_static_errors: Annotated[bool, Parameter("with noise: sensors as before calibration")] = True
    sensor_faults: Annotated[
        str, Parameter("faults of sensors, such as boom_resolver: frozen from 2 s; swing_flow: absent")
    ] = ""
    stuck_spools: Annotated[str, tunable("axes whose spools do not move")] = ""
    tip_force: Annotated[tuple[float, ...], tunable("constant force on the tip, in the base frame", "N")] = (
        0.0,
        0.0,
        0.0,
    )
    loads: Annotated[str, Parameter("logs in the head, such as 500 kg from 2 s; 0 kg from 6 s")] = ""
    log_mass: Annotated[float, tunable("mass of the log that ~/grasp takes", "kg", 1.0, GREATEST_MASS)] = (
        500.0
    )
    log_length: Annotated[
        float, tunable("length of the log that ~/grasp takes", "m", 0.0, GREATEST_LENGTH)
    ] = LOG_LENGTH


class CommanderParameters(NamedTuple):
    """Of `commander_node`."""

    input: Annotated[
        str, Parameter("CSV with columns time [s], swing, boom, stick [V of the ideal valve]")
    ] = ""


def simulated_machine(machine: Machine, p: SimulatorParameters, period: float) -> SimulatedMachine:
    """Return a machine at rest, with sensors and disturbance as the parameters say.

    Args:
        machine: what is simulated.
        p: the parameters.
        period: sampling period [s].

    Raises:
        ParameterError: a parameter does not fit the machine, or names what is not there.
    """
    try:
        angles = pose_at(p.initial_tip, machine)
    except ValueError as error:
        raise ParameterError(f"parameter 'initial_tip' is {list(p.initial_tip)}: {error}") from error
    try:
        suite = sensor_suite(machine, p.sensor_noise, p.seed, parse_faults(p.sensor_faults))
    except ValueError as error:
        raise ParameterError(f"parameter 'sensor_faults': {error}") from error
    suite = suite if p.sensor_static_errors else calibrated(suite)
    try:
        loads = parse_loads(p.loads)
    except ValueError as error:
        raise ParameterError(f"parameter 'loads': {error}") from error
    made = SimulatedMachine(machine, angles, suite, period, p.oil_warms, p.rig, p.noise_run, loads)
    try:
        made.disturb(parse_disturbance(p.stuck_spools, p.tip_force))
    except ValueError as error:
        raise ParameterError(f"parameter {error}") from error
    return made
