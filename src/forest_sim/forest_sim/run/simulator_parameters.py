"""Parameters of the simulator's and the commander's node."""

from typing import Annotated, NamedTuple

from forest_description.types import Vec3
from forest_msgs_py.runtime.parameter_table import Parameter, tunable


class SimulatorParameters(NamedTuple):
    """Of `simulator_node`; the machine's own numbers stand in its file."""

    initial_tip: Annotated[Vec3, Parameter("tip position at the start", "m")]
    plain_arrays: Annotated[bool, Parameter("publish Float64MultiArray without stamp")] = False
    oil_warms: Annotated[bool, Parameter("false: the oil stays as warm as the machine file says")] = True
    rig: Annotated[bool, Parameter("a test rig: the second flow meter behind the swing's hose 1")] = False
    noise_run: Annotated[str, Parameter("another name: other noise of the same sensors")] = ""
    sensor_noise: Annotated[bool, Parameter("errors, noise, lag and rate as in the machine file")] = False
    seed: Annotated[int, Parameter("of the sensors' errors and noise", low=0)] = 0
    sensor_static_errors: Annotated[bool, Parameter("with noise: units as before calibration")] = True
    sensor_faults: Annotated[str, Parameter("e.g. boom_resolver: frozen from 2 s; swing_flow: absent")] = ""
    stuck_spools: Annotated[str, tunable("axes whose spools do not move")] = ""
    tip_force: Annotated[tuple[float, ...], tunable("on the tip, base frame", "N")] = (0.0, 0.0, 0.0)


class CommanderParameters(NamedTuple):
    """Of `commander_node`."""

    input: Annotated[
        str, Parameter("CSV with columns time [s], swing, boom, stick [V of the ideal valve]")
    ] = ""
