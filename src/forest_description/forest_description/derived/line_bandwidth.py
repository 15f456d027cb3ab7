"""Up to which frequency one lump stands for a hose: where the wave through it is still long.

Symbols:
    f       frequency [Hz]
    C_0     speed of sound in the oil alone, sqrt(β/ρ) [m/s]
    l       length of the hose [m]
    I, C    its inertance [Pa·s²/m³] and capacitance [m³/Pa]; the wave in it travels at l/sqrt(I C)

A soft wall, or an inertance measured with its fittings, makes the wave slower than C_0.

docs/explanation/equations.md ("One lump") has the shipped machine's oscillations beside the limits of its
hoses.
"""

import math

from forest_description.machine import Machine
from forest_description.types import AXES


def lump_frequency(wave_speed: float, length: float) -> float:
    """Return the frequency [Hz] that oscillations must stay below, C_0/(2π l). Thesis eq. 3.3.

    Args:
        wave_speed: [m/s].
        length: l [m].
    """
    return wave_speed / (2.0 * math.pi * length)


def lump_limit(machine: Machine, axis: int, port: int) -> float:
    """Return the frequency [Hz] below which one lump stands for a hose of a machine. Thesis eq. 3.3.

    The lower of two: from the hose's own I and C, 1/(2π sqrt(I C)), where the length has gone; and
    from the oil's C_0 where the machine has oil. Differs: the thesis takes C_0 alone, which leaves
    the wall out, and has 51 Hz for the 4 m that its own I and C limit to 23 Hz.

    Args:
        machine: At the temperature of interest.
        axis: 0 swing, 1 boom, 2 stick.
        port: 1 or 2.
    """
    line = machine.line(axis, port)
    own = 1.0 / (2.0 * math.pi * math.sqrt(line.inertance * line.capacitance))
    if machine.oil is None:
        return own
    return min(own, lump_frequency(machine.oil.sound_speed, machine.line_length(axis, port)))


def one_lump_warnings(machine: Machine, highest_frequency: float) -> list[str]:
    """Return a sentence for each hose that is too long for one lump. Thesis eq. 3.3.

    Args:
        machine: At the temperature of interest.
        highest_frequency: Of what the simulation shall show [Hz].
    """
    warnings = []
    for axis, name in enumerate(AXES):
        for port in (1, 2):
            limit = lump_limit(machine, axis, port)
            if highest_frequency < limit:
                continue
            length = machine.line_length(axis, port)
            warnings.append(
                f"{name}: one lump stands for hose {port} ({length:g} m) below {limit:.3g} Hz "
                f"(Thesis eq. 3.3), not up to {highest_frequency:.3g} Hz: do not trust what the simulation "
                f"shows above that; shorten {name}.line_{port}_length, take a stiffer hose, or command slower"
            )
    return warnings
