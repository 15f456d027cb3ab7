"""What is recorded follows from names alone."""

import pytest

from forest_bag.record.topic_choice import ChoiceError, TopicChoice

GRAPH = ("/joy", "/joint_states", "/events", "/rosout", "/crane_2/joy", "/_hidden/x", "/other/thing")


def chosen(namespace="/", **options):
    def resolve(name):
        return name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"

    choice = TopicChoice(resolve, namespace, **options)
    return [name for name in GRAPH if choice.wants(name)]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, ["/joy", "/joint_states", "/events", "/rosout", "/crane_2/joy", "/other/thing"]),
        ({"topics": ["joy", "/_hidden/x"]}, ["/joy", "/_hidden/x"]),
        ({"regex": "jo"}, ["/joy", "/joint_states", "/crane_2/joy"]),
        ({"topics": ["rosout"], "regex": "^/joy$"}, ["/joy", "/rosout"]),
        ({"regex": "jo", "excluded": ["/joy"]}, ["/joint_states", "/crane_2/joy"]),
        ({"regex": "jo", "excluded": ["/joy$"]}, ["/joint_states"]),
        ({"namespace": "/crane_2"}, ["/rosout", "/crane_2/joy"]),
        ({"namespace": "/crane_2", "everything": True, "excluded": [".*ro.*"]},
         ["/joy", "/joint_states", "/events", "/crane_2/joy", "/other/thing"]),
    ],
)  # fmt: skip
def test_names_expressions_and_namespace_choose(options, expected):
    assert chosen(**options) == expected


@pytest.mark.parametrize("options", [{"regex": "("}, {"excluded": ["*joy"]}])
def test_a_broken_expression_is_named(options):
    with pytest.raises(ChoiceError, match="is not a regular expression"):
        chosen(**options)
