"""Old names of attributes: the value of the new one, with a warning that names it and points to the caller."""

from __future__ import annotations

import pytest

from jtik.result.deprecated import RenamedAttribute


class Renamed:
    new = 3.0
    old = RenamedAttribute("new")


def test_it_reads_the_new_one_and_says_so():
    with pytest.warns(DeprecationWarning, match=r"^Renamed\.old is deprecated: use new$") as caught:
        assert Renamed().old == 3.0
    assert [one.filename for one in caught] == [__file__]


def test_the_class_tells_what_it_is():
    assert Renamed.old.__doc__ == "Deprecated: use `new`."
