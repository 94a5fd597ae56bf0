"""An operator's attempts in the browser: record, scrub, undo, branch, compare, choose, commit and export."""

from __future__ import annotations

import io
import json

import numpy as np
import pandas
import pytest

from .waiting import is_still, wait_for

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("browser")]

PLACES = np.array([[3.4, 0.1], [4.0, -0.1], [4.6, 0.3]])


def names(planner):
    return list(planner.loop.history.names)


def record(page, planner, places):
    """Record an attempt through places by dragging the target, and give its name."""
    before = names(planner)
    page.find("#record").click()
    wait_for(lambda: planner.loop.frame.recording)
    wait_for(lambda: page.text(".clock").startswith("recording "))
    for place in places:
        page.drag(planner.loop.frame.position, place)
        wait_for(lambda: is_still(planner))
    page.find("#record").click()
    wait_for(lambda: len(names(planner)) > len(before))
    return next(name for name in names(planner) if name not in before)


def scrub(page, time):
    page.find("#scrub").evaluate(
        """(bar, time) => {
            bar.value = time;
            for (const name of ["input", "change"]) bar.dispatchEvent(new Event(name));
        }""",
        time,
    )


@pytest.fixture(scope="module")
def first(shared_page, planner):
    return record(shared_page, planner, PLACES)


def cell(page, name, column):
    """The text of a cell of the table."""
    heads = [head.split("\n")[0].strip() for head in page.find(".attempts th").all_inner_texts()]
    k = next((k for k, head in enumerate(heads) if head.startswith(column)), None)
    if k is None:  # the table is not there yet
        return ""
    return page.find(f'tr[data-attempt="{name}"] td').nth(k).inner_text().replace("−", "-")


def test_the_transport_stands_at_the_end_of_what_was_recorded(page, planner, first):
    duration = planner.loop.history[first].duration
    wait_for(lambda: abs(float(page.find("#scrub").input_value()) - duration) < 1e-2)
    assert page.text(".clock") == f"{duration:.2f} / {duration:.2f} s"


def test_what_was_recorded_is_in_the_table_with_its_measures(page, planner, first):
    attempt = planner.loop.history[first]
    assert len(attempt) > 30
    wait_for(lambda: cell(page, first, "path") not in ("", "–"))
    tips = np.array([planner.arm.robot.position(q) for q in attempt.configurations])
    length = np.linalg.norm(np.diff(tips, axis=0), axis=1).sum()
    assert float(cell(page, first, "path")) == pytest.approx(length, rel=0.01)
    assert float(cell(page, first, "time")) == pytest.approx(attempt.duration, rel=0.01)


def test_an_attempt_is_scrubbed_and_left(page, planner, first):
    attempt = planner.loop.history[first]
    live = planner.loop.frame.q.copy()  # the self-motion may not have settled
    time = 0.4 * attempt.duration
    scrub(page, time)
    wait_for(lambda: planner.loop.frame.mode == "scrubbing")
    shown = planner.loop.frame.shown[1]
    assert shown == pytest.approx(time, abs=0.05)
    np.testing.assert_allclose(planner.loop.frame.q, attempt.configurations[attempt.index(shown)], atol=1e-9)
    wait_for(lambda: np.allclose(page.js("() => [...planner.state.frame.q]"), planner.loop.frame.q, atol=1e-5))
    page.find("#live").click()
    wait_for(lambda: planner.loop.frame.mode == "live")
    np.testing.assert_allclose(planner.loop.frame.q, live, atol=0.1)
    assert np.abs(attempt.configurations[attempt.index(shown)] - live).max() > 0.2


def test_an_attempt_is_played_and_paused(page, planner, first):
    scrub(page, 0)
    page.find("#play").click()
    wait_for(lambda: planner.loop.frame.mode == "playing")
    wait_for(lambda: planner.loop.frame.shown[1] > 0.3)
    page.find("#play").click()
    wait_for(lambda: planner.loop.frame.mode == "paused")
    page.find("#live").click()
    wait_for(lambda: planner.loop.frame.mode == "live")


def test_a_branch_shares_the_way_up_to_it(page, planner, first):
    parent = planner.loop.history[first]
    scrub(page, 0.5 * parent.duration)
    wait_for(lambda: planner.loop.frame.mode == "scrubbing")
    page.find("#branch").click()
    wait_for(lambda: planner.loop.frame.recording)
    page.drag(planner.loop.frame.position, planner.loop.frame.position + np.array([0.2, -0.5]))
    wait_for(lambda: is_still(planner))
    page.find("#record").click()
    wait_for(lambda: len(names(planner)) == 2)
    child = planner.loop.history[names(planner)[1]]
    assert child.parent == first
    shared = child.times <= child.branched_at
    assert shared.sum() > 10
    assert not shared.all()
    np.testing.assert_array_equal(child.configurations[shared], parent.configurations[: shared.sum()])


