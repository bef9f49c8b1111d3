"""Few combinations of options that hold each pair of values of two options."""

from itertools import combinations, product

__all__ = ["covering", "pairs_of"]


def pairs_of(case):
    """Pairs of (option, value) in a case, a dict."""
    return set(combinations(sorted(case.items(), key=str), 2))


def covering(options, allowed):
    """Cases, dicts by option, that hold every pair that any allowed case holds.

    Parameters
    ----------
    options : dict
        Values of each option by its name.
    allowed : callable
        Whether a case is one at all.

    Returns
    -------
    (list of dict, set)
        The cases, each the first one of those that hold the most pairs not held yet; all pairs.
    """
    every = [dict(zip(options, values)) for values in product(*options.values())]
    every = [(case, pairs_of(case)) for case in every if allowed(case)]
    left = set().union(*(pairs for _, pairs in every))
    wanted, cases = set(left), []
    while left:
        case, pairs = max(every, key=lambda one: len(one[1] & left))
        cases.append(case)
        left -= pairs
        every = [(case, pairs & left) for case, pairs in every if pairs & left]
    return cases, wanted
