"""The square that a newcomer drives along: which push is told first, when an edge counts, how it went."""

import pytest
from page_stand_in import Js

DRIVEN = """async (m, [places, more]) => {
  const { wayText } = await import("/web/exercise/words.js");
  let attempt = m.begun(m.squareAt([5, 0, 1]));
  return places.map(([x, y, z, pushed], i) => {
    attempt = m.after(attempt, [x, y, z], i, pushed ?? true);
    return [attempt.side, m.isDone(attempt) ? "done" : wayText(m.way(attempt, [x, y, z]), more?.fingers)];
  });
}"""
AWAY = "push the left stick away, or press W"
LEFT = "push the left stick left, or press A"
BACK = "push the left stick back, or press S"
RIGHT = "push the left stick right, or press D"
DOWN = "push the right stick down, or press ↓"
UP = "push the right stick up, or press ↑"


def test_a_corner_that_was_passed_counts_and_the_way_on_is_told_from_where_the_tip_is(js: Js) -> None:
    places = [(5.5, 0, 1), (5.9, 0.05, 1), (5.8, 1.1, 1), (4.9, 1.1, 1), (5, 0.05, 1)]
    assert js("exercise/square.js", DRIVEN, [places]) == [
        [0, f"{AWAY}: 0.3 m to go, then left without a stop."],
        [1, f"{LEFT}: 0.8 m to go, then back without a stop."],
        [2, f"{BACK}: 0.8 m to go, and right (left stick, D): 0.3 m beside the edge."],
        [3, f"{RIGHT}: 1.1 m to go."],
        [4, "done"],
    ]


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ((5.3, 0.14, 1.14), f"{AWAY}: 0.5 m to go, then left without a stop."),
        ((5.3, 0.2, 1), f"{AWAY}: 0.5 m to go, and right (left stick, D): 0.2 m beside the edge."),
        ((5.3, 0.2, 1.3), f"{AWAY}: 0.5 m to go, and down (right stick, ↓): 0.3 m too high."),
        ((5.3, -0.1, 0.8), f"{AWAY}: 0.5 m to go, and up (right stick, ↑): 0.2 m too low."),
        ((5.5, 0.0, 1.5), f"{DOWN}: 0.5 m too high, and away (left stick, W): 0.3 m to go."),
        ((5.5, 0.0, 0.5), f"{UP}: 0.5 m too low, and away (left stick, W): 0.3 m to go."),
        ((5.5, -0.6, 0.5), f"{LEFT}: 0.6 m beside the edge, and up (right stick, ↑): 0.5 m too low."),
        ((5.5, 0.6, 1.0), f"{RIGHT}: 0.6 m beside the edge, and away (left stick, W): 0.3 m to go."),
    ],
)
def test_the_largest_error_is_told_first_with_the_stick_and_the_key_that_mend_it(
    js: Js, place: tuple[float, float, float], said: str
) -> None:
    assert js("exercise/square.js", DRIVEN, [[place]]) == [[0, said]]


def test_who_has_no_keys_is_told_of_sticks_alone(js: Js) -> None:
    told = js("exercise/square.js", DRIVEN, [[(5.3, 0, 1.2)], {"fingers": True}])
    assert told == [[0, "push the left stick away: 0.5 m to go, and down (right stick): 0.2 m too high."]]


@pytest.mark.parametrize(
    ("off", "order"), [((0.0, 0.5), DOWN), ((0.0, -0.5), UP), ((0.5, 0.0), RIGHT), ((-0.5, 0.0), LEFT)]
)
def test_an_edge_does_not_count_for_who_passes_its_corner_far_off_until_the_tip_is_brought_back(
    js: Js, off: tuple[float, float], order: str
) -> None:
    aside, above = off
    is_side = aside != 0.0
    error = "beside the edge" if is_side else "too high" if above > 0 else "too low"
    places = [(5.7, aside, 1 + above), (5.9, aside, 1 + above), (5.9, 0.7 * aside, 1 + 0.7 * above)]
    before, passed, back = js("exercise/square.js", DRIVEN, [places])
    assert [before[0], passed[0], back[0]] == [0, 0, 1]
    assert passed[1] == f"{order}: 0.5 m {error}, then left without a stop."


