"""Taught work on the operator's page, in a real browser: what is shown, offered and asked for."""

import re
from collections.abc import Iterator
from typing import Any

import pytest
from browser import new_page
from page_stand_in import PageStandIn
from playwright.sync_api import Browser, expect

SIGNALS = tuple((f"cycle/status/{name}", "m") for name in ("way", "length", "away"))
PATH = {"name": "out", "kind": "path", "speed": 0.4, "wait": None, "text": "2.77 m, 10 s", "end": [5, 1, 0]}
TAKE = {"name": "take", "kind": "grapple", "speed": None, "wait": 0, "text": "grapple close", "end": None}
LOAD = {"name": "load", "segments": [PATH, TAKE], "line": [[5, 0, 0], [5, 1, 0]], "trouble": ""}
FAR = LOAD | {"name": "far", "segments": [], "line": [], "trouble": "Segment 'away': out of reach."}


@pytest.fixture(scope="module")
def opened(browser: Browser) -> Iterator[PageStandIn]:
    """The page of a station whose node knows two cycles."""
    page, errors = new_page(browser, viewport={"width": 1280, "height": 1400})
    met = PageStandIn(page, SIGNALS)
    met.pages = {
        "/cycles.json": [{"name": "far", "own": True}, {"name": "load", "own": True}],
        "/cycles/load.json": LOAD,
        "/cycles/far.json": FAR,
    }
    met.open()
    yield met
    page.context.close()
    assert [error for error in errors if "404" not in error] == []  # the stand-in has no scene and no bags


@pytest.fixture
def met(opened: PageStandIn) -> PageStandIn:
    """The page of the driver, with the cycle chosen and nothing played."""
    opened.tell_seat()
    tell(opened)
    opened.page.get_by_label("Cycle", exact=True).select_option("load")
    opened.page.wait_for_selector("#taught_work .segments li")
    opened.asked.clear()
    return opened


def tell(
    met: PageStandIn, phase: str = "idle", text: str = "", segment: str = "", there: bool = True
) -> None:
    cycle = "load" if segment else ""
    met.tell("taught_work", there=there, phase=phase, cycle=cycle, segment=segment, text=text)


def offered(met: PageStandIn) -> list[str]:
    """What can be pressed."""
    return met.page.locator("#taught_work .line button:enabled").all_inner_texts()


def says(met: PageStandIn, text: str) -> None:
    expect(met.page.locator("#taught_work .state")).to_contain_text(text)


def press(met: PageStandIn, button: str) -> dict[str, Any]:
    """Press a button of the panel; return what was asked for."""
    count = len(met.asked)
    met.page.locator("#taught_work").get_by_role("button", name=button, exact=True).click()
    expect(met.page.locator("#taught_work .answer")).not_to_be_empty()
    (asked,) = met.asked[count:]
    return {key: value for key, value in asked.items() if key != "number"}


def test_without_its_node_the_panel_says_how_to_start_one(met: PageStandIn) -> None:
    tell(met, text="Start the graph with scripts/graph.sh --cycles DIR.", there=False)
    says(met, "Start the graph with scripts/graph.sh --cycles DIR.")
    expect(met.page.get_by_label("Cycle", exact=True)).to_be_hidden()


def test_a_cycle_is_chosen_and_played_and_what_cannot_be_played_says_why(met: PageStandIn) -> None:
    assert met.page.locator("#taught_work summary").all_inner_texts()[:2] == [
        "out 2.77 m, 10 s",
        "take grapple close",
    ]
    assert press(met, "Play") == {"do": "play_cycle", "cycle": "load"}
    met.page.get_by_label("Cycle", exact=True).select_option("far")
    expect(met.page.locator("#taught_work .trouble")).to_have_text("Segment 'away': out of reach.")


@pytest.mark.parametrize(
    ("phase", "text", "said", "buttons", "asks"),
    [
        ("waiting", "…", "load: centre the sticks and hold the deadman.", ["Pause", "End"], "pause_cycle"),
        ("running", "", "load: out. Any stick pauses it.", ["Pause", "End"], "pause_cycle"),
        (
            "paused",
            "load: paused: a stick moved.",
            "a stick moved. To go on: Resume",
            ["Resume", "End"],
            "resume_cycle",
        ),
        (
            "holding",
            "load: take: grapple close, until a person confirms",
            "load: take: grapple close. Press Confirm when it has.",
            ["Confirm", "End"],
            "resume_cycle",
        ),
        ("recording", "…", "Hold the deadman and drive", ["Keep the path"], "stop_cycle"),
        ("finished", "", "load is finished.", ["Play"], "play_cycle"),
    ],
)
def test_each_phase_is_told_and_offers_what_can_be_done(
    met: PageStandIn, phase: str, text: str, said: str, buttons: list[str], asks: str
) -> None:
    tell(met, phase, text, "out")
    says(met, said)
    assert offered(met) == buttons
    assert press(met, buttons[0])["do"] == asks


