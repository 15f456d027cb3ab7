"""A step as machine code is called as the step itself, whatever states, inputs, parameters come in turn."""

import ctypes
from typing import NamedTuple

import pytest

pytest.importorskip("llvmlite")

from forest_compile import machine_code
from forest_compile.compiled_step import ARGUMENTS, CompiledStep, Example, entry
from forest_compile.frontend import translate


class Inner(NamedTuple):
    angle: float
    flows: tuple[float, float]


class State(NamedTuple):
    count: int
    inner: Inner
    on: bool


class Parameters(NamedTuple):
    gain: float
    row: tuple[float, float, float]


class Output(NamedTuple):
    flow: float
    place: int


def law(state, lever, more, p, dt):
    angle = state.inner.angle + p.gain * lever * dt
    after = State(state.count + 1, Inner(angle, (more[1], state.inner.flows[0])), angle > 1.0)
    return after, Output(p.row[state.count] * more[0], state.count)


P = Parameters(2.0, (1.0, 0.5, 0.25))
BEGIN = State(0, Inner(0.0, (0.0, 0.0)), False)


@pytest.fixture(scope="module")
def step():
    example = Example(BEGIN, (0.5, (1.0, 2.0)), P, Output(0.0, 0))
    code = machine_code.optimised(translate.llvm_ir(entry(law, example, ())))
    return CompiledStep(machine_code.load(code, ARGUMENTS), example)


def test_each_state_stays_what_it_was_while_others_are_stepped(step):
    states, twins = [BEGIN], [BEGIN]
    for lever, more, p in (
        (3.0, (1.0, 2.0), P),
        (4.0, (3.0, 4.0), P),
        (5.0, (5.0, 6.0), P._replace(gain=9.0)),
    ):
        state, output = step(states[-1], lever, more, p, 0.1)
        twin, same = law(twins[-1], lever, more, p, 0.1)
        assert output == same
        states.append(state)
        twins.append(twin)
    assert [state.built for state in states[1:]] == twins[1:]
    assert [type(part) for part in states[2].built] == [int, Inner, bool]
    assert states[3].inner.flows == twins[3].inner.flows
    again, _ = step(states[1], 4.0, (3.0, 4.0), P, 0.1)  # a state that is not the last one
    assert again.built == twins[2]


def test_after_a_fault_the_state_before_it_counts(step):
    last, _ = step(State(2, Inner(0.5, (0.0, 0.0)), True), 1.0, (1.0, 1.0), P, 0.1)
    with pytest.raises(ArithmeticError, match="an index beyond a tuple of 3"):
        step(last, 1.0, (1.0, 1.0), P, 0.1)
    assert last.built == law(State(2, Inner(0.5, (0.0, 0.0)), True), 1.0, (1.0, 1.0), P, 0.1)[0]
    other, output = step(last.built._replace(count=1), 1.0, (1.0, 1.0), P, 0.1)
    assert (other.count, output) == (2, Output(0.5, 1))
    with pytest.raises(AttributeError, match="nothing"):
        _ = other.nothing


def test_a_state_is_laid_out_again_after_a_kernel_that_wrote_and_failed():
    seen, fails = [], iter((False, True, False))

    def kernel(state, *_):
        numbers = ctypes.cast(state, ctypes.POINTER(ctypes.c_double))
        seen.append(numbers[0])
        numbers[0] += 1.0
        if next(fails):
            raise ArithmeticError

    step = CompiledStep(kernel, Example(BEGIN, (0.5,), 1.0, 0.0))
    last, _ = step(BEGIN, 0.5, 1.0, 0.1)
    with pytest.raises(ArithmeticError):
        step(last, 0.5, 1.0, 0.1)
    again, _ = step(last, 0.5, 1.0, 0.1)
    assert seen == [0.0, 1.0, 1.0]
    assert (last.count, again.count) == (1, 2)
