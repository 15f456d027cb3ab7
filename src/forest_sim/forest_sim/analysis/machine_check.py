"""What a machine file amounts to: the components it chooses, and figures that tell whether they fit."""

import dataclasses
import itertools
import math
from collections.abc import Iterator

import numpy as np

from forest_description.config.parameter import choice_of, fields_of, parameter_of
from forest_description.derived.actuator_kinematics import displacements, metering_drop, rated_speeds
from forest_description.derived.limits import joint_limits, workspace_limits
from forest_description.derived.line_bandwidth import one_lump_warnings
from forest_description.derived.tip_over import Margins, tip_over_margins
from forest_description.geometry.linkage import lever_arm
from forest_description.hydraulics.load_holding_parameters import CounterbalanceValve, RuptureValve
from forest_description.machine import Machine
from forest_description.mechanics.drives import CylinderDrive, SwingDrive
from forest_description.types import AXES, Vec3
from forest_sim.analysis.friction_linearisation import (
    axes_with_friction,
    is_rough,
    large_heading,
    small_heading,
    with_pressed_seals,
    without_dry_friction,
)
from forest_sim.analysis.modes import SHUT, Mode, modes, operating_point, slow_modes, unguarded
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.simulation.open_loop import start_angles
from forest_sim.solver.equilibrium import equilibrium

MPA = 1e6
LITRES = 1e-3 / 60.0  # [m^3/s] of a litre a minute
GRID = 8  # poses of boom and of stick, less one
SLOWEST = 0.5  # [s] of a spool's stroke to full open, several times a large pilot stage's
CHARTED = 1.2  # of the pump's pressure: where a boom's stroke ends a chart for all heights may need 1.1


def components(machine: Machine) -> Iterator[tuple[str, str]]:
    """Yield every component that a machine could choose otherwise, and what it has: kind, word, or none."""
    for key, field, value in fields_of(machine):
        parameter, optional = parameter_of(field), "None" in str(field.type)
        if key.startswith("sensors.") and key.count(".") > 1:  # what a sensor is like is a table of its own
            continue
        if value is None:
            yield key, "none"
        elif choice_of(field) is not None:
            yield key, str(value)
        elif parameter is not None and optional:
            yield key, f"{value:g} {parameter.unit}"
        elif dataclasses.is_dataclass(value) and (optional or hasattr(value, "kind")):
            yield key, str(getattr(value, "kind", "yes"))


def full_speeds(machine: Machine, angles: Vec3) -> dict[str, tuple[float, float]]:
    """Return the steady joint speeds [rad/s] at a pose, each axis alone at full voltage to both sides."""
    p = unguarded(plant_parameters(machine))
    speeds = {}
    for place, axis in enumerate(AXES):
        rated = machine.valve_of(place).rated_voltage
        both = []
        for sign in (1.0, -1.0):
            spools = tuple(sign * rated if i == place else 0.0 for i in range(len(AXES)))
            point = operating_point(angles, (spools[0], spools[1], spools[2]), p)
            both.append(point.plant.axes[place].rate)
        speeds[axis] = (both[0], both[1])
    return speeds


def warnings(machine: Machine) -> list[str]:
    """Return what is allowed but not wise; each a sentence."""
    return [
        *_load_warnings(machine),
        *_chart_warnings(machine),
        *_setting_warnings(machine),
        *_rupture_warnings(machine),
        *_play_warnings(machine),
        *_stroke_warnings(machine),
        *_sensor_warnings(machine),
        *_inertia_warnings(machine),
        *_tip_over_warnings(machine),
        *_hose_warnings(machine),
    ]


def _load_warnings(machine: Machine) -> Iterator[str]:
    """Give a sentence for each pressure of the resting crane that something does not hold."""
    p = plant_parameters(machine)
    for place, name in ((1, "boom"), (2, "stick")):
        poses, drive = list(_holding_pressures(machine, place)), machine.drives[place]
        for port, valve in enumerate((drive.holding_1, drive.holding_2)):
            highest, boom, stick = max((pose[port], *pose[2:]) for pose in poses)
            limits = [(p.supply.set_pressure, "the pump's"), (p.guard.relief_pressure, "the relief valve's")]
            if isinstance(valve, CounterbalanceValve):
                reseats = valve.setting - valve.hysteresis
                limits.append((reseats, "its counterbalance valve's reseating pressure of"))
            where = (
                f"with the boom at {math.degrees(boom):.0f} and the stick at {math.degrees(stick):.0f} deg"
            )
            for limit, whose in limits:
                if highest > limit:
                    yield (
                        f"{name}: holding the crane still takes {highest / MPA:.1f} MPa {where}, "
                        f"more than {whose} {limit / MPA:.1f} MPa"
                    )


