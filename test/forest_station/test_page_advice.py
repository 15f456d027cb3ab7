"""What the page tells beside the driving: a replay, a stop, a cycle, the recordings, on desktop and phone."""

import pytest
from page_stand_in import PageStandIn
from paused_page import wait

BAG = {"name": "mine", "bytes": 2000, "modified": 0, "seconds": 3}
TOLD = {"seconds": 3.0, "start": 0.0, "signals": [["x", "m"]], "events": [], "notes": []}
TOLD |= {"first": {"joint_states": 0.61}}  # [s]


def replayed(met: PageStandIn) -> None:
    """Have a bag replayed that the list names."""
    met.pages |= {"/bags.json": [BAG], "/bags/mine.json": TOLD | {"scene": {}}}
    page = met.page
    page.route("**/bags/mine/frames*", lambda route: route.fulfill(body=b"", content_type="text/plain"))
    page.get_by_role("button", name="Read the list again").click()
    page.get_by_role("button", name="Replay", exact=True).click()
    page.wait_for_selector("#replay_banner", state="visible")


def test_in_a_replay_the_page_says_how_to_drive_and_forgets_it_with_the_replay(met: PageStandIn) -> None:
    page, shown = met.page, "A replay is shown."
    replayed(met)
    met.tell_seat(deadman=("ready", ""))
    page.wait_for_selector(f"#message [data-tone=calm]:text-is('{shown} Press Back to live to drive.')")
    assert not page.get_by_role("button", name="Mark a square").is_visible()
    began = page.locator("#replay .time").inner_text()
    assert began.startswith("0.63 of 3.00 s")  # the first frame in which a crane is seen
    page.keyboard.down("Shift")
    page.clock.run_for(100)
    page.wait_for_selector(f"#message [data-tone=warn]:text-is('{shown} Let go of the left Shift key.')")
    page.keyboard.up("Shift")
    page.clock.run_for(100)
    page.get_by_role("button", name="Back to live").click()
    page.wait_for_selector("#message :text-is('Hold the left Shift key, then move a stick.')")
    assert page.get_by_role("button", name="Mark a square").is_visible()


def test_after_a_reset_the_line_is_calm(met: PageStandIn) -> None:
    met.page.keyboard.down("Shift")
    wait(met, lambda hands: hands.held)
    met.page.keyboard.press("Escape")
    met.page.keyboard.up("Shift")
    met.tell("emergency_stop", active=True, sources=[{"name": "controller", "state": "stopped"}])
    met.page.clock.run_for(400)
    met.tell("emergency_stop", active=False, sources=[])
    met.tell_seat(deadman=("ready", ""))
    hint = "Hold the left Shift key, then move a stick."
    met.page.wait_for_selector(f"#message [data-tone=calm]:text-is('{hint}')")


def test_a_cycle_that_waits_is_no_reason_to_move_a_stick(met: PageStandIn) -> None:
    told = {"there": True, "cycle": "mine", "segment": "out", "text": ""}
    met.tell_seat(deadman=("ready", ""))
    for phase, said in (
        ("waiting", ", and leave the sticks alone: the cycle goes on."),
        ("idle", ", then move a stick."),
    ):
        met.tell("taught_work", phase=phase, **told)
        met.page.wait_for_selector(f"#message :text-is('Hold the left Shift key{said}')")


def test_on_a_phone_a_replay_is_seen_where_the_drawer_was(phone: PageStandIn) -> None:
    phone.rest()
    page, drawer = phone.page, phone.page.locator("#drawer-button")
    if drawer.inner_text() == "Instruments":
        drawer.click()
    assert drawer.inner_text() == "Crane"
    replayed(phone)
    assert drawer.inner_text() == "Instruments"
    page.get_by_role("button", name="Back to live").click()
    page.wait_for_selector("#replay_banner", state="hidden")


