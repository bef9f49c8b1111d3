"""The list of tests that `make test` leaves to `make longer`."""

import pytest

from longer import COLLECTED, LIMIT, LONGER, SHARED, STAYS, grown, longer


def test_each_one_is_there(request):
    """A name that no test has any more would leave its test to a newcomer."""
    if request.config.args != request.config.getini("testpaths"):
        pytest.skip("only some of the tests were asked for")
    assert LONGER and not LONGER - request.config.stash[COLLECTED]


def test_a_test_is_left_out_by_either_time_and_what_stays_is_not():
    short, long = LIMIT / 2, LIMIT
    new = {"short": short, "new": long, "again": short} | dict.fromkeys(STAYS, long)
    again = {"short": short, "again": long}
    assert longer(new, again) == ["again", "new"]
    del new[min(STAYS)]
    with pytest.raises(ValueError, match="no such test"):
        longer(new, again)


def test_the_list_grows_by_what_pays_for_others():
    rest = {"short": LIMIT, "pays": SHARED} | dict.fromkeys(STAYS, SHARED)
    assert grown(rest) == sorted(LONGER | {"pays"})
