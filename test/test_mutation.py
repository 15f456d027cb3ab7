"""What scripts/mutate.sh is told stays true while the code moves on."""

import re
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
MODULES = yaml.safe_load((ROOT / "test/mutation/modules.yaml").read_text("utf-8"))
SURVIVORS = yaml.safe_load((ROOT / "test/mutation/survivors.yaml").read_text("utf-8"))


def lines_of(module):
    """The module's lines as a mutant's key has them: without comment, single spaces."""
    return {
        " ".join(line.split("  #")[0].split())
        for line in (ROOT / "src" / module).read_text("utf-8").splitlines()
    }


@pytest.mark.parametrize("module", MODULES)
def test_modules_and_their_tests_are_there(module):
    assert (ROOT / "src" / module).is_file()
    assert MODULES[module]
    for test in MODULES[module]:
        assert (ROOT / "test" / test.partition("::")[0]).is_file()


@pytest.mark.parametrize("module", SURVIVORS)
def test_every_survivor_that_is_explained_stands_in_the_module_and_has_a_reason(module):
    lines = lines_of(module)
    assert module in MODULES
    for keys in SURVIVORS[module].values():
        for key, reason in keys.items():
            line = re.sub(r"«(.*?) → .*?»", r"\1", key.partition("  #")[0])
            assert line in lines, key
            assert len(reason) > 10, key