def _chart_warnings(machine: Machine) -> Iterator[str]:
    """Give a sentence if the boom's cylinder is far from holding what the load chart allows."""
    m, chart, supply = machine.manipulator, machine.capacity, machine.pump.supply_pressure
    if chart is None:
        return
    taken, drive = [], machine.boom
    for head, rod, boom, stick in _holding_pressures(machine, 1):
        ahead = m.boom_length * math.cos(boom) + m.stick_length * math.cos(boom + stick)
        load = float(np.interp(m.base_offset + ahead, chart.reach, chart.load))
        lifts = load * m.gravity * ahead / lever_arm(boom, drive.linkage)
        force = head * drive.head_area - rod * drive.rod_area + lifts
        needed = max(force / drive.head_area, -force / drive.rod_area)
        taken.append((needed, m.base_offset + ahead, load))
    highest, reach, load = max(taken)
    if highest > CHARTED * supply:
        yield (
            f"capacity: at {reach:.1f} m it allows {load:.0f} kg, for which the boom's cylinder takes "
            f"{highest / MPA:.1f} MPa, more than the pump's {supply / MPA:.1f} MPa"
        )


def _rupture_warnings(machine: Machine) -> Iterator[str]:
    """Give a sentence for each hose-rupture valve that usual motion shuts."""
    for place, axis in enumerate(AXES):
        drive, speed = machine.drives[place], rated_speeds(machine)[place]
        for port, valve in enumerate((drive.holding_1, drive.holding_2)):
            leaves = displacements(machine, place)[port] * speed
            if isinstance(valve, RuptureValve) and valve.closing_flow < leaves:
                yield (
                    f"{axis}.holding_{port + 1}: more than {valve.closing_flow / LITRES:.4g} L/min shut it, "
                    f"and at full speed {leaves / LITRES:.0f} L/min leave the {axis}, though no hose bursts"
                )


def _setting_warnings(machine: Machine) -> Iterator[str]:
    """Give a sentence for each counterbalance valve that protects its actuator less than the port relief."""
    if machine.port_valves is None:
        return
    relief = machine.port_valves.relief_pressure
    for place, axis in enumerate(AXES):
        drive = machine.drives[place]
        for port, valve in (("holding_1", drive.holding_1), ("holding_2", drive.holding_2)):
            if isinstance(valve, CounterbalanceValve) and valve.setting > relief:
                yield (
                    f"{axis}.{port}: the oil that it shuts in may come to its setting, "
                    f"{valve.setting / MPA:.1f} MPa, above the port relief valve's {relief / MPA:.1f} MPa"
                )


def _play_warnings(machine: Machine) -> list[str]:
    """Return a sentence for each valve that its play may keep open at zero voltage."""
    found = []
    for place, axis in enumerate(AXES):
        valve = machine.valve_of(place)
        off = 0.5 * (valve.hysteresis or 0.0)
        overlap = min(valve.law.forward.deadband_voltage, valve.law.backward.deadband_voltage)
        if off > 0.0 and off >= overlap:
            found.append(
                f"{axis}: at zero voltage its spool may rest {off:g} V off the centre, and its overlap ends "
                f"at {overlap:g} V: the {axis} creeps"
            )
    return found


def _stroke_warnings(machine: Machine) -> Iterator[str]:
    """Give a sentence for each spool that its slew limit makes slower than any crane's."""
    for place, axis in enumerate(AXES):
        valve = machine.valve_of(place)
        stroke = valve.rated_voltage / (valve.spool_slew_limit or math.inf)
        if stroke > SLOWEST:
            yield (
                f"{axis}: its spool takes {stroke:.3g} s from the centre to full open by its "
                f"spool_slew_limit of {valve.spool_slew_limit:g} V/s, as long to shut; usual: 20 to 100 ms"
            )


