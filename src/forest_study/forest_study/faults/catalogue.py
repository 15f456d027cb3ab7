"""The one table of faults: what is done, in which states, what must happen, and why.

Where a bound asks only how far the tip gets, nobody sees the fault: that is a gap, and its reason says so.
"""

from forest_study.faults import wires
from forest_study.faults.fault import ALL, DRIVEN, HELD, MOVING, Bound, Fault, State, same

JOYSTICK_LOST = "joystick: nothing new for longer than joy_timeout"
NO_STATE = "nothing good of the machine's state"
# How sentences of `runaway`, `machine_file_check`, `overloaded_joint` and, of its supply, the driver begin.
OF_MACHINE = ("machine", "overload", "supply", "the supply")
STATE_BAD = "joint state: "
AT_ONCE = Bound(zero=0.02, way=0.06)
HEARD = Bound(zero=0.1, way=0.12)
UNSEEN = "A sensor that lies plausibly is believed: gap."


def _joystick(zero: float, way: float, told: str, within: float) -> dict[State, Bound]:
    """Return the bound of a joystick's fault; nothing moves after it in a crane that stands."""
    bound = Bound(zero=zero, way=way, told=told, told_within=within)
    return same(bound, HELD, STANDING=bound._replace(zero=0.0, way=0.005, again=False))


def _state(bound: Bound, experiment: Bound, standing: str = "") -> dict[State, Bound]:
    """Return the bound of what the machine says; in an experiment the valves stay shut until another."""
    still = Bound(zero=0.0, way=0.005, told=standing, again=False)
    found = same(bound, HELD, STANDING=still)
    return found | {State.EXPERIMENT: experiment._replace(again=False)}


def _off(off: float, experiment: float) -> dict[State, Bound]:
    """Return the bound of what goes on moving: how far the tip is from where it would be."""
    bound = Bound(off=off)
    found = same(bound, HELD, STANDING=bound._replace(again=False))
    return found | {State.EXPERIMENT: Bound(off=experiment)}


