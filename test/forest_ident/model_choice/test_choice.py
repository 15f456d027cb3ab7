"""Claims about the choice of physics: what was fitted without a candidate is never lost by it."""

import numpy as np

from forest_description.machine import load_machine
from forest_ident.measurements.session import Session, SessionError
from forest_ident.model_choice.choice import chosen
from forest_ident.refinement.result import Result

PLAIN = load_machine("c180_hoses")
HELD_OUT = Session("validation", np.arange(3.0), np.zeros((3, 3)), {})


def test_a_model_that_cannot_be_fitted_or_compared_is_not_kept_and_says_why():
    def identify(machine):
        if machine.boom.friction is not None:
            raise SessionError("damping_boom: it cannot be evaluated")
        return Result(PLAIN, machine, held_out=[HELD_OUT])

    best = chosen(PLAIN, identify, ("friction", "pendulum"))
    assert best.machine == PLAIN
    friction, pendulum = best.remarks
    assert friction == "--allow friction: dry friction, not kept: damping_boom: it cannot be evaluated"
    assert pendulum.startswith("--allow pendulum: a head that hangs, not kept: validation: too short")
