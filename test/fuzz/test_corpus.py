"""What fuzzing has found runs again: each input is read, or refused in a sentence (`scripts/fuzz.sh`)."""

import fuzz_targets as targets
import pytest


@pytest.mark.parametrize("name", targets.TARGETS)
def test_whatever_comes_is_read_or_refused(name):
    known = [*targets.TARGETS[name].seeds(), *targets.corpus(name)]
    assert known
    targets.warm(name)
    for data in known:
        targets.run(name, data)