def test_a_wrong_way_is_called_wrong_until_the_stick_is_let_go_or_the_tip_comes_back(js: Js) -> None:
    told = "then left without a stop."
    wrong = f"this is the wrong way: {AWAY}"
    places = [5.65, 5.6, 5.53, 5.5, 5.56]
    assert js("exercise/square.js", DRIVEN, [[(x, 0, 1) for x in places]]) == [
        [0, f"{AWAY}: 0.1 m to go, {told}"],
        [0, f"{AWAY}: 0.2 m to go, {told}"],
        [0, f"{wrong}: 0.3 m to go, {told}"],
        [0, f"{wrong}: 0.3 m to go, {told}"],
        [0, f"{AWAY}: 0.2 m to go, {told}"],
    ]
    # Let go: at rest, and while the tip still coasts; then pushed the right way, and once more the wrong one.
    let_go = [(5.65, True), (5.5, True), (5.5, False), (5.38, False), (5.4, True), (5.28, True)]
    found = js("exercise/square.js", DRIVEN, [[(x, 0, 1, pushed) for x, pushed in let_go]])
    assert [text.startswith("this is the wrong way") for _, text in found] == [
        *(False, True),
        *(False, False),
        *(False, True),
    ]


def test_the_wrong_way_is_told_before_a_larger_error(js: Js) -> None:
    places = [(5.7, 0, 1.6), (5.5, 0, 1.6)]
    _, (_, said) = js("exercise/square.js", DRIVEN, [places])
    wrong = f"this is the wrong way: {AWAY}"
    assert said == f"{wrong}: 0.3 m to go, and down (right stick, ↓): 0.6 m too high."


def test_a_square_is_only_for_sticks_that_move_the_tip_along_its_sides(js: Js) -> None:
    chosen = [[], ["ik_velocity", "cartesian"], ["joint", "cartesian"], ["coordinated", "cylindrical"]]
    found = "(m, chosen) => chosen.map((one) => m.movesTip(...one))"
    assert js("hands/moves.js", found, chosen) == [True, True, False, False]


def test_the_exercises_figure_says_what_it_is(js: Js) -> None:
    said = "(m, best) => m.resultText({ mean: 0.034, most: 0.2, seconds: 11.6 }, best)"
    told = "Done, in 12 s of motion: the tip was 3.4 cm from the edge on average, 20.0 cm at most."
    assert js("exercise/words.js", said) == told
    assert js("exercise/words.js", said, 0.021) == f"{told} Your best before: 2.1 cm."


def test_how_far_beside_the_square_the_tip_was_counts_its_way_and_no_time_in_which_it_stood(
    js: Js,
) -> None:
    steps = """(m) => {
      let attempt = m.begun(m.squareAt([5, 0, 1]));
      const drive = (x, y) => { attempt = m.after(attempt, [x, y, 1], (time += 0.1)); };
      let time = 0;
      const go = (x0, y0, x1, y1) => {
        for (let i = 1; i <= 40; i++) drive(x0 + ((x1 - x0) * i) / 40, y0 + ((y1 - y0) * i) / 40);
      };
      go(5, 0, 5.8, 0);
      go(5.8, 0, 5.8, 1.3);
      for (let i = 0; i < 1000; i++) drive(5.8 + 0.002 * (i % 2), 1.3);
      go(5.8, 1.3, 5.8, 0.8);
      go(5.8, 0.8, 5, 0.8);
      go(5, 0.8, 5, 0);
      return [m.isDone(attempt), m.result(attempt)];
    }"""
    done, found = js("exercise/square.js", steps)
    assert done
    assert found["most"] == pytest.approx(0.5, abs=0.01)
    along = 4 * 0.8 - 0.1  # the last corner is reached 0.1 m before it
    assert found["mean"] == pytest.approx(0.5**2 / (along + 2 * 0.5), rel=0.1)
    assert found["seconds"] == pytest.approx(5 * 4.0, rel=0.1)  # not the 100 s at the end of the second edge
