import pytest

from forest_description.config import random_machine
from forest_description.config.parameter import MachineError
from forest_description.config.source_tree import shipped_machines
from forest_description.machine import load_machine, sources


@pytest.mark.parametrize("base", shipped_machines())
def test_every_shipped_machine_can_be_drawn_from(base):
    """Seeds 8 to 17 would draw an overlap beyond its curve, or a spring that its edges leave too weak."""
    for seed in (0, 7, 8, 11, 15, 17):
        assert load_machine(f"unknown:{seed}:{base}").pump == load_machine(base).pump


def test_a_drawn_overlap_stays_below_the_voltages_at_which_a_valve_was_measured():
    """Drawn evenly up to 1.96 V, it would pass the 1.8 V at which the stick's curve begins."""
    overlaps = [load_machine(f"unknown:{seed}:loader").valve.deadband_voltage for seed in range(12, 22)]
    assert sum(overlap == pytest.approx(0.95 * 1.8) for overlap in overlaps) == 3
    assert max(overlaps) < 1.8


def test_what_is_drawn_lies_within_two_fifths_and_the_rest_is_as_it_was():
    known = {q.key: q for q in sources("c180_hoses")}
    for key, value, unit, source, _ in sources("unknown:3"):
        was = known[key.replace(".backward.", ".")]
        assert unit == was.unit
        if "drawn" in source:
            assert 0.6 <= value / was.value <= 1.4
            assert value != was.value
        else:
            assert value == was.value


def test_all_that_identification_finds_is_drawn():
    drawn = {q.key for q in sources("unknown") if "drawn" in q.source}
    assert {"valve.backward.minimum_resistance", "hose.inertance", "boom.damping"} < drawn
    assert len(drawn) == 14
    assert not {key for key in drawn if key.startswith(("sensors", "manipulator", "end_stops"))}


def test_equal_seeds_are_one_machine_and_others_another():
    assert load_machine("unknown:7") == load_machine("unknown:7")
    assert load_machine("unknown").swing == load_machine("unknown:0").swing
    assert load_machine("unknown:7").swing != load_machine("unknown:8").swing


@pytest.mark.parametrize("name", ["unknown:x", "unknown:-1", "unknown:1:nix.yaml", "unknown:1:unknown"])
def test_a_seed_or_base_that_is_none_is_answered_with_what_is_allowed(name):
    with pytest.raises(MachineError, match="with SEED 0 "):
        load_machine(name)


def test_the_text_of_a_machine_is_its_file(tmp_path):
    numbers = {"hose.inertance": random_machine.Number(2.0, "Pa*s2/m3")}
    assert "hose:\n  inertance: {value: " in random_machine.text("unknown:1", numbers)
