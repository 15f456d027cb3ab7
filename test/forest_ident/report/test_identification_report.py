"""The page of an identification: its numbers, its text escaped, nothing beside it."""

import re

import pytest

from forest_description.machine import load_machine
from forest_ident.estimators.calibration import Offset
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.refinement.result import Result
from forest_ident.report import identification_report
from forest_ident.validation.verdict import BUT_FOR, Verdict

C180 = load_machine("c180_hoses")


@pytest.fixture
def page(tmp_path):
    key = "valve.deadband_voltage"
    estimate = Estimate(key, 1.01, 0.01, "V", 12.34, "output error", positive=False)
    result = Result(C180, C180, {key: estimate})
    result.linear = [estimate]
    stick = "manipulator.stick_mass"
    result.told = {stick: Estimate(stick, 560.0, 9.0, "kg", 12.34, "output error", False, stated=0.5)}
    result.remarks = ["a remark with <b> & more"]
    result.calibration = [Offset("supply_pressure", 1234.5, 20.0, "Pa")]
    judged = Verdict(BUT_FOR, (), {key: "a reason <of> its own"})
    bags = {"bags/mine/valve": "valve"}
    file = identification_report.write(result, tmp_path / "report", judged, [], "mine.yaml", bags)
    return file.read_text("utf-8")


def rows(page):
    """The cells of every row of every table."""
    plain = page.replace("<wbr>", "").replace(' class="words"', "")
    return [re.findall(r"<t[dh]>(.*?)</t[dh]>", row) for row in re.findall(r"<tr>(.*?)</tr>", plain)]


def test_an_estimate_stands_beside_the_start_with_its_interval(page):
    found = ["1", "1.01", "V", "+1.00", "0.9904 .. 1.0296", "0 ", "12.3", "output error"]
    assert ["valve.deadband_voltage", *found] in rows(page)
    assert ["valve.deadband_voltage", "1.01", "0.01", "12.3", "output error"] in rows(page)


def test_a_stated_number_stands_there_as_the_records_have_it(page):
    found = ["544.32", "560", "kg", "+2.88", "542.36 .. 577.64", "50 ", "12.3", "output error"]
    assert ["manipulator.stick_mass", *found] in rows(page)


def test_a_sensor_has_an_offset_and_no_gain_that_was_not_estimated(page):
    assert ["supply_pressure", "1234 ± 39 Pa", "-"] in rows(page)


def test_text_is_escaped_and_missing_records_are_said(page):
    assert '<p class="warning">a remark with &lt;b&gt; &amp; more</p>' in page
    assert "hose.inertance: as stated; it takes steps of flow" in page
    assert "Nothing was held out" in page
    assert "<link" not in page
    assert "<script" not in page


def test_the_verdict_comes_first_then_date_start_versions_and_bags(page):
    places = [page.index(text) for text in ("Verdict: trusted but for valve.deadband_voltage", "<table>")]
    assert places == sorted(places)
    assert "valve.deadband_voltage: a reason &lt;of&gt; its own" in page
    assert re.search(r"made 20\d\d-\d\d-\d\d \d\d:\d\d UTC, start mine\.yaml, forest crane \d", page)
    assert ["bags/mine/valve", "valve"] in rows(page)


def test_a_page_prints_on_a4_and_says_its_language(page):
    """A number is never broken in two; a key is, after its points and underscores."""
    assert "@page { size: A4" in page
    assert "td { white-space: nowrap }" in page
    assert '<td class="words">valve.<wbr>deadband_<wbr>voltage</td>' in page
    assert '<html lang="en">' in page
