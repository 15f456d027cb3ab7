"""The file of a cycle: what is written is read, and what is not allowed is named with its segment."""

import numpy as np
import pytest
import yaml

from forest_control.config.setting_file import SettingFileError
from forest_control.taught.cycle import CONFIRMATION, Cycle, Grapple, Path, Pose
from forest_control.taught.cycle_file import file_of, load_cycle, names, save_cycle, text_of

AWKWARD = ("it's: a [name]", "# no comment", "yes", "12", "λ  two  spaces")


def random_cycle(seed):
    rng = np.random.default_rng(seed)

    def place():
        return tuple(round(x, 4) for x in rng.uniform(-7.0, 7.0, 3).tolist())

    def segment(n):
        name, speed = f"{AWKWARD[n % len(AWKWARD)]} {n}", round(float(rng.uniform(0.1, 1.0)), 3)
        kinds = (
            Pose(name, place(), speed),
            Path(name, tuple(place() for _ in range(rng.integers(2, 9))), speed),
            Grapple(name, "open", CONFIRMATION),
            Grapple(name, "close", round(float(rng.uniform(0.1, 9.0)), 2)),
        )
        return kinds[rng.integers(len(kinds))]

    return Cycle("random", tuple(segment(n) for n in range(rng.integers(0, 8))), AWKWARD[seed % 5])


def squeezed(cycle):
    """A cycle with the spaces of its names as a file has them."""
    segments = tuple(one._replace(name=" ".join(one.name.split())) for one in cycle.segments)
    return cycle._replace(segments=segments, description=" ".join(cycle.description.split()))


@pytest.mark.parametrize("seed", range(20))
def test_what_is_written_is_read_again(seed, tmp_path):
    cycle = random_cycle(seed)
    save_cycle(cycle, tmp_path)
    assert load_cycle("random", tmp_path) == squeezed(cycle)
    assert [path.name for path in tmp_path.iterdir()] == ["random.yaml"]


@pytest.mark.parametrize("name", ["\N{MAN}\N{ZERO WIDTH JOINER}\N{EAR OF RICE}", "a\x07b", "\ufffe", ""])
def test_what_could_not_be_read_again_does_not_replace_a_file(name, tmp_path):
    kept = Cycle("load", (Pose("out", (5.5, 1.5, 0.5), 0.3),))
    save_cycle(kept, tmp_path)
    with pytest.raises(SettingFileError, match=r"cycle .*load"):
        save_cycle(kept.with_segment(Pose(name, (5.0, 0.0, 1.0), 0.3)), tmp_path)
    assert load_cycle("load", tmp_path) == kept
    assert [path.name for path in tmp_path.iterdir()] == ["load.yaml"]


def test_half_a_character_becomes_readable(tmp_path):
    save_cycle(Cycle("load", (), "\ud800"), tmp_path)
    assert load_cycle("load", tmp_path).description == r"\ud800"


def test_a_file_that_is_saved_again_does_not_change():
    text = text_of(random_cycle(3))
    assert text == text_of(random_cycle(3))
    assert text.startswith("# Places of the tip in m")


GOOD = {"name": "go", "pose": [5.0, 0.0, 1.0], "speed": 0.3}


@pytest.mark.parametrize(
    ("segment", "sentence"),
    [
        (GOOD | {"speed": 9}, r"segment 'go': speed is 9; allowed: 0.02 \.\. 3 m/s"),
        (GOOD | {"pose": [5.0, 0.0]}, r"segment 'go': pose is \[5.0, 0.0\]; allowed: three numbers"),
        (GOOD | {"pose": [5.0, 0.0, "up"]}, r"segment 'go': pose is 'up'; allowed: -1000 \.\. 1000 m"),
        (GOOD | {"pose": [5.0, 0.0, float("nan")]}, r"pose is nan"),
        (GOOD | {"wait": 1}, r"segment 'go': unknown key 'wait'; allowed: name, pose, speed"),
        (GOOD | {"path": []}, r"segment 1: .*; allowed: a mapping with one of pose, path, grapple"),
        ({"name": "go"}, r"segment 1: .*; allowed: a mapping with one of"),
        ({"name": 3, "pose": [5, 0, 1]}, r"segment 1: name is 3; allowed: a text"),
        ({"path": [[5, 0, 1]]}, r"segment 'segment 1': a path needs two or more points"),
        ({"path": 7}, r"path is 7; allowed: a list of points"),
        ({"path": [[0, 0, 0], [300, 0, 0]]}, r"the path is longer than 200 m"),
        ({"grapple": "shake"}, r"grapple is 'shake'; allowed: close, open"),
        ({"grapple": "open", "wait": -1}, r"wait is -1; allowed: confirmation, or 0.1 \.\. 600 s"),
        ("nonsense", r"segment 1: 'nonsense'; allowed"),
    ],
)
def test_what_is_not_allowed_is_named_with_its_segment(segment, sentence, tmp_path):
    (tmp_path / "bad.yaml").write_text(yaml.safe_dump({"segments": [segment]}))
    with pytest.raises(SettingFileError, match=f"cycle 'bad': .*{sentence}"):
        load_cycle("bad", tmp_path)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("[1]", r"allowed: a mapping of description, segments"),
        ("segments: 3", r"segments: 3; allowed: a list"),
        ("segment: []", r"allowed: a mapping of description, segments"),
        ("a: [", r"not YAML"),
        (yaml.safe_dump({"segments": [GOOD, GOOD]}), r"two segments are named 'go'"),
    ],
)
def test_a_file_that_is_none_is_refused_in_one_sentence(text, sentence, tmp_path):
    (tmp_path / "bad.yaml").write_text(text)
    with pytest.raises(SettingFileError, match=sentence) as refused:
        load_cycle("bad", tmp_path)
    assert "\n" not in str(refused.value)


def test_an_own_cycle_hides_the_shipped_one_of_its_name_and_is_listed_once(tmp_path):
    assert load_cycle("transport", tmp_path).segments
    save_cycle(Cycle("transport", (Pose("mine", (5.0, 0.0, 1.0), 0.3),)), tmp_path)
    assert load_cycle("transport", tmp_path).segments[0].name == "mine"
    assert names(tmp_path) == ("reach-grasp", "transport")


@pytest.mark.parametrize("name", ["", "../up", "a b", ".hidden", "a" * 65])
def test_a_name_that_would_lead_elsewhere_is_refused(name, tmp_path):
    with pytest.raises(SettingFileError, match="allowed: a name of letters"):
        file_of(name, tmp_path)


def test_a_cycle_that_is_not_there_names_those_that_are(tmp_path):
    with pytest.raises(SettingFileError, match="allowed: reach-grasp, transport"):
        load_cycle("none", tmp_path)


def test_a_segment_that_is_added_gets_a_name_of_its_own():
    cycle = Cycle("twice")
    for _ in range(3):
        cycle = cycle.with_segment(Grapple("grasp", "close"))
    assert [one.name for one in cycle.segments] == ["grasp", "grasp 2", "grasp 3"]
