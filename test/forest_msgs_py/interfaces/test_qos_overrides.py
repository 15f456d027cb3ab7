"""Claims about QoS overrides: the files that rosbag2 takes, and what is wrong with others."""

import pytest

from forest_msgs_py.interfaces.qos_overrides import QosOverrideError, read_overrides
from forest_msgs_py.interfaces.qos_profiles import Qos

DOCUMENTED = """
/topic_name:
  history: keep_last
  depth: 10
  reliability: reliable
  durability: volatile
  deadline:
    # unspecified/infinity
    sec: 0
    nsec: 0
  lifespan:
    sec: 0
    nsec: 0
  liveliness: system_default
  liveliness_lease_duration:
    sec: 0
    nsec: 0
  avoid_ros_namespace_conventions: false
/other:
  reliability: best_effort
  durability: transient_local
  history: keep_all
  lifespan: {sec: 1, nsec: 5}
  depth: 3
/empty: {}
"""


@pytest.fixture
def file(tmp_path):
    return tmp_path / "qos.yaml"


def test_the_example_of_rosbag2s_documentation_is_ros_default(file):
    file.write_text(DOCUMENTED)
    overrides = read_overrides(file)
    assert overrides["/topic_name"] == overrides["/empty"] == Qos()
    assert overrides["/other"] == Qos(3, True, False, True, lifespan_ns=1_000_000_005)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("- 1", "allowed: a mapping of topics to QoS profiles"),
        ("/a: 1", "/a is 1; allowed: a mapping of history"),
        ("/a: {speed: 1}", "/a: unknown key 'speed'; allowed: history, reliability"),
        (
            "/a: {reliability: maybe}",
            "reliability is 'maybe'; allowed: system_default, reliable, best_effort",
        ),
        ("/a: {reliability: 1}", "reliability is 1; allowed"),
        ("/a: {depth: -1}", "depth is -1; allowed: a whole number of 0 or more"),
        ("/a: {depth: true}", "depth is True; allowed"),
        ("/a: {lifespan: 1}", "lifespan is 1; allowed: sec and nsec, 0 or more"),
        ("/a: {deadline: {sec: 1}}", "allowed: sec and nsec"),
        ("/a: {avoid_ros_namespace_conventions: 1}", "is 1; allowed: true or false"),
        ("a: [", "is not YAML"),
    ],
)
def test_what_is_wrong_is_said(file, text, said):
    file.write_text(text)
    with pytest.raises(QosOverrideError) as refused:
        read_overrides(file)
    assert said in str(refused.value)
    assert str(file) in str(refused.value)