def test_a_simulated_grapple_is_said_to_be_worked_elsewhere_and_one_with_a_time_needs_nobody(
    met: PageStandIn,
) -> None:
    asked, timed = "load: take: grapple close, until a person confirms", "load: take: grapple close, for 2 s"
    for signals, text, said in (
        (SIGNALS, asked, "load: take: grapple close. Press Confirm when it has."),
        (
            (*SIGNALS, ("ground_truth/load/mass", "kg")),
            asked,
            "worked in Load, by Grasp a log and Drop it. Press",
        ),
        (SIGNALS, timed, timed),
    ):
        met.tell("welcome", you="operator 1", signals=signals)
        tell(met, "holding", text, "take")
        says(met, said)
    assert "Confirm" not in met.page.locator("#taught_work .state").inner_text()


def test_an_answer_is_over_when_something_else_goes_on(met: PageStandIn) -> None:
    tell(met, "paused", "load: paused: a stick moved.", "out")
    assert press(met, "Resume")["do"] == "resume_cycle"
    tell(met, "finished", segment="out")
    expect(met.page.locator("#taught_work .answer")).to_be_hidden()  # it is empty


def test_a_step_without_a_cycle_asks_for_one_where_it_is_named(met: PageStandIn) -> None:
    page = met.page
    page.get_by_label("Cycle", exact=True).select_option("")
    page.locator("#taught_work .teach summary").click()
    field = page.get_by_label("Cycle that is taught")
    page.get_by_role("button", name="Pose here").click()
    asked = "(field) => [field.validationMessage, document.activeElement === field]"
    assert field.evaluate(asked) == ["Name a cycle here, or choose one above.", True]
    assert met.asked == []
    field.fill("new")
    assert press(met, "Pose here")["cycle"] == "new"
    page.locator("#taught_work .teach summary").click()


def test_who_looks_on_pauses_and_ends_but_neither_plays_nor_teaches(met: PageStandIn) -> None:
    met.tell_seat(driver="operator 2")
    expect(met.page.get_by_role("button", name="Play", exact=True)).to_be_disabled()
    met.page.locator("#taught_work .teach summary").click()
    expect(met.page.get_by_role("button", name="Pose here")).to_be_disabled()
    met.page.locator("#taught_work .teach summary").click()
    for phase, buttons in (("paused", ["End"]), ("running", ["Pause", "End"])):
        tell(met, phase, segment="out")
        expect(met.page.locator("#taught_work .line button:enabled")).to_have_text(buttons)


def test_the_segment_that_is_played_stands_out_and_the_way_is_told(met: PageStandIn) -> None:
    tell(met, "running", segment="out")
    met.send_frame(1, 1.0, [0.5, 2.77, 0.0021])
    expect(met.page.locator("#taught_work li[data-current] .name")).to_have_text("out")
    expect(met.page.locator("#taught_work .progress")).to_have_text("0.50 of 2.77 m, 2 mm beside the path")


def test_a_step_is_taught_at_the_end_of_a_new_cycle(met: PageStandIn) -> None:
    met.page.locator("#taught_work .teach summary").click()
    met.page.get_by_label("Cycle that is taught").fill("new")
    met.page.get_by_label("Name of the step").fill("home")
    asked = press(met, "Pose here")
    assert asked == {"do": "teach", "cycle": "new", "what": "pose", "label": "home"}
    expect(met.page.get_by_label("Cycle that is taught")).to_be_empty()  # from here on it is the chosen one
    met.page.get_by_label("Cycle", exact=True).select_option("load")
    asked = press(met, "Path from here")
    assert asked == {"do": "teach", "cycle": "load", "what": "path", "label": ""}
    met.page.locator("#taught_work .teach summary").click()


def test_a_segment_is_renamed_changed_moved_and_deleted(met: PageStandIn) -> None:
    met.page.locator("#taught_work li summary").first.click()
    out = {"cycle": "load", "segment": "out"}
    met.page.get_by_label("name", exact=True).first.fill("reach")
    met.page.get_by_label("m/s").fill("0.25")
    asked = press(met, "Save")
    assert asked == {"do": "change_segment", "changes": {"name": "reach", "speed": 0.25}, **out}
    assert press(met, "Later") == {"do": "move_segment", "by": 1, **out}
    assert press(met, "Delete") == {"do": "delete_segment", **out}
    met.page.locator("#taught_work li summary").first.click()
    met.page.locator("#taught_work li summary").last.click()
    asked = press(met, "Save")
    assert asked["changes"] == {"name": "take", "wait": "confirmation"}
    met.page.locator("#taught_work li summary").last.click()


def test_a_refusal_is_shown_in_the_nodes_own_words(met: PageStandIn) -> None:
    met.refusals["play_cycle"] = "load: the tip cannot go there."
    press(met, "Play")
    expect(met.page.locator("#taught_work .answer[data-ok=false]")).to_have_text(
        re.compile("cannot go there")
    )
