"""Status: a sentence for each reason, and which of them are success."""

from __future__ import annotations

import pytest

from jtik import Status
from jtik.result.status import is_success


def test_each_sentence_is_different():
    sentences = [status.value for status in Status]
    assert len(set(sentences)) == len(sentences)
    assert all(len(sentence.split()) > 3 for sentence in sentences)


def test_names():
    assert {status.name for status in Status} == {
        "CONVERGED",
        "REACHED",
        "SADDLE",
        "COMPROMISE",
        "LOCAL_MINIMUM",
        "PRIORITIES",
        "LIMITS",
        "JUMP_LIMIT",
        "SINGULAR",
        "STALLED",
        "ITERATION_LIMIT",
        "UNSOLVED",
        "BLOCKED",
        "NOT_FINITE",
    }


@pytest.mark.parametrize("status", Status)
def test_only_arrival_is_success(status):
    assert is_success(status, "stationary") == (status is Status.CONVERGED)
    arrived = status in (Status.CONVERGED, Status.REACHED, Status.SADDLE)
    assert is_success(status, "reached") == arrived == status.on_target


def test_which_depend_on_the_start():
    depending = {status.name for status in Status if status.depends_on_start}
    assert depending == {"LOCAL_MINIMUM", "LIMITS", "SINGULAR", "STALLED"}
