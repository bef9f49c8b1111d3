"""Choice of the region table's entries that makes the ``mmhbc`` tan-sigmoid monotonic."""

import numpy as np

from ncdc_model.tansig.lvc import quotient, round_shift

__all__ = ["monotonic_tuning"]

_CHANGES = (0, -1, 1, -2, 2)


def monotonic_tuning(design, changes=_CHANGES):
    """Changes of table entries by which no output decreases: dict of entry and change.

    Every input is evaluated with every one of ``changes`` to the entry of its region, which is a
    matter of seconds. Among all choices without a decrease, inside a region or where two meet,
    the one with the least sum of \\|change\\| is taken; of equal ones that with the earlier
    changes in the list at the last regions. The rounded table of ``design`` is what is changed,
    whatever tuning it has already.

    Raises
    ------
    ValueError
        If no choice is monotonic.
    """
    cost, chosen, ends = np.zeros(1), [], np.zeros(1, np.int64)
    for region, entry in enumerate(design.rounded_table):
        outputs = [_region(design, region, entry + change) for change in changes]
        price = np.full(len(changes), np.inf)
        before = np.zeros(len(changes), np.int64)
        for k, (change, q) in enumerate(zip(changes, outputs)):
            if (np.diff(q) < 0).any():
                continue
            reach = np.where(ends <= q[0], cost, np.inf)
            before[k] = reach.argmin()
            price[k] = reach[before[k]] + abs(change)
        if np.isinf(price).all():
            raise ValueError(f"no change of table entry {region} keeps {design} monotonic")
        chosen.append(before)
        cost, ends = price, np.array([q[-1] for q in outputs])
    k, tuned = int(cost.argmin()), {}
    for region in reversed(range(len(chosen))):
        if changes[k]:
            tuned[region] = changes[k]
        k = int(chosen[region][k])
    return dict(sorted(tuned.items()))


def _region(design, region, entry):
    """Raw results of every input of one region with the table entry ``entry``."""
    fine = design.fine_bits
    a = np.arange(1 << fine)
    u = np.full(len(a), entry)
    for k, shift in enumerate(design.shifts):
        step = round_shift(u, shift)
        u += np.where((a >> (fine - 1 - k)) & 1, -step, step)
    q = quotient(u, design.width, design.digits)
    if region == 0:
        q[0] = 0
    return q
