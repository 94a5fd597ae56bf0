"""Which of the tests of a matrix run: so many that each value of each parameter still occurs.

A test with parameters that is marked ``thinned`` is a matrix, as of each strategy with each robot and each kind of
target. Of its quick tests those run that are needed for each of their values to occur, in turn with the values of the
others, as in a Latin square, and of its slow tests likewise. The option ``--full`` runs the full matrix.

``thinned("strategy", "backend")`` counts these parameters only, ``thinned(times=2)`` keeps each value of the slow tests
twice, and ``thinned(together=True)`` makes one matrix of all tests of a file that are marked so: the test itself is one
more parameter.

Of a test that is marked ``quick(4)`` four cases are quick, from the first to the last, and the others are slow. As many
of these run, at least three, or five with ``quick(4, slow=5)``; with ``--full`` all of them. Where they begin depends
on the name of the test, so that of a list that many tests share each case runs somewhere.
"""

from __future__ import annotations

import zlib
from collections import Counter, defaultdict

AT_LEAST = 3
"""Slow cases of a test marked ``quick`` that run where it does not say how many."""


def thinned(rows, times=1):
    """Indices of the rows that are kept, each a dict of values: each value as often as ``times``, where it can be.

    The row with most of the values that are missing is next, and among equal ones that whose values were used least.
    """
    rows = [list(row.items()) for row in rows]
    available = Counter(value for row in rows for value in row)
    missing = {value: min(times, count) for value, count in available.items()}
    used, kept, left = Counter(), [], list(range(len(rows)))
    while any(missing.values()):

        def order(index):
            row = rows[index]
            return -sum(missing[value] > 0 for value in row), sum(used[value] for value in row), index

        best = min(left, key=order)
        left.remove(best)
        kept.append(best)
        for value in rows[best]:
            missing[value] -= missing[value] > 0
            used[value] += 1
    return sorted(kept)


def _value(value):
    """What equals that of another value only if both are the same: 1 is neither True nor 1.0, and 0.0 not -0.0."""
    try:
        hash(value)
    except (TypeError, NotImplementedError):  # the latter from matrices of CasADi
        return id(value)
    return type(value), repr(value) if isinstance(value, float) else value


def _name(item):
    return item.nodeid.split("[")[0]


def _beyond(items, count):
    """The items but so many of them, from the first to the last."""
    kept = {round(i * (len(items) - 1) / max(count - 1, 1)) for i in range(count)}
    return [item for index, item in enumerate(items) if index not in kept]


def _beyond_a_turn(items, count):
    """The items but so many of them, evenly spaced from one that depends on the name of the test."""
    begin, count = zlib.crc32(_name(items[0]).encode()), min(count, len(items))
    kept = {(begin + i * len(items) // count) % len(items) for i in range(count)}
    return [item for index, item in enumerate(items) if index not in kept]


def _cases_of_quick(items, *, slow):
    """The slow or the other cases of each test that is marked ``quick``, and its mark."""
    cases = defaultdict(list)
    for item in items:
        if item.get_closest_marker("quick") and (item.get_closest_marker("slow") is not None) == slow:
            cases[_name(item)].append(item)
    return [(each, each[0].get_closest_marker("quick")) for each in cases.values()]


def mostly_slow(items):
    """The tests that are to be marked slow: all but the given number of those marked ``quick``."""
    return [item for each, mark in _cases_of_quick(items, slow=False) for item in _beyond(each, *mark.args)]


def deselected(items):
    """The tests that do not run, of those that pytest has collected."""
    dropped = set()
    for each, mark in _cases_of_quick(items, slow=True):
        dropped.update(_beyond_a_turn(each, mark.kwargs.get("slow", max(AT_LEAST, *mark.args))))
    matrices = defaultdict(list)
    for item in items:
        mark = item.get_closest_marker("thinned")
        if mark and hasattr(item, "callspec") and item not in dropped:
            name, params = _name(item), item.callspec.params
            slow = item.get_closest_marker("slow") is not None
            row = {"test": name} | {key: _value(params[key]) for key in mark.args or params}
            matrix = item.path if mark.kwargs.get("together") else name
            matrices[matrix, slow, mark.kwargs.get("times", 1) if slow else 1].append((item, row))
    for (_, _, times), tests in matrices.items():
        kept = thinned([row for _, row in tests], times)
        dropped.update(tests[index][0] for index in set(range(len(tests))) - set(kept))
    return dropped