def _sensor_warnings(machine: Machine) -> list[str]:
    """Return a sentence for each sensor whose reading ends too early, or that chart or control lacks."""
    sensors, found = machine.sensors, list(_angle_warnings(machine))
    if sensors.resolver is not None:
        half = math.degrees(0.5 * sensors.resolver.full_scale)
        resolvers = AXES if sensors.by_resolvers else AXES[:1]
        for axis, limits in zip(resolvers, joint_limits(machine), strict=False):
            low, high = (math.degrees(limit) for limit in limits)
            if low < -half or high > half:
                found.append(
                    f"{axis}: its resolver shows -{half:.0f} .. {half:.0f} deg, the joint goes from "
                    f"{low:.1f} to {high:.1f} deg: beyond, the reading stands still"
                )
    if sensors.linear_transducer is not None:
        shown = sensors.linear_transducer.full_scale
        found += [
            f"{axis}: its linear transducer shows {shown:g} m of a stroke of {drive.stroke:g} m"
            for axis, drive in (("boom", machine.boom), ("stick", machine.stick))
            if shown < drive.stroke
        ]
    if sensors.pressure is not None and sensors.pressure.full_scale < machine.pump.supply_pressure:
        found.append(
            f"the pressure transducers end at {sensors.pressure.full_scale / MPA:.1f} MPa, below the pump's "
            f"{machine.pump.supply_pressure / MPA:.1f} MPa"
        )
    if sensors.pressure is None and machine.capacity is not None:
        found.append(
            "capacity without sensors.pressure: no load is weighed, so the controller allows only motions "
            "that unload"
        )
    if sensors.pressure is None:
        found += [
            f"{axis}: behind a compensator and a counterbalance valve it rocks undamped without "
            "sensors.pressure: the valve driver damps by the load that it feels"
            for place, axis in enumerate(AXES)
            if metering_drop(machine, place) < math.inf and _is_counterbalanced(machine.drives[place])
        ]
    return found


def _angle_warnings(machine: Machine) -> Iterator[str]:
    """Give a sentence for each angle without a sensor, and each inertial unit beyond its link or unused."""
    sensors, unit, links = machine.sensors, machine.sensors.inertial_unit, machine.manipulator.links
    if sensors.joint_angles is not None and sensors.resolver is None:
        yield "swing: nothing tells its angle; sensors.resolver does, whatever makes those of boom and stick"
    if unit is None:
        return
    if sensors.joint_angles != "inertial_unit":
        yield "sensors.inertial_unit: nothing reads it; sensors.joint_angles: inertial_unit does"
    for link, distance, length in (
        ("boom", unit.boom_distance, links.boom),
        ("stick", unit.stick_distance, links.stick),
    ):
        if distance > length:
            yield f"{link}: its inertial unit is {distance:g} m along its {length:g} m"


def _is_counterbalanced(drive: CylinderDrive | SwingDrive) -> bool:
    return any(isinstance(valve, CounterbalanceValve) for valve in (drive.holding_1, drive.holding_2))


def _inertia_warnings(machine: Machine) -> list[str]:
    """Return a sentence for each link whose mass would have to reach beyond its two ends.

    Between joint and end, l apart, the integral of (x - x_c)^2 dm is at most m x_c (l - x_c).
    Moments about the joint, taken for those about the centre of mass, exceed that.
    """
    m, found = machine.manipulator, []
    for link, mass, x, length, (xx, yy, zz) in (
        ("boom", m.boom_mass, m.boom_x, m.boom_length, (m.boom_xx, m.boom_yy, m.boom_zz)),
        ("stick", m.stick_mass, m.stick_x, m.stick_length, (m.stick_xx, m.stick_yy, m.stick_zz)),
    ):
        along, most = 0.5 * (yy + zz - xx), mass * x * (length - x)
        if along > most > 0.0:
            found.append(
                f"{link}_yy, {link}_zz: about its centre of mass, {mass:g} kg within the {link}'s length "
                f"have at most {most:.4g} kg*m2 along it, not {along:.4g}: are they about the joint?"
            )
    return found


