"""What the refinement of an experiment estimates: which parameters, and by which channels.

Names of unknowns that are no parameters of the machine:

| name | what |
|---|---|
| rig.load | R_L of the bench's load |
| swing.angle, boom.angle, stick.angle | static errors of the resolvers, true minus read |
| oil.offset | static error of the thermocouples' mean |
| tilt | error of the inclinometer on the tilted platform |
| start.CHANNEL.RECORD | pressure, angle at the start of a crane's record, true minus read |
| boom.inertia, stick.inertia | factor on a link's moments of inertia |
"""

from typing import NamedTuple

from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.experiments import experiment_plan
from forest_ident.measurements.parameter_path import hose_section, part_of, valve_at, valve_section
from forest_ident.measurements.session import Session
from forest_ident.refinement import extension_keys

START = "start."
OF_DERIVATIVES, STEPS = 1.1, 8.0  # times that derivatives are taken; steps of a search: as they were counted
VALVE = ("deadband_voltage", "minimum_resistance")
LEAKAGE = ("swing.internal_leakage_resistance", "swing.external_leakage_resistance")
OFFSETS = ("boom.angle", "stick.angle", "oil.offset")
INERTIAS = ("boom.inertia", "stick.inertia")
NUISANCES = ("swing.angle", *OFFSETS, "tilt", *INERTIAS)
MASSES = ("manipulator.head_mass", "manipulator.boom_mass")
_LINKS = tuple(
    f"manipulator.{name}"
    for name in ("stick_mass", "stick_x", "stick_y", "boom_x", "boom_y", "boom_length", "stick_length")
)
_DRIVE = ("head_area", "rod_area", "pivot_to_base", "pivot_to_rod", "angle_offset")
TOLD = {
    "swing": (*_LINKS, "manipulator.base_offset", "swing.motor_displacement"),
    **{axis: (*_LINKS, *(f"{axis}.{name}" for name in _DRIVE)) for axis in AXES[1:]},
}
"""Numbers of an axis that a person tells, and that its motion feels."""
BOTH = tuple(dict.fromkeys((*TOLD["boom"], *TOLD["stick"])))
VALVE_PORTS = ("swing_pressure_1_valve", "swing_pressure_2_valve")
FLOWS = ("swing_flow", "stick_flow", "supply_pressure")
VALVE_RIG = (*VALVE_PORTS, *FLOWS, "swing_spool")
HOSE_RIG = (*VALVE_PORTS, "swing_pressure_1_actuator", *FLOWS)


def is_parameter(name: str) -> bool:
    """Tell whether an unknown is a number of the machine."""
    return name not in NUISANCES and not name.startswith((START, "rig.load"))


def stated_keys(machine: Machine, session: Session) -> tuple[str, ...]:
    """Return the stated numbers that a record of the crane feels."""
    if not session.on_crane:
        return ()
    axis = AXES[_axis(machine, session)]
    return (*(BOTH if session.name == "gravity" else TOLD[axis]), *INERTIAS)


def tells_stated(machine: Machine) -> bool:
    """Tell whether stated numbers are unknowns of the crane's records: no axis sticks.

    A plant that sticks lets go in whole steps of the simulator, and has no derivatives as fine as they need.
    """
    return all(drive.friction is None for drive in machine.drives)


class Task(NamedTuple):
    """One refinement."""

    free: tuple[str, ...]  # keys to be estimated here; their prior counts if there is one
    carried: tuple[str, ...]  # keys estimated before, with their prior; left out if there is none
    channels: tuple[str, ...]
    nuisances: tuple[str, ...] = OFFSETS


def task(machine: Machine, session: Session) -> Task | None:
    """Return what a session's refinement estimates; None for a session that is only checked."""
    tasks = _tasks(machine, session)
    found = tasks.get(session.name, tasks.get(session.kind))
    if found is None:
        return None
    axis = _axis(machine, session)
    name = AXES[axis]
    valve = valve_section(machine, axis)
    free = (*found.free, *extension_keys.told_by(machine, session.kind, name, valve))
    felt = extension_keys.felt_by(machine, session.kind, () if session.on_rig else (name,), valve)
    carried = (*found.carried, *(key for key in felt if key not in free))
    return _of_machine(machine, found._replace(free=free, carried=carried))


