"""Which tests of a matrix run: each value of each parameter occurs, in turn with the values of the others."""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from .thinning import deselected, mostly_slow, thinned

FULL = [
    dict(zip(("strategy", "length", "limits"), row, strict=True))
    for row in itertools.product("abcdef", (0.5, 2.0, 3.5), (True, False))
]


@pytest.mark.parametrize("times", [1, 2, 5])
def test_each_value_is_kept_so_often_and_no_row_more_than_that_needs(times):
    rows = [FULL[index] for index in thinned(FULL, times)]
    assert len(rows) == 6 * times
    for column, size in (("strategy", 6), ("length", 3), ("limits", 2)):  # and equally often, as in a Latin square
        assert set(Counter(row[column] for row in rows).values()) == {6 * times // size}


def test_what_occurs_less_often_is_kept():
    rows = [{"x": x, "y": y} for x, y in (("a", 1), ("a", 2), ("b", 2), ("c", 3))]
    assert thinned(rows, 3) == [0, 1, 2, 3]
    assert thinned(rows) == [0, 2, 3]


@dataclass(eq=False)
class Item:
    """What a test that pytest has collected shows of itself."""

    nodeid: str
    marks: dict
    path: str = "test_file.py"

    def get_closest_marker(self, name):
        return self.marks.get(name)


def collected(*, slow=True, **options):
    """Two tests with a strategy, one of them with a time as well, and one without parameters."""
    marks = {"thinned": pytest.mark.thinned(**options).mark} | ({"slow": pytest.mark.slow.mark} if slow else {})
    every = [Item("test_file.py::test_alone", marks)]
    for name, times in (("one", (0.1, 0.2, 0.3)), ("another", (None,))):
        for strategy, dt in itertools.product("abc", times):
            every.append(Item(f"test_file.py::test_{name}[{strategy}-{dt}]", marks))
            every[-1].callspec = SimpleNamespace(params={"strategy": strategy} | ({"dt": dt} if dt else {}))
    return every


@pytest.mark.parametrize(("together", "one", "another"), [(False, 3, 3), (True, 3, 1)])
def test_of_a_matrix_some_run_and_of_a_test_without_parameters_the_only_one(together, one, another):
    items = collected(together=together)
    names = Counter(item.nodeid.split("[")[0] for item in items if item not in deselected(items))
    assert names == {
        "test_file.py::test_alone": 1,
        "test_file.py::test_one": one,
        "test_file.py::test_another": another,
    }


def test_quick_and_slow_tests_are_matrices_of_their_own():
    quick, slow = collected(slow=False), collected()
    kept = Counter(item.nodeid.split("[")[0] for item in {*quick, *slow} - deselected([*quick, *slow]))
    assert kept == {"test_file.py::test_alone": 2, "test_file.py::test_one": 6, "test_file.py::test_another": 6}


def test_values_that_are_equal_but_not_the_same_both_run():
    items = []
    for value in (0, False, 0.0, -0.0, [], []):
        items.append(Item(f"test_file.py::test_one[{value}]", {"thinned": pytest.mark.thinned.mark}))
        items[-1].callspec = SimpleNamespace(params={"value": value})
    assert not deselected(items)


@pytest.mark.parametrize(
    ("count", "quick"), [(1, [0]), (2, [0, 8]), (3, [0, 4, 8]), (9, list(range(9))), (20, [*range(9)])]
)
def test_so_many_cases_are_quick_from_the_first_to_the_last(count, quick):
    marks = {"quick": pytest.mark.quick(count).mark}
    items = [Item(f"test_file.py::test_one[{number}]", marks) for number in range(9)]
    already = [Item(f"test_file.py::test_one[{number}]", marks | {"slow": pytest.mark.slow.mark}) for number in (9, 10)]
    slow = mostly_slow([*items, *already])
    assert [number for number, item in enumerate(items) if item not in slow] == quick
    assert not set(already) & set(slow)


def running(test, count, *args, **options):
    """The numbers of the slow cases of a test that run."""
    marks = {"quick": pytest.mark.quick(*args, **options).mark, "slow": pytest.mark.slow.mark}
    items = [Item(f"test_file.py::{test}[{number}]", marks) for number in range(count)]
    dropped = deselected(items)
    return [number for number, item in enumerate(items) if item not in dropped]


@pytest.mark.parametrize(
    ("args", "options", "count"), [((1,), {}, 3), ((5,), {}, 5), ((1,), {"slow": 4}, 4), ((0,), {"slow": 99}, 9)]
)
def test_of_the_others_so_many_run(args, options, count):
    assert len(running("test_one", 9, *args, **options)) == count


def test_of_a_list_that_tests_share_each_case_runs_in_one_of_them():
    found = [running(f"test_{name}", 40, 2) for name in range(60)]
    assert {number for each in found for number in each} == {*range(40)}
    assert all(b - a in (13, 14) for each in found for a, b in itertools.pairwise(each))
