"""Numbers of forest_control: found by name, and changed wherever they were imported to."""

import subprocess
import sys

import pytest

from forest_description.machine import load_machine
from forest_study.ablation.constants import changed, numbers, scaled
from forest_study.results import StudyError

AFTER_A_CHANGE = """
from forest_study.ablation.constants import changed
settings = changed({"servo.schemes.ERROR_LAG": 0.2, "controller.lead": 0.1, "servo.schemes.REST_RATE": 1.0})
from forest_control.servo import coordinated_servo, schemes
print(schemes.ERROR_LAG, coordinated_servo.ERROR_LAG, settings.control.lead)
print(schemes.REST_RATE, coordinated_servo.REST_RATE)
"""
GAINS = """
from forest_control.config.controller_settings import Settings, parameters
from forest_description.machine import load_machine
from forest_study.ablation.constants import changed
before = parameters(load_machine("c180_hoses"), Settings())
changed({"servo.gain_rule.HIGHEST_GAIN": (1.0, 1.0, 1.0)})
print(before.gains[1].feedback, parameters(load_machine("c180_hoses"), Settings()).gains[1].feedback)
"""
AT_RUNTIME = """
from forest_study.ablation.constants import at_runtime, changed
from forest_control.safety import overloaded_joint
from forest_control.servo import coordinated_servo, schemes
changed({"servo.schemes.ERROR_LAG": 0.2})
row = at_runtime()
print(row[schemes.ERROR_LAG.place], row[coordinated_servo.ERROR_LAG.place], schemes.ERROR_LAG)
print(*(row[time.place] for time in overloaded_joint.TOGETHER), type(coordinated_servo.MOST_SAMPLES).__name__)
"""


def test_a_change_reaches_who_imported_the_constant_and_nobody_who_has_one_of_the_same_name():
    done = subprocess.run([sys.executable, "-c", AFTER_A_CHANGE], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["0.2", "0.2", "0.1", "1.0", "0.0001"]


def test_what_was_kept_of_a_computation_is_forgotten_when_a_constant_changes():
    done = subprocess.run([sys.executable, "-c", GAINS], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["5.0", "1.0"]


def test_a_kernel_reads_changed_constants_when_it_runs():
    done = subprocess.run([sys.executable, "-c", AT_RUNTIME], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["0.2", "0.2", "0.2", "0.4", "0.3", "0.3", "int"]


def test_constants_of_a_room_and_settings_of_a_node_are_found():
    found = numbers(("servo", "controller"), load_machine("c180_hoses"))
    assert found["servo.inching.LOOK"] == 0.35
    assert found["controller.feedback_gain"][1] == 5.0
    assert "servo.coordinated_servo.ERROR_LAG" not in found  # imported: it has one home
    assert "controller.anti_sway" not in found  # no number
    assert "servo.coordinated_servo.MOST_SAMPLES" not in found  # a size


@pytest.mark.parametrize("name", ["servo.inching.LOOKS", "servo.nowhere.LOOK", "controller.leads", "LOOK"])
def test_an_unknown_name_is_refused_with_an_example(name):
    with pytest.raises(StudyError, match=r"no constant of forest_control and no setting; allowed: .*LOOK"):
        changed({name: 1.0})


def test_numbers_are_scaled_as_what_they_are():
    assert scaled(0.5, 2.0) == 1.0
    assert scaled((1.0, 2.0), 0.5) == (0.5, 1.0)
