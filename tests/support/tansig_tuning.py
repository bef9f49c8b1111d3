"""Chooses table entries that make a tan-sigmoid monotonic."""

import numpy as np

__all__ = ["monotonic_tuning"]


def monotonic_tuning(design, reach=12):
    """Changes of table entries by which no output decreases: dict of entry and change.

    Every input is evaluated with every change of its entry up to +-``reach``, which takes seconds.
    A choice is monotonic if no output decreases within an entry's part of the input or where two
    meet. The result is the choice of smallest sum of \\|change\\|, always the same. The changes
    are to the untuned table of ``design``.

    Parameters
    ----------
    design : TansigDesign or TableDesign
        Has ``entries``, the number of table entries in the input's order, and
        ``changed_entry(entry, change)``, the raw results of its part of the input.

    Raises
    ------
    ValueError
        If no choice is monotonic.
    """
    changes = sorted(range(-reach, reach + 1), key=abs)
    cost, ends, chosen = np.zeros(1), np.zeros(1, np.int64), []
    for entry in range(design.entries):
        outputs = [design.changed_entry(entry, change) for change in changes]
        best, before = np.full(len(changes), np.inf), np.zeros(len(changes), np.int64)
        for k, (change, q) in enumerate(zip(changes, outputs)):
            if (np.diff(q) >= 0).all():
                allowed = np.where(ends <= q[0], cost, np.inf)
                before[k] = allowed.argmin()
                best[k] = allowed[before[k]] + abs(change)
        if np.isinf(best).all():
            raise ValueError(f"no change of table entry {entry} keeps {design} monotonic")
        chosen.append(before)
        cost, ends = best, np.array([q[-1] for q in outputs])
    k, tuned = int(cost.argmin()), {}
    for entry in reversed(range(design.entries)):
        if changes[k]:
            tuned[entry] = changes[k]
        k = int(chosen[entry][k])
    return dict(sorted(tuned.items()))