# The end of the exercise, and both of its buttons.
DONE = """async () => {
  const { resultText } = await import("/web/exercise/words.js");
  const panel = document.querySelector("#first_minute");
  const [text, acts] = [panel.querySelector("p"), [...panel.querySelectorAll("button")]];
  const before = [text.textContent, acts.map(({ hidden }) => hidden)];
  text.textContent = resultText({ mean: 0.105, most: 0.182, seconds: 108 }, 0.123);
  for (const act of acts) act.hidden = false;
  acts[0].textContent = "Mark another square";
  const cut = text.scrollHeight > text.clientHeight + 1;
  text.textContent = before[0];
  acts.forEach((act, i) => (act.hidden = before[1][i]));
  return cut;
}"""


@pytest.mark.usefixtures("sized")
@pytest.mark.parametrize("sized", [(1280, 800), (900, 600), (390, 844), (844, 390)], indirect=True)
def test_the_result_of_the_exercise_is_not_cut_off_by_its_buttons(met: PageStandIn) -> None:
    assert not met.page.evaluate(DONE)


def test_a_recording_is_told_once_while_it_runs_and_when_it_has_ended(met: PageStandIn) -> None:
    panel, told = met.page.locator("#recording"), {"name": "mine", "seconds": 3, "bytes": 2000, "hears": True}
    met.page.get_by_role("button", name="Record", exact=True).click()
    met.page.clock.run_for(100)
    assert met.asked[-1]["do"] == "start_recording"
    for active, text in ((True, "recording to mine"), (False, "recorded 9 messages, 3 topics, lost 0: mine")):
        met.tell("recording", active=active, text=text, **told)
        met.page.wait_for_selector("#recording .state:text('mine')")
        assert panel.inner_text().count("mine") == 1 + ("mine" in panel.locator(".bags").inner_text())
        assert "done" not in panel.inner_text()  # the answer


def test_older_recordings_are_told_of_and_found_by_words_of_their_name_and_date(met: PageStandIn) -> None:
    page, hour = met.page, 3600
    bags = [BAG | {"name": f"shift_{i}", "modified": hour * (5000 - i)} for i in range(312)]
    met.pages["/bags.json"] = bags
    page.get_by_role("button", name="Read the list again").click()
    page.wait_for_selector(
        "#recording .found:text-is('These are the newest 50 of 312: search for the others.')"
    )
    search, names = page.get_by_label("Search the recordings"), page.locator("#recording li .name")
    assert names.count() == 50
    search.fill("SHIFT_311 1970")
    assert names.all_inner_texts() == ["shift_311"]
    assert not page.locator("#recording .found").inner_text()
    search.fill("monday's")
    page.wait_for_selector("#recording .found:text('None of 312 recordings has')")
    search.fill("")
    met.pages["/bags.json"] = []
    page.get_by_role("button", name="Read the list again").click()
    page.wait_for_selector("#recording .found:text-is('There is no recording yet.')")
    assert not search.is_visible()


def test_the_stops_button_crosses_out_the_space_bar_where_it_writes(met: PageStandIn) -> None:
    page, crossed = met.page, met.page.locator("#emergency_stop kbd[data-off]")
    keys = "() => document.querySelector('.stop').getAttribute('aria-keyshortcuts')"
    field = page.get_by_label("Name of the recording")
    for focused, off in (
        (field, ["space"]),
        (page.get_by_role("button", name="Mark a square"), []),
        (field, ["space"]),
    ):
        focused.focus()
        assert crossed.all_inner_texts() == off
        assert page.evaluate(keys) == ("Escape" if off else "Escape Space")
    page.keyboard.press("Space")
    assert field.input_value() == " "
    field.fill("")
    field.blur()
    assert crossed.count() == 0
    assert met.asked == []


@pytest.mark.usefixtures("sized")
@pytest.mark.parametrize("sized", [(1000, 640)], indirect=True)
def test_the_figure_of_the_drawing_and_the_legend_do_not_lie_over_each_other(met: PageStandIn) -> None:
    overlaps = """async () => {
      const { legend, rateText } = await import("/web/scene/overlay.js");
      const rate = document.createElement("button");
      Object.assign(rate, { className: "rate", textContent: rateText(1, 0.3) });
      const lines = legend();
      lines.open = true;
      document.querySelector("#scene").append(lines, rate);
      const [a, b] = [lines, rate].map((one) => one.getBoundingClientRect());
      lines.remove();
      rate.remove();
      return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
    }"""
    assert not met.page.evaluate(overlaps)