def test_undo_goes_on_from_a_posture_of_the_attempt(page, planner, first):
    attempt = planner.loop.history[first]
    page.find(f'tr[data-attempt="{first}"] .name').click()
    scrub(page, 0.3 * attempt.duration)
    wait_for(lambda: planner.loop.frame.mode == "scrubbing")
    posture, target = planner.loop.frame.q.copy(), planner.loop.frame.position.copy()
    page.find("#undo").click()
    wait_for(lambda: planner.loop.frame.mode == "live")
    np.testing.assert_allclose(planner.loop.frame.position, target, atol=1e-9)
    assert np.abs(planner.loop.frame.q - posture).max() < 0.2
    assert first in names(planner), "the attempt stays"


def test_attempts_are_compared_overlaid_and_chosen(page, planner, first):
    both = names(planner)
    for name in both:
        wait_for(lambda name=name: cell(page, name, "clearance") not in ("", "–"))
        page.find(f'tr[data-attempt="{name}"] .dot').click()
    assert page.js("() => [...planner.state.overlays]") == both
    wait_for(lambda: page.js("() => planner.state.attempts.every((each) => each.path.length > 10)"))
    page.find(f'tr[data-attempt="{first}"] .name').click()
    page.find("#choose").click()
    wait_for(lambda: planner.loop.history.chosen == first)
    wait_for(lambda: "chosen" in cell(page, first, "attempt"))


def test_an_attempt_is_solved_again_with_another_strategy(page, planner, first):
    page.find(f'tr[data-attempt="{first}"] .name').click()
    page.js("() => { planner.state.recorded = true; }")  # as after a recording whose attempt came before its last frame
    page.select("#resolve", "newton")
    wait_for(lambda: len(names(planner)) == 3, 120)
    again = planner.loop.history[names(planner)[-1]]
    page.find(f'tr[data-attempt="{again.name}"]').wait_for()
    assert page.text(".second .current") == first, "the operator's choice stays"
    assert again.strategy == "newton"
    assert again.parent == first
    np.testing.assert_allclose(again.targets, planner.loop.history[first].targets, atol=1e-9)


def exported(page, kind):
    page.select("#format", kind)
    with page.expect_download(timeout=120_000) as download:
        page.find("#export").click()
    return download.value.path().read_bytes()


def test_an_attempt_is_committed_and_its_files_verified_by_forward_kinematics(page, planner, first):
    attempt, robot = planner.loop.history[first], planner.arm.robot
    page.find(f'tr[data-attempt="{first}"] .name').click()
    page.find("#commit").click()
    wait_for(lambda: page.find(".findings").first.inner_text() not in ("", "checking"))
    table = pandas.read_csv(io.BytesIO(exported(page, "csv")))
    columns = [f"{name} [rad]" for name in robot.joint_names]
    q, times = table[columns].to_numpy(), table["time [s]"].to_numpy()
    document = json.loads(exported(page, "json"))
    numbers = np.load(io.BytesIO(exported(page, "npz")))
    wait_for(lambda: ".npz" in page.text("#exported"))
    told = page.text("#exported")
    assert f"{times[-1]:.2f} s" in told
    assert ("smoothed" in told) == ("inside" not in told), "smoothed, unless that would be no better"
    assert page.find("#exported .findings li").count() >= 1
    page.keyboard.press("Escape")
    assert (np.diff(times) > 0).all()
    np.testing.assert_allclose(q[0], attempt.configurations[0], atol=1e-6)
    np.testing.assert_allclose(q[-1], attempt.configurations[-1], atol=1e-6)
    path = np.array([robot.position(each) for each in attempt.configurations])
    for each in q[:: max(1, len(q) // 60)]:
        assert np.linalg.norm(path - robot.position(each), axis=1).min() < 0.02, "the commands stay on the path"
    assert list(document["joint_names"]) == list(robot.joint_names)
    assert any(np.shape(numbers[key]) == q.shape and np.allclose(numbers[key], q, atol=1e-9) for key in numbers.files)


def test_the_plan_is_saved_and_loaded(page, planner):
    before = planner.loop.history
    with page.expect_download() as download:
        page.find("#save").click()
    path = download.value.path()
    page.find(f'[aria-label="delete {before.names[-1]}"]').click()
    wait_for(lambda: len(planner.loop.history) == len(before) - 1)
    kept = planner.loop.history
    page.set_input_files("#file", path)
    page.click_text("Keep them")
    page.set_input_files("#file", path)
    page.find("#replace").wait_for()
    assert planner.loop.history is kept, "nothing is replaced without asking"
    page.find("#replace").click()
    wait_for(lambda: planner.loop.history.names == before.names)
    for one, other in zip(planner.loop.history, before, strict=True):
        assert one.to_json() == other.to_json()


def test_a_file_that_is_no_plan_is_told_and_nothing_is_lost(page, planner, tmp_path):
    before = planner.loop.history
    (tmp_path / "notes.json").write_text('{"shopping": ["bread"]}')
    page.set_input_files("#file", tmp_path / "notes.json")
    page.find("#replace").click()
    wait_for(lambda: "no plan" in page.text("#toasts"))
    assert planner.loop.history is before
