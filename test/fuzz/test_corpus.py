"""What reads files and messages: whatever comes is read, or refused in a sentence.

What fuzzing has found runs again (`scripts/fuzz.sh`), and what hypothesis makes of good files.
"""

import copy
import itertools
import math

import fuzz_targets as targets
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from properties import spoilt

WILD = (None, 10**400, math.nan, "", "1e999", "\0", [], [{}], {"a": 1}, {1: 2})
YAML = ("machine", "profile", "workspace", "joysticks", "cycle", "study", "experiment")


@pytest.mark.parametrize("name", targets.TARGETS)
def test_whatever_comes_is_read_or_refused(name):
    known = [*targets.TARGETS[name].seeds(), *targets.corpus(name)]
    assert known
    targets.warm(name)
    for data in known:
        targets.run(name, data)


@pytest.mark.parametrize("name", targets.TARGETS)
@settings(max_examples=25)
@given(data=st.data())
def test_what_is_good_and_then_spoilt_is_read_or_refused(name, data):
    seed = data.draw(st.sampled_from(targets.TARGETS[name].seeds()))
    targets.run(name, data.draw(spoilt(seed)))


def places(tree):
    """Where a part of a tree may be exchanged: what holds it, as keys from above, and its own key."""
    if isinstance(tree, dict | list):
        for key in tree if isinstance(tree, dict) else range(len(tree)):
            yield (key,)
            yield from ((key, *below) for below in places(tree[key]))


def with_part(tree, place, part):
    tree = copy.deepcopy(tree)
    above = tree
    for key in place[:-1]:
        above = above[key]
    above[place[-1]] = part
    return tree


@pytest.mark.parametrize("name", YAML)
def test_a_good_file_of_which_any_part_is_another_is_read_or_refused(name):
    good = yaml.safe_load(min(targets.TARGETS[name].seeds(), key=len))
    for place, part in itertools.product(places(good), WILD):
        targets.run(name, yaml.safe_dump(with_part(good, place, part)).encode())