def _tasks(machine: Machine, session: Session) -> dict[str, Task]:
    """Return the refinements of an axis, by the name or the kind of their session."""
    axis = _axis(machine, session)
    name, valve = AXES[axis], valve_section(machine, axis)
    pump = tuple(f"pump.{key}" for key in machine.pump.identifiable)
    ways = [tuple(f"{part}.{key}" for key in VALVE) for part in (valve, f"{valve}.backward")]
    spool = _spool_keys(machine, valve)
    law = (*ways[0], *ways[1], f"{valve}.port_2_area", *spool)
    line = _line_keys(machine, session, axis)
    leakage = LEAKAGE if axis == 0 else ()
    ports = (f"{name}_pressure_1_actuator", f"{name}_pressure_2_actuator")
    axis_channels = (f"{name}_resolver", f"{name}_transducer", *ports, f"{name}_flow")
    supplied, drained = (*axis_channels, "supply_pressure"), (*axis_channels, "case_drain")
    own, back = f"{name}.valve", f"{name}.valve.backward"
    beside = () if axis == 0 else (AXES[3 - axis],)  # boom and stick shake each other
    return {
        # Between valve and load lies a short piece of hose, which has not been measured yet.
        "valve": Task((*law, *pump), line, VALVE_RIG, ("rig.load",)),
        "compensator": Task((), (*law, *pump, *line), VALVE_RIG, ("rig.load",)),
        "spool": Task(spool, (), ("swing_spool",), ()),
        "hose": Task(line, (*law, *pump), HOSE_RIG, ("rig.load",)),
        "gravity": _gravity(machine, pump),
        "motor_external": Task(
            free=LEAKAGE[1:],
            carried=("swing.damping", LEAKAGE[0], *law, *line, *pump, *MASSES),
            channels=(*supplied, "case_drain"),
        ),
        "motor_internal": Task(
            free=LEAKAGE,
            carried=("swing.damping", *line, *MASSES),
            channels=drained,
            nuisances=(*OFFSETS, "tilt", "swing.angle"),
        ),
        "deadband": Task(
            free=(f"{own}.deadband_voltage", f"{back}.deadband_voltage"),
            carried=(
                *(f"{own}.minimum_resistance", f"{back}.minimum_resistance", f"{own}.port_2_area"),
                *(f"{name}.damping", *leakage, *pump, *MASSES),
            ),
            channels=supplied,
        ),
        "damping": Task(
            free=(f"{name}.damping",),
            carried=(*(f"{one}.damping" for one in beside), *law, *line, *leakage, *pump, *MASSES),
            channels=supplied,
        ),
    }


def _line_keys(machine: Machine, session: Session, axis: int) -> tuple[str, ...]:
    """Return the keys of an axis' hose: its resistance is that of the flow regime of the record."""
    laminar = session.metadata.get("laminar", 0.0) > 0.0
    regime = machine.drives[axis].flow_regime if session.on_crane else "laminar" if laminar else "turbulent"
    hose = hose_section(machine, axis)
    return tuple(f"{hose}.{part}" for part in (f"{regime}_resistance", "inertance", "capacitance"))


def simulations(machine: Machine, session: Session) -> float:
    """Return how many simulations the refinement of a session takes, about."""
    work = task(machine, session)
    if work is None:
        return 0.0
    starts = len(work.channels) if session.on_crane else 0  # pressures at the start are unknown, too
    derivatives = len(work.free) + len(work.carried) + len(work.nuisances) + starts
    return OF_DERIVATIVES * derivatives + len(stated_keys(machine, session)) + STEPS


def _gravity(machine: Machine, pump: tuple[str, ...]) -> Task:
    """Return the refinement of motion and rests of boom and stick: the masses."""
    carried, channels = [*pump], ["supply_pressure"]
    for axis, name in enumerate(AXES[1:], start=1):
        section, hose = valve_section(machine, axis), hose_section(machine, axis)
        regime = machine.drives[axis].flow_regime
        carried += [f"{way}.{key}" for way in (section, f"{section}.backward") for key in VALVE]
        carried += [f"{section}.port_2_area", *_spool_keys(machine, section), f"{name}.damping"]
        carried += [f"{hose}.{part}" for part in (f"{regime}_resistance", "inertance", "capacitance")]
        channels += [f"{name}_resolver", f"{name}_transducer"]
        channels += [f"{name}_pressure_{port}_actuator" for port in (1, 2)]
    return Task(MASSES, tuple(dict.fromkeys(carried)), tuple(channels))


def _of_machine(machine: Machine, found: Task) -> Task:
    """Return a task without the masses that the machine does not have."""

    def there(key: str) -> bool:
        value = part_of(machine, key)
        return isinstance(value, float) and value > 0.0

    free, carried = (
        tuple(key for key in keys if key not in MASSES or there(key)) for keys in (found.free, found.carried)
    )
    return found._replace(free=free, carried=carried)


def _axis(machine: Machine, session: Session) -> int:
    """Return the axis that a session is about: of the crane, or whose parts are on the rig."""
    if session.kind == "hose":
        return int(session.metadata["hose_axis"])
    if session.own_axis:
        return AXES.index(session.own_axis)
    return experiment_plan.shared_valve_axis(machine) if session.name in ("valve", "compensator") else 0


def _spool_keys(machine: Machine, section: str) -> tuple[str, ...]:
    valve = valve_at(machine, section)
    names = [name for name in ("spool_bandwidth", "spool_damping") if getattr(valve, name) is not None]
    return tuple(f"{section}.{name}" for name in names)
