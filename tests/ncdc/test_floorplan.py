"""Sites of blocks: next to what they are connected to."""

import copy

import numpy as np
import pytest

from ncdc.toolchain.ecp5_device import BLOCKS
from ncdc.toolchain.floorplan import _all_blocks, add_sites

# Two rows of each kind of block, which alternate as on the device.
SITES = {"DP16KD": {f"X{x}/Y{y}/EBR0": (x, y) for y in (20, 60) for x in range(2, 62, 2)},
         "MULT18X18D": {f"X{x}/Y{y}/MULT0": (x, y) for y in (10, 40) for x in range(2, 62, 2)}}
PARTS, LOGIC = 24, 60


def parts_of_a_ring(seed=1):
    """A netlist of parts, in the order of a random ring. Each has logic, a RAM and a multiplier,
    and shares nets with the parts before and after it."""
    rng = np.random.default_rng(seed)
    cells, bit = {}, iter(range(2, 10**6))
    ring = rng.permutation(PARTS)
    after = {int(a): int(b) for a, b in zip(ring, np.roll(ring, -1))}
    outputs = {}
    for part in range(PARTS):
        outputs[part] = [next(bit) for _ in range(LOGIC)]
    for part in range(PARTS):
        own = outputs[part]
        for k in range(LOGIC):
            inputs = [own[int(n)] for n in rng.integers(0, LOGIC, 2)]
            inputs += [outputs[after[part]][k]] if k % 6 == 0 else []
            cells[f"p{part}_{k}"] = cell("LUT4", Z=[own[k]], A=inputs)
        cells[f"p{part}_ram"] = cell("DP16KD", DIA=own[:20])
        cells[f"p{part}_product"] = cell("MULT18X18D", A=own[20:40])
    return {"modules": {"top": {"cells": cells}}}, after


def cell(kind, **connections):
    return {"type": kind, "connections": connections}


def placed(netlist):
    """Position of each block that has a site."""
    where = {name: at for those in SITES.values() for name, at in those.items()}
    cells = netlist["modules"]["top"]["cells"]
    return {name: np.array(where[cell["attributes"]["BEL"]])
            for name, cell in cells.items() if "attributes" in cell}


def way_around(position, after):
    """Sum of the ways from each part's RAM to the next part's."""
    return sum(np.abs(position[f"p{a}_ram"] - position[f"p{b}_ram"]).sum()
               for a, b in after.items())


def test_blocks_that_belong_together_are_near_each_other():
    netlist, after = parts_of_a_ring()
    add_sites(netlist, "top", SITES)
    position = placed(netlist)
    assert len(position) == 2 * PARTS
    cells = netlist["modules"]["top"]["cells"]
    sites = [cell["attributes"]["BEL"] for cell in cells.values() if "attributes" in cell]
    assert len(set(sites)) == len(sites)
    for name in position:
        assert cells[name]["attributes"]["BEL"] in SITES[cells[name]["type"]]
    in_order = {f"p{part}_ram": np.array(at)
                for part, at in zip(range(PARTS), SITES["DP16KD"].values())}
    assert way_around(position, after) < .6 * way_around(in_order, after)
    # A multiplier is at most as far from its part's RAM as two rows of sites are apart, and a bit.
    for part in range(PARTS):
        away = position[f"p{part}_ram"] - position[f"p{part}_product"]
        assert np.abs(away).sum() <= 30, part


def test_a_plan_is_the_same_for_the_same_netlist():
    plans = []
    for _ in range(2):
        netlist, _ = parts_of_a_ring()
        add_sites(netlist, "top", SITES)
        plans.append(netlist)
    assert plans[0] == plans[1]


@pytest.mark.parametrize("changed", [
    {"ram": cell("DP16KD", DIA=[5])},                                   # connected to nothing
    {f"ram{k}": cell("DP16KD", DIA=[2 + k]) for k in range(40)}])       # 64 RAMs, 60 sites
def test_a_netlist_that_cannot_be_planned(changed):
    netlist, _ = parts_of_a_ring()
    netlist["modules"]["top"]["cells"] |= changed
    add_sites(netlist, "top", SITES)
    assert len(placed(netlist)) in (0, 2 * PARTS + 1)


@pytest.mark.parametrize("rams,planned", [(0, 0), (15, 0), (16, 16)])
def test_a_netlist_of_few_blocks_is_as_before(rams, planned):
    netlist = {"modules": {"top": {"cells": {
        "a": cell("LUT4", Z=[2], A=[3]),
        **{f"ram{k}": cell("DP16KD", DIA=[2], DOA=[3]) for k in range(rams)}}}}}
    before = copy.deepcopy(netlist)
    add_sites(netlist, "top", SITES)
    assert len(placed(netlist)) == planned and (netlist == before) == (not planned)


@pytest.mark.parametrize("size", BLOCKS["DP16KD"])
def test_the_netlist_that_asks_for_sites_has_all_blocks(size):
    cells = _all_blocks(size)["modules"]["top"]["cells"].values()
    for kind, counts in BLOCKS.items():
        assert sum(one["type"] == kind for one in cells) == counts[size]