JOYSTICKS = {
    "joystick unplugged": Fault(
        "one sample at rest, then none",
        "A released deadman: 0.25 s. The joystick's node logs the device's name.",
        _joystick(0.25, 0.1, "", 2.0),
        joystick=wires.unplugged,
    ),
    "joystick silent": Fault(
        "no sample",
        "`joy_timeout` 0.15 s, then the stop along the path, 0.25 s.",
        _joystick(0.41, 0.19, JOYSTICK_LOST, 0.16),
        joystick=wires.silent,
    ),
    "joystick hangs": Fault(
        "the last sample under new stamps, of a device that was never still for 45 s of play",
        "Frozen after 0.5 s, then the stop. In taught work, with centred sticks, only after 10 s"
        " (`test_taught_watch.py`).",
        same(Bound(zero=0.76, way=0.4, told="joystick: held still", told_within=0.51), MOVING),
        joystick=wires.hanging,
    ),
    "joystick flickers": Fault(
        "0.2 s of silence, 0.2 s of samples, and so on",
        "Each silence is a loss, and the levers were not centred since. A taught cycle is paused, and held."
        " Standing, the levers are centred: the tip is held as before.",
        _joystick(0.41, 0.19, JOYSTICK_LOST, 0.16)
        | {
            State.STANDING: Bound(way=0.005, told=JOYSTICK_LOST, again=False),
            State.TAUGHT: Bound(way=0.25, told=JOYSTICK_LOST),
        },
        joystick=wires.flickering,
    ),
    "joystick sends garbage": Fault(
        "levers that are no numbers",
        "As a released deadman.",
        _joystick(0.25, 0.1, "joystick: its last sample cannot be read", 0.01),
        joystick=wires.garbled,
    ),
    "two joysticks": Fault(
        "a second one publishes levers at rest, its deadman released",
        "A release counts, whoever says it. The supervisor's log names a second publisher.",
        _joystick(0.25, 0.1, "", 2.0),
        joystick=wires.doubled,
    ),
    "joystick's clock + 1 h": Fault(
        "its stamps jump ahead",
        "Stamps only put samples in order; age is local time. Back again they are out of order until lost.",
        same(Bound(off=0.03), HELD, STANDING=Bound(off=0.005, again=False)),
        joystick=wires.joystick_ahead,
    ),
    "joystick's clock - 1 h": Fault(
        "its stamps jump back",
        "Samples of the past: as silence. In taught work centred sticks arm again: its ramp brakes the tip.",
        _joystick(0.41, 0.19, "joy: a stamp goes back", 0.01)
        | {State.TAUGHT: Bound(zero=0.6, way=0.19, told="joy: a stamp goes back")},
        joystick=wires.joystick_behind,
    ),
    "joystick's clock stands": Fault(
        "the same stamp again and again",
        "As silence.",
        _joystick(0.41, 0.19, JOYSTICK_LOST, 0.16),
        joystick=wires.joystick_stands,
    ),
    "joystick's axes swapped": Fault(
        "boom's lever moves the stick, and the other way round",
        "Nobody can see it: gap. The speed stays the profile's, and the deadman stops the tip.",
        same(Bound(speed=0.9), MOVING),
        joystick=wires.crossed,
    ),
}
CLOCKS_AND_LINKS = {
    "machine's clock + 1 h": Fault(
        "stamps of the state jump ahead",
        "Periods are clipped. Back again, states are of the past: zero after 0.1 s, centred levers.",
        _off(0.06, 0.06) | {State.EXPERIMENT: Bound(off=0.06, again=False)},
        stamp=wires.ahead,
    ),
    "machine's clock - 1 h": Fault(
        "stamps of the state jump back",
        "States of the past: `state_timeout`, 0.1 s. Then they are believed; a taught cycle stays paused.",
        _state(
            HEARD._replace(told="joint state: the stamp goes back"),
            Bound(zero=0.11, told=NO_STATE),
            "joint state: the stamp goes back",
        )
        | {State.TAUGHT: Bound(way=0.15, told="joint state: the stamp goes back")},
        stamp=wires.behind,
    ),
    "machine's clock stands": Fault(
        "the same stamp again and again",
        "As no state: 0.1 s.",
        _state(
            HEARD._replace(told="joint state: the stamp stands still"),
            Bound(zero=0.11, told=NO_STATE),
            "joint state: the stamp stands still",
        ),
        stamp=wires.stands,
    ),
    "states lost": Fault(
        "no state of the machine",
        "`state_timeout`, 0.1 s.",
        _state(
            HEARD._replace(told="no ", told_within=0.11),
            Bound(zero=0.11, told=(NO_STATE, "no command"), told_within=0.11),
            "no ",
        ),
        state_lost=wires.lost,
    ),
    "half of the states lost": Fault(
        "every second one, by chance",
        "Periods come from stamps; a gap under 0.1 s is none.",
        _off(0.1, 0.1),
        state_lost=wires.half_lost,
    ),
    "commands lost": Fault(
        "none reaches the driver",
        "`command_timeout`, 0.1 s; gone for 0.3 s, the gate waits for a command of zero.",
        _state(
            HEARD._replace(told="no command", told_within=0.11),
            Bound(zero=0.11, told="no command", told_within=0.11),
            "no command",
        ),
        command=wires.no_command,
    ),
    "commands lost for 0.4 s": Fault(
        "a link that heals before the controller misses its driver",
        "The same. The reference has gone on: without the gate's rule the crane runs after it at 1.4 m/s.",
        _state(
            HEARD._replace(told="no command", told_within=0.11),
            Bound(zero=0.11, told="no command", told_within=0.11),
            "no command",
        ),
        command=wires.no_command,
        lasts=0.4,
    ),
    "commands now and then": Fault(
        "one in 0.15 s",
        "Each gap shuts the valves for 50 ms; under 0.3 s they open again: gap. The crane jerks.",
        _off(0.25, 3.0)
        | same(Bound(off=0.25, speed=1.5, told="no command"), DRIVEN)
        | {State.STANDING: Bound(off=0.01, told="no command", again=False)},
        command=wires.late_command,
    ),
    "commands no numbers": Fault(
        "NaN",
        "Zero at once; after 0.1 s of it as commands lost.",
        _state(
            AT_ONCE._replace(told="valve_commands"), Bound(zero=0.02, told="valve_commands"), "valve_commands"
        ),
        command=wires.no_number,
    ),
    "controller hangs": Fault(
        "its last command again and again",
        "Stamps that stand still: 0.1 s.",
        _state(HEARD._replace(told="valve_commands"), Bound(zero=0.11, told="valve_commands"), ""),
        command=wires.repeated,
    ),
    "controller restarted": Fault(
        "a new controller, levers deflected",
        "It has not seen centred levers. In taught work a person resumes.",
        same(AT_ONCE, HELD, STANDING=Bound(zero=0.0, way=0.005, again=False)),
        restarts=True,
        for_good=True,
    ),
}
SENSORS = {
    "resolver absent": Fault(
        "one has no sample",
        "No state: zero in that very step.",
        _state(
            AT_ONCE._replace(told=STATE_BAD, told_within=0.01), Bound(zero=0.02, told=NO_STATE), STATE_BAD
        ),
        sensors="{axis}_resolver: absent",
    ),
    "resolver frozen": Fault(
        "one repeats its last reading",
        "Seen once its joint was told to go 0.02 rad. In taught work centred sticks arm again: the cycle"
        " stays paused, but the tip is held by a wrong angle: gap. So may a crane that stands inch.",
        _state(Bound(way=0.75), Bound(zero=1.0))
        | {State.STANDING: Bound(way=0.005, again=False), State.TAUGHT: Bound(way=0.45, held=True)},
        sensors="{axis}_resolver: frozen",
    ),
    "resolver drops half": Fault(
        "half of one's samples are missing",
        "Zero in each of these steps; between them the crane moves on, slower, and its fault is told.",
        _off(1.3, 3.0)
        | same(Bound(off=1.3, told=STATE_BAD), DRIVEN)
        | {State.STANDING: Bound(off=0.01, told=STATE_BAD, again=False)},
        sensors="{axis}_resolver: drop 50 %",
    ),
    "resolver off by 2 degrees": Fault(
        "one reads too much",
        "The jump is refused for 0.1 s, as no state; then a sensor that lies plausibly is believed: gap."
        " In taught work centred sticks arm again, and the tip is held.",
        same(Bound(off=1.2, again=False, held=True), HELD) | {State.EXPERIMENT: Bound(off=0.4)},
        sensors="{axis}_resolver: bias 2 deg",
    ),
    "resolver noise x 100": Fault(
        "one has a hundred times its noise",
        "Rates beyond 5 rad/s are refused one by one, and told. Between them the crane shakes: gap.",
        same(Bound(off=1.3, again=False, held=True), HELD) | {State.EXPERIMENT: Bound(off=0.4)},
        sensors="{axis}_resolver: noise 10000 %",
    ),
    "resolver glitches": Fault(
        "one reads 0.3 rad too much in one sample of twenty",
        "No joint moves so far in a period: zero in that very step. Between them the crane goes on.",
        same(Bound(off=1.3, speed=1.2, told=STATE_BAD), DRIVEN)
        | {State.STANDING: Bound(off=0.01, speed=0.1, told=STATE_BAD, again=False)},
        seen=wires.glitching,
    ),
    "resolvers swapped": Fault(
        "boom's and stick's plugs",
        "Out of the joints' limits: zero in that very step.",
        _state(AT_ONCE._replace(told=STATE_BAD, told_within=0.01), Bound(), STATE_BAD),
        seen=wires.swapped,
    ),
    "resolver counts back": Fault(
        "one counts the other way",
        "The servo drives away from its reference until the joint has gone against its commands for some"
        " tenths of a second. Where it is hardly asked to move, it may not be named: gap.",
        same(Bound(speed=1.5, again=False), DRIVEN, MOTION=Bound(zero=1.0, again=False))
        | {State.EXPERIMENT: Bound(again=False)},
        seen=wires.reversed_axis,
    ),
    "degrees for radians": Fault(
        "somebody else's unit",
        "Out of the joints' limits.",
        _state(AT_ONCE._replace(told=STATE_BAD, told_within=0.01), Bound(zero=0.02, told="the "), STATE_BAD),
        seen=wires.in_degrees,
    ),
    "cylinder transducer frozen": Fault(
        "one repeats its last reading",
        "Over 0.03 rad from its resolver for 0.3 s, it stops the crane while it is. At once over 0.1 rad, it"
        " is left out.",
        same(Bound(off=0.9), HELD, STANDING=Bound(off=0.02, again=False)),
        sensors="{cylinder}_transducer: frozen",
    ),
    "cylinder transducers swapped": Fault(
        "boom's and stick's plugs",
        "Over 0.1 rad from its angle a length is left out; between 0.03 and 0.1 rad the crane stops.",
        same(Bound(off=0.9), HELD, STANDING=Bound(off=0.02, again=False)),
        seen=wires.crossed_transducers,
    ),
    "pressures absent": Fault(
        "no transducer has a sample",
        "The nominal load is taken. Not weighed for 0.5 s: only motions that unload pass,"
        " and a taught cycle waits where it is. "
        "A limit: weighed again, what it held goes on while deadman and levers ask for it.",
        same(
            Bound(off=1.2, told="load: not weighed", held=True),
            HELD,
            STANDING=Bound(off=1.2, told="load: not weighed", again=False),
        )
        | {State.EXPERIMENT: Bound(zero=0.11, told="nothing good on hydraulics/pressures", again=False)},
        seen=wires.no_pressures,
    ),
    "pressures frozen": Fault(
        "all repeat what they read",
        UNSEEN + " The driver's knowledge of the load stands still.",
        _off(0.2, 0.02),
        seen=wires.frozen_pressures,
    ),
    "swing's pressure 30 MPa high": Fault(
        "the transducer at one port of its motor",
        "Both ends of a hose tell: over half of the pump's pressure apart, the nominal load is taken.",
        same(Bound(off=0.2, speed=0.9), HELD, STANDING=Bound(off=0.01, speed=0.1, again=False))
        | {State.EXPERIMENT: Bound(again=False)},
        seen=wires.swing_pressure_high,
    ),
    "pressures 3 MPa high": Fault(
        "all read too much",
        UNSEEN + " Both sides are high alike, so that the load is known.",
        _off(0.2, 0.02),
        seen=wires.high_pressures,
    ),
}
VALVES = {
    "spool stuck": Fault(
        "one stays where it is; the operator lets go 0.5 s later",
        "No voltage moves it: the tip goes on. Slow joints are not named: gap under 0.05 rad/s.",
        same(Bound(zero=0.8, again=False), HELD) | {State.EXPERIMENT: Bound(again=False)},
        volts=wires.stuck,
        let_go=0.5,
    ),
    "valve does not close": Fault(
        "a chip holds one open by a third; the operator lets go 0.5 s later",
        "Named as overload where the servo opens the valve against it, or as a joint that goes by itself; not"
        " under 0.05 rad/s: gap.",
        same(Bound(zero=0.8, again=False), HELD) | {State.EXPERIMENT: Bound(again=False)},
        volts=wires.not_closing,
        let_go=0.5,
    ),
    "short circuit": Fault(
        "full voltage on one valve; the operator lets go 0.5 s later",
        "The same. A joint at its end stop goes no further, and is not named.",
        same(Bound(zero=0.8, told=OF_MACHINE, told_within=1.6, again=False), MOVING)
        | {state: Bound(zero=0.8, again=False) for state in (State.STANDING, State.TAUGHT)}
        | {State.EXPERIMENT: Bound(again=False)},
        volts=wires.wrong_from_here,
        let_go=0.5,
    ),
    "valve wired the other way": Fault(
        "one, in motion",
        "As a resolver that counts back; also a swing that goes to and fro on its oil.",
        same(Bound(speed=1.6, again=False), DRIVEN) | {State.EXPERIMENT: Bound(again=False)},
        volts=wires.crossed_valves,
    ),
    "valves' cable cut": Fault(
        "no voltage reaches the spools, and comes back",
        "Joints that stand though their valves are open are named after some 1 s at 0.5 m/s.",
        same(Bound(off=1.3), DRIVEN) | {State.EXPERIMENT: Bound()},
        volts=wires.no_volts,
    ),
}
NO_OIL = Bound(zero=0.25, speed=0.7, told="the supply", told_within=0.25, again=False)
NO_SUPPLY = same(NO_OIL, DRIVEN) | {State.EXPERIMENT: Bound(told="the supply", again=False)}
MACHINE = {
    "cylinders' pipes torn": Fault(
        "180 L/min at 10 MPa out of each port, before the load-holding valves",
        "The crane falls, and no valve holds it. The valves shut, and the operator is told. A pump that feeds"
        " the leak through a wide open valve holds the crane: a boom that only stands is told the later, the"
        " slower it was asked to move; in position mode never: gap.",
        same(Bound(zero=1.0, told=OF_MACHINE, told_within=1.0, again=False), HELD)
        | {State.MOTION: Bound(zero=1.2, told=OF_MACHINE, told_within=1.2, again=False)}
        | {State.POSITION: Bound(again=False), State.EXPERIMENT: Bound(again=False)},
        breaks=wires.torn_hoses,
        for_good=True,
    ),
    "supply lost": Fault(
        "the pumps give nothing",
        "The driver shuts the valves and says why; in an experiment its operator node.",
        NO_SUPPLY,
        breaks=wires.no_supply,
        for_good=True,
    ),
    "supply lost for 2 s": Fault(
        "the same, and back at once",
        "Its return moves nothing before the deadman was released.",
        NO_SUPPLY | same(NO_OIL._replace(again=True), DRIVEN),
        breaks=wires.no_supply,
    ),
    "engine stalled": Fault(
        "it stands still",
        "As a supply that is lost.",
        NO_SUPPLY,
        breaks=wires.stalled,
        for_good=True,
    ),
    "wrong machine file": Fault(
        "the crane is driven with the file of `loader`",
        "Cylinders do not belong to their angles: named after 0.3 s.",
        same(
            Bound(zero=0.35, way=0.03, told="machine file: ", told_within=0.35, again=False),
            (State.STANDING, *MOVING),
        ),
        file="loader",
        for_good=True,
    ),
}
FAULTS: dict[str, Fault] = {**JOYSTICKS, **CLOCKS_AND_LINKS, **SENSORS, **VALVES, **MACHINE}
assert all(state in ALL for fault in FAULTS.values() for state in fault.bounds)
