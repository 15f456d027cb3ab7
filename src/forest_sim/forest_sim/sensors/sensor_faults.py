"""What is wrong with which sensor, as people write it: `boom_resolver: frozen from 2 s; swing_flow: absent`.

Faults stand one after the other, separated by `;` or a line's end. Each names a channel, a colon
and

| words | the channel |
|---|---|
| `absent` | is not there |
| `frozen` | repeats its last reading |
| `bias NUMBER UNIT` | reads too much by that |
| `drop`, `drop NUMBER %` | loses every sample, or that share of them |
| `noise NUMBER %` | has so much of its noise |

and may end in `from NUMBER s`, `until NUMBER s`, or both: time since the machine started. Units are
those of machine files. A channel may have several faults.
"""

import math
import re

from forest_description.config.units import UNITS, units_for
from forest_sim.sensors.sensor_model import ABSENT, DROPPED, FROZEN, WORKS
from forest_sim.sensors.sensor_suite import CHANNELS, UNIT, Fault

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
FORM = re.compile(
    rf"(?P<word>[a-z]+)(?:\s+(?P<amount>{NUMBER})\s*(?P<unit>[A-Za-z%]\S*))?"
    rf"(?:\s+from\s+(?P<start>{NUMBER})\s*s)?(?:\s+until\s+(?P<end>{NUMBER})\s*s)?"
)
ALLOWED = (
    "absent; frozen; bias NUMBER UNIT; drop; drop NUMBER %; noise NUMBER %; "
    "each with 'from NUMBER s', 'until NUMBER s' or both after it"
)
LARGEST_BIAS = 1e9  # [any]; a slipped decimal point, or what no arithmetic survives
LOUDEST = 1e6  # [%] of noise: ten thousand times
MODES = {"absent": ABSENT, "frozen": FROZEN, "bias": WORKS, "drop": DROPPED, "noise": WORKS}


def parse_faults(text: str) -> tuple[Fault, ...]:
    """Return the faults that a text names; an empty text names none.

    Raises:
        ValueError: unknown channel, fault or unit, a number that does not fit; the text says what
            is allowed.
    """
    entries = (entry.strip() for entry in re.split(r"[;\n]", text))
    return tuple(_fault(entry) for entry in entries if entry)


def _fault(entry: str) -> Fault:
    name, _, fault = (part.strip() for part in entry.partition(":"))
    if name not in CHANNELS:
        raise ValueError(f"'{entry}': there is no sensor '{name}'; there are {', '.join(CHANNELS)}")
    form = FORM.fullmatch(fault)
    if form is None or form["word"] not in MODES:
        raise ValueError(f"'{entry}': '{fault}' is no fault; allowed: {ALLOWED}")
    start = float(form["start"]) if form["start"] else 0.0
    end = float(form["end"]) if form["end"] else math.inf
    if not 0.0 <= start < end:
        raise ValueError(
            f"'{entry}': from {start:g} s until {end:g} s; allowed: a time from 0 s on and a later one"
        )
    bias, probability, noise = _amount(entry, name, form)
    return Fault(
        channel=CHANNELS.index(name),
        mode=MODES[form["word"]],
        bias=bias,
        probability=probability,
        start=start,
        end=end,
        noise=noise,
    )


def _amount(entry: str, name: str, form: re.Match[str]) -> tuple[float, float, float]:
    """Return bias [the channel's unit], probability, and factor of the noise of a fault."""
    word, unit = form["word"], form["unit"]
    if word in ("absent", "frozen") and unit:
        raise ValueError(f"'{entry}': '{word}' takes no amount; allowed: {ALLOWED}")
    amount = float(form["amount"]) if unit else 100.0
    if word == "drop" and not (unit in (None, "%") and 0.0 <= amount <= 100.0):
        raise ValueError(f"'{entry}': drop {amount:g} {unit}; allowed: 0 .. 100 %")
    if word == "noise":
        if unit != "%" or not 0.0 <= amount <= LOUDEST:
            raise ValueError(f"'{entry}': noise needs a share; allowed: 0 .. {LOUDEST:g} %")
        return 0.0, 1.0, 0.01 * amount
    if word != "bias":
        return 0.0, 0.01 * amount, 1.0
    if unit not in UNITS or UNITS[unit].si != UNIT[name]:
        raise ValueError(
            f"'{entry}': bias needs a number and a unit; allowed: {', '.join(units_for(UNIT[name]))}"
        )
    bias = amount * UNITS[unit].factor
    if not abs(bias) <= LARGEST_BIAS:
        raise ValueError(f"'{entry}': bias {bias:g}; allowed: up to {LARGEST_BIAS:g} {UNIT[name]}")
    return bias, 1.0, 1.0
