"""Parameters of tests by name, some of them with the marker of longer tests."""

import pytest

__all__ = ["cases"]


def cases(rows, longer=()):
    """One parameter for each of ``rows``, with its name as its id.

    Parameters
    ----------
    rows : mapping of names to tuples of values, or names alone, which are then the values
    longer : names of the rows that only `make longer` and `make regress` run

    Raises
    ------
    ValueError
        If a name of ``longer`` is not among ``rows``.
    """
    unknown = set(longer) - set(rows)
    if unknown:
        raise ValueError(f"no such case: {', '.join(sorted(unknown))}")
    if not hasattr(rows, "values"):
        rows = {name: (name,) for name in rows}
    return [pytest.param(*values, id=name, marks=[pytest.mark.longer] * (name in longer))
            for name, values in rows.items()]
