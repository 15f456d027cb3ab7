"""The reference bags are what their nodes still say, and small."""

from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from forest_study.demo import reference_bags

BAGS = Path(__file__).resolve().parents[1] / "bags"
REPLAYED = {
    "coordinated": ("controller", "valve_driver"),
    "valves": ("valve_driver",),
    "fault": ("simulator",),
}
# Another processor, or another C library, may round a sine otherwise; a changed gain shows all the same.
TOLERANCE = "1e-6"


@pytest.mark.parametrize("name", reference_bags.NAMES)
def test_a_reference_bag_replayed_is_itself(name, tmp_path, domain_id, start_process):
    options = ("--nodes", *REPLAYED[name], "--tolerance", TOLERANCE, "--out", str(tmp_path / "out"))
    replay = start_process(["-m", "forest_study.cli", "replay", str(BAGS / name), *options])
    assert replay.ended() == 0, f"{replay.text()}\nmeant to change? `scripts/bags.sh` makes the bags anew"


def test_the_reference_bags_are_under_3_mb_together_and_name_no_directory_of_their_maker():
    files = [file for name in reference_bags.NAMES for file in (BAGS / name).iterdir()]
    assert sum(file.stat().st_size for file in files) < 3_000_000
    assert not [
        file for file in files for place in (b"/home/", b"/root/", b"/tmp/") if place in file.read_bytes()
    ]
