"""What a row of a table lets through is of its default's type, finite and within its range."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from properties import ANY

from forest_msgs_py.runtime.parameter_table import Parameter, ParameterError

ROWS = (
    *(Parameter("", name="x", default=1.0), Parameter("", name="x", default=1.0, low=-2.0, high=3.0)),
    *(Parameter("", name="x", default=2, low=1, high=9), Parameter("", name="x", default=True)),
    *(Parameter("", name="x", default="a", choices=("a", "b")), Parameter("", name="x", default="a")),
    *(Parameter("", name="x", default=(1.0, 2.0), low=0.0), Parameter("", name="x", default=(1, 2, 3))),
)
ONE = st.none() | st.booleans() | st.integers() | st.just(10**400) | ANY | st.sampled_from("abc")
GIVEN = ONE | st.lists(ONE, max_size=3) | st.lists(st.floats(0.0, 9.0), min_size=2, max_size=2)


def fits(row, value):
    """Tell whether a value needs no conversion and is allowed."""
    if isinstance(row.default, tuple):
        one = row._replace(default=row.default[0])
        return (
            isinstance(value, tuple) and len(value) == len(row.default) and all(fits(one, x) for x in value)
        )
    if type(value) is not type(row.default) or (row.choices is not None and value not in row.choices):
        return False
    is_number = not isinstance(value, float) or math.isfinite(value)
    return is_number and (row.low is None or value >= row.low) and (row.high is None or value <= row.high)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.default!r} {row.low} {row.choices}")
@given(value=GIVEN)
def test_whatever_is_given_what_passes_fits_and_all_else_is_refused_in_a_sentence(row, value):
    try:
        passed = row.checked(value)
    except ParameterError as error:
        refusal = str(error)
    else:
        assert fits(row, passed)
        assert passed == (tuple(value) if isinstance(value, list) else value)
        return
    assert refusal.startswith("parameter 'x' is ")
    assert "; allowed: " in refusal
    assert not fits(row, tuple(value) if isinstance(value, list) else value)


@pytest.mark.parametrize(
    ("default", "allowed"), [(("",), "a list of texts"), ((0.0, 1.0), "a list of finite numbers")]
)
def test_a_list_says_whether_it_takes_texts_or_numbers(default, allowed):
    assert Parameter("topics", default=default).allowed == allowed
