"""Which residuals move when what is broken, what else looks the same, and what a person does.

A cause is named when one of its patterns is there: residuals of one axis, or of the machine, with the sign of
their change. It hides what follows from it: a stuck spool spoils the estimate of its own deadband. Causes
stand in that order. `alike` names what gives the same
pattern; the monitor says it, too.
"""

from typing import NamedTuple

Pattern = tuple[str, ...]  # "lost_1-": below what it was


class Cause(NamedTuple):
    """One cause, of an axis or of the machine."""

    name: str
    of_axis: bool
    patterns: tuple[Pattern, ...]  # one of them, all of whose residuals have moved
    hides: tuple[str, ...]  # causes of the same axis, or of the machine
    text: str  # {axis}: which
    alike: str  # what cannot be told from it
    advice: str


ESTIMATES = ("deadband", "motion")
CAUSES = (
    Cause(
        "spool",
        True,
        (("spool+",),),
        ("piston", "holding", "pressure", "stiffness", *ESTIMATES),
        "{axis}: the spool does not follow its voltage: it sticks, or is slow",
        "its position sensor, its amplifier",
        "stop using the axis; check plug, pilot pressure and filter, then clean the spool",
    ),
    Cause(
        "pressure",
        True,
        (("pair_1+",), ("pair_1-",), ("pair_2+",), ("pair_2-",)),
        ("piston", "holding", "stiffness", *ESTIMATES),
        "{axis}: two pressure transducers of one port differ at rest: one has a bias, or has failed",
        "which of the two",
        "compare both with a gauge at rest, and calibrate or replace one",
    ),
    Cause(
        "length",
        True,
        (("agree+",), ("agree-",)),
        ("piston", "holding", "stiffness", "deadband", "motion"),
        "{axis}: cylinder's length and joint's angle do not belong together: one of the sensors has a bias",
        "which of the two; a machine file with other pivots",
        "measure the angle by hand at two poses; calibrate the sensor, or correct the machine file",
    ),
    Cause(
        "piston",
        True,
        (("lost_1-", "lost_2+"), ("lost_1+", "lost_2-"), ("meter+",), ("meter-",)),
        ("holding", *ESTIMATES),
        "{axis}: oil passes from port to port: piston seal or motor leaks",
        "a shuttle or crossover valve; a valve that leaks at both edges; of the meter alone, its calibration",
        "hold a load with shut valves and warm oil, and measure the creep; then replace the seals",
    ),
    Cause(
        "holding",
        True,
        (("lost_1-",), ("lost_1+",), ("lost_2-",), ("lost_2+",)),
        ESTIMATES,
        "{axis}: oil leaves or reaches one port though its valve is shut",
        "load-holding valve, spool edge, hose, a rod seal that drips",
        "lower the load; look for oil outside first, then test the load-holding valve",
    ),
    Cause(
        "stiffness",
        True,
        (("stiff_1+",), ("stiff_1-",), ("stiff_2+",), ("stiff_2-",)),
        (),
        "{axis}: the oil yields more or less than it did",
        "air in the oil, a soft hose; if on all axes, air or another temperature",
        "look for foam in the tank and for a leaking suction line; bleed the cylinder",
    ),
    Cause(
        "deadband",
        True,
        tuple((f"deadband_{way}{sign}",) for way in ("forward", "backward") for sign in "+-"),
        ("motion",),
        "{axis}: the valve's overlap has drifted; the driver has learnt the new one",
        "a centring spring, an amplifier's zero; a bias of the supply's transducer",
        "check the amplifier's zero and dither; identify the valve anew",
    ),
    Cause(
        "motion",
        True,
        (("follow+",), *tuple((f"gain_{way}{sign}",) for way in ("forward", "backward") for sign in "+-")),
        (),
        "{axis}: it moves otherwise than its voltage and pressures say",
        "spool, seals, pressure transducers, a valve that wears",
        "without a sensor at the spool: listen to it, and measure the flow",
    ),
    Cause(
        "pump",
        False,
        (("supply-",), ("supply+",)),
        (),
        "the supply's pressure is not the pump's at this flow: the pump leaks, or its compensator has moved",
        "the supply's transducer; a relief valve that leaks; a slow engine",
        "measure the case drain's flow of the pump and its stand-by pressure by a gauge",
    ),
    Cause(
        "drain",
        False,
        (("drain+",), ("drain-",)),
        (),
        "the swing motor's case drain does not carry what it did",
        "a worn motor; oil of another temperature or grade; the meter",
        "compare at the same oil temperature; plan the motor's overhaul",
    ),
    Cause(
        "cold",
        False,
        (("cold+",),),
        ("drain",),
        "the oil is colder than 15 degrees Celsius",
        "the thermometer",
        "let it warm at low speed: seals, pump and accuracy want warm oil",
    ),
)
MACHINE_FILE = Cause(
    "machine file",
    False,
    (),
    ("motion", "deadband", "length", "drain", "pump"),
    "from the start the machine moves otherwise than its file says: the file may not be this machine's",
    "a file that was never identified; sensors that were mixed up; of a meter alone, its calibration, or a "
    "leak that was there before",
    "compare name plate and file; identify the machine (docs/how-to/real-iron.md)",
)
SENSOR_LOST = "no readings", "replace it, or its cable; until then what needs it is not watched"
SENSOR_FROZEN = "repeats its last reading", "check the converter, then replace the sensor"
