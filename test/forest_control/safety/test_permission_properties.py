"""Whatever happens in whatever order: nothing moves without a live deadman, nor again without an act."""

import math

from guard_rig import PUSHED, REST, Rig, hangs, nonsense
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule
from properties import holds

from forest_control.operator.joystick_watch import Joystick
from forest_control.safety.motion_guard import WAS_FAULTY
from forest_control.safety.motion_permission import NOBODY, Cause, Override, Verdict

JOY_TIMEOUT = 0.15  # [s]
WELL = {
    "problem": "",
    "override": NOBODY,
    "driver_speaks": True,
    "shakes": True,
    "lag": 0.0,
}
ILL = {
    "problem": st.just("joint state: none"),
    "override": st.sampled_from((Override(emergency_stop=True), Override(hands_off=True))),
    "driver_speaks": st.just(False),
    "shakes": st.just(False),
    "lag": st.just(0.2),
}
JOYSTICKS = {
    "speaks": lambda rig: setattr(rig, "speak", rig.sample),
    "is silent": lambda rig: setattr(rig, "speak", lambda: None),
    "sends nonsense": nonsense,
    "hangs": hangs,
    "speaks of the past": lambda rig: setattr(rig, "speak", lambda: rig.sample()._replace(stamp=1)),
}
PERIODS = st.sampled_from((2, 40))


class Guarded(RuleBasedStateMachine):
    """A crane whose parts fail and heal, and what the guard may make of it."""

    def __init__(self):
        super().__init__()
        self.rig = Rig()
        self.heard = -math.inf  # when the joystick last said something new [s]
        self.stamp = 0  # of what it said
        self.held = self.acted = self.waits = False

    @rule()
    def a_person_makes_all_well_and_acts(self):
        for name, value in WELL.items():
            setattr(self.rig, name, value)
        self.rig.speak, self.rig.levers, self.rig.held = self.rig.sample, REST, False
        self.time_goes_on(30)  # the joystick is heard again, and what is frozen moves
        self.rig.held = True
        self.time_goes_on(3)
        self.rig.levers = PUSHED
        assert self.a_period().verdict == Verdict.MOVE

    @initialize()
    def it_moves(self):
        self.a_person_makes_all_well_and_acts()

    @rule(fault=st.one_of(*[st.tuples(st.just(name), value) for name, value in ILL.items()]), periods=PERIODS)
    def something_fails(self, fault, periods):
        setattr(self.rig, *fault)
        self.time_goes_on(periods)

    @rule(joystick=st.sampled_from(tuple(JOYSTICKS)), periods=PERIODS)
    def the_joystick(self, joystick, periods):
        JOYSTICKS[joystick](self.rig)
        self.time_goes_on(periods)

    @rule(levers=st.sampled_from((REST, PUSHED)), held=st.sampled_from((True, True, False)), periods=PERIODS)
    def all_heals_but_the_hand_is_as_it_is(self, levers, held, periods):
        for name, value in WELL.items():
            setattr(self.rig, name, value)
        self.rig.levers, self.rig.held = levers, held
        self.time_goes_on(periods)

    def time_goes_on(self, periods):
        for _ in range(periods):
            self.a_period()

    def a_period(self):
        said, speak = [], self.rig.speak
        self.rig.speak = lambda: said.append(speak()) or said[-1]
        watched = self.rig.guard.permission.joystick.joystick
        decision = self.rig.once()
        self.rig.speak = speak
        if said[0] is not None:
            self.hear(said[0], watched == Joystick.ALIVE)
        self.judge(decision)
        return decision

    def hear(self, sample, was_alive):
        """Take in a sample; only a joystick that is not alive may begin anew in the past."""
        stands = sample.stamp == self.stamp != 0
        self.waits = self.waits and sample.held
        if sample.good and not stands and (sample.stamp == 0 or sample.stamp > self.stamp or not was_alive):
            self.held, self.heard, self.stamp = sample.held, self.rig.now, sample.stamp
            self.acted = self.held and (self.acted or sample.levers == REST)
        else:
            self.held = self.held and sample.held
            self.acted = self.acted and self.held

    def judge(self, decision):
        if decision.verdict == Verdict.MOVE:
            assert self.held
            assert self.rig.now - self.heard <= JOY_TIMEOUT
            assert self.acted
            assert not self.waits
            assert (self.rig.override, self.rig.problem, self.rig.lag) == (NOBODY, "", 0.0)
            return
        assert decision.levers == REST
        if (
            decision.verdict in (Verdict.STOP, Verdict.CONTROLLED_STOP)
            and decision.cause != Cause.UNBELIEVABLE
        ):
            self.acted = False
        self.waits = self.rig.guard.causes["machine"] == WAS_FAULTY or self.waits


def test_nothing_moves_without_a_live_deadman_nor_again_without_an_act():
    holds(Guarded, examples=25, steps=15)