def _tip_over_warnings(machine: Machine) -> list[str]:
    """Return a sentence if the crane tips its vehicle over with nothing in its head."""
    if machine.chassis is None:
        return []
    limits = joint_limits(machine)
    worst, side, (swing, boom, stick) = min(
        (margin, side, pose)
        for pose in itertools.product(_spread(limits[0]), _spread(limits[1]), _spread(limits[2]))
        for side, margin in zip(
            Margins._fields, tip_over_margins(machine.chassis, machine.manipulator, pose, 0.0), strict=True
        )
    )
    if worst >= 0.0:
        return []
    told = (
        f"chassis: its {machine.chassis.mass:g} kg do not hold the empty crane: margin {worst:.2f} against "
        f"tipping over ({side}) with the swing at {math.degrees(swing):.0f}, the boom at "
        f"{math.degrees(boom):.0f} and the stick at {math.degrees(stick):.0f} deg"
    )
    return [told]


def _spread(limits: tuple[float, float]) -> list[float]:
    """Return angles [rad] over a joint's way, both ends among them."""
    return [limits[0] + (limits[1] - limits[0]) * k / GRID for k in range(GRID + 1)]


def _holding_pressures(machine: Machine, place: int) -> Iterator[tuple[float, float, float, float]]:
    """Give a resting cylinder's two pressures [Pa] over the joint limits, with boom and stick angle."""
    p, (_, boom, stick) = plant_parameters(machine), joint_limits(machine)
    for q_2, q_3 in itertools.product(_spread(boom), _spread(stick)):
        axis = equilibrium((0.0, q_2, q_3), p).plant.axes[place]
        yield axis.pressure_1, axis.pressure_2, q_2, q_3


def _hose_warnings(machine: Machine) -> list[str]:
    """Return a sentence for each hose that one lump does not describe up to the crane's fastest mode."""
    p = without_dry_friction(plant_parameters(machine))
    found = modes(start_angles(machine), SHUT, p)
    fastest = max((mode.frequency for mode in found if mode.kind == "links on oil"), default=0.0)
    return one_lump_warnings(machine, fastest)


def _oscillation(mode: Mode | None) -> str:
    """Return a mode in words."""
    return "no oscillation" if mode is None else f"{mode.frequency:.2f} Hz, damping ratio {mode.damping:.3f}"


def report(machine: Machine) -> str:
    """Return the machine in words and numbers."""
    angles = start_angles(machine)
    limits, w = joint_limits(machine), workspace_limits(machine)
    p = plant_parameters(machine)
    small = slow_modes(modes(angles, SHUT, p))
    large = slow_modes(modes(angles, SHUT, without_dry_friction(p)))
    p = with_pressed_seals(p, equilibrium(angles, p).plant)
    rubbing = axes_with_friction(p)
    speeds, rated = full_speeds(machine, angles), rated_speeds(machine)
    lines = [f"{machine.name}: {machine.description}", "components"]
    lines += [f"  {name:<24} {what}" for name, what in components(machine)]
    lines.append("joints")
    for place, axis in enumerate(AXES):
        low, high = (math.degrees(limit) for limit in limits[place])
        plus, minus = speeds[axis]
        oscillation = _oscillation(small[axis])
        if axis in rubbing or (axis == "swing" and p.drive.present):
            oscillation = f"{_oscillation(large[axis])} (small: {oscillation})"
        lines.append(
            f"  {axis:<6} {low:7.1f} .. {high:6.1f} deg, {plus:+.2f}/{minus:+.2f} rad/s, {oscillation}"
        )
    lines.append(
        f"  speeds at full voltage, oscillations with shut valves; boom at {math.degrees(angles[1]):.1f}, "
        f"stick at {math.degrees(angles[2]):.1f} deg"
    )
    if is_rough(p):
        lines += [f"  {small_heading(p)}", f"  {large_heading(p)}"]
    lines += [
        "workspace",
        f"  reach  {w.reach_min:.2f} .. {w.reach_max:.2f} m from the swing axis",
        f"  height {w.height_min:.2f} .. {w.height_max:.2f} m over the boom pivot",
        "actuators without load at full voltage",
        f"  swing {rated[0]:.2f} rad/s, boom {rated[1]:.2f} m/s, stick {rated[2]:.2f} m/s",
    ]
    told_warnings = warnings(machine)
    lines += ["warnings", *(f"  {text}" for text in told_warnings)] if told_warnings else ["no warnings"]
    return "\n".join(lines)
