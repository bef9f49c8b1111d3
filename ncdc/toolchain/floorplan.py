"""Sites for the block RAMs and multipliers of an ECP5, by what they are connected to.

nextpnr moves these blocks to their sites after the placement of all else, which then begins anew.
In a design with many of them wires get much longer by that. Here the blocks move to their sites
step by step, and the logic with them. What is left for nextpnr is the placement of the logic.
"""

import json
import re
from collections import defaultdict

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import cg, eigsh

from ncdc.toolchain.ecp5_device import BLOCKS
from ncdc_spec.builds import built, key_of

__all__ = ["add_sites", "sites_of"]

_AREA = {"LUT4": 1, "CCU2C": 2, "TRELLIS_FF": 1, "TRELLIS_DPR16X4": 4}  # of the logic, half slices
_MIN_BLOCKS = 16        # blocks for a plan: with fewer, most clocks are faster without one
_SPREAD = 1.8           # half slices of the planned region for each one in use
_LARGEST = 150          # cells of a net that counts: larger nets reach everywhere
_PAIRS = 6              # cells of a net that are pulled together pair by pair, not to its centre
_STEPS, _FIXED = 60, 4  # of the plan, and those of them at its end with the blocks at their sites
_MODES = 4              # the slowest ones: the first is constant, two are used
_LEAF = 24              # cells that are spread along each axis alone


def sites_of(size, call):
    """Sites of an ECP5's blocks: those in nextpnr's placement of a netlist of nothing but blocks.

    Parameters
    ----------
    size : str
        A key of the device in :data:`ncdc.toolchain.ecp5_device.BLOCKS`.
    call : callable
        Runs nextpnr: ``call(folder, *arguments)``.

    Returns
    -------
    dict of dict
        By the kind of block: (column, row) by the site's name.
    """
    def ask(folder):
        (folder / "blocks.json").write_text(json.dumps(_all_blocks(size)))
        call(folder, f"--{size}k", "--json", "blocks.json", "--no-route", "--quiet",
             "--out-of-context", "--timing-allow-fail", "--write", "placed.json")
    folder = built(key_of("sites", size), ask)
    (module,) = json.loads((folder / "placed.json").read_text())["modules"].values()
    sites = {kind: {} for kind in BLOCKS}
    for cell in module["cells"].values():
        name = cell["attributes"]["NEXTPNR_BEL"]
        sites[cell["type"]][name] = tuple(map(int, re.match(r"X(\d+)/Y(\d+)/", name).groups()))
    return {kind: dict(sorted(those.items())) for kind, those in sites.items()}


def _all_blocks(size):
    """A netlist with as many blocks as the device has, connected to nothing."""
    cells = {f"{kind}_{k}": {"hide_name": 0, "type": kind, "parameters": {},
                             "attributes": {"keep": "1"}, "port_directions": {}, "connections": {}}
             for kind, counts in BLOCKS.items() for k in range(counts[size])}
    return {"modules": {"top": {"attributes": {"top": "1"}, "ports": {}, "cells": cells,
                                "netnames": {}}}}


def add_sites(netlist, top, sites):
    """Give each block RAM and multiplier of a netlist its site, as nextpnr's attribute ``BEL``.

    The plan is that of a quadratic placer: nets pull their cells together, the more the shorter
    they are, so that the sum of lengths is minimised. Logic is drawn to where it would be if
    spread evenly, blocks to sites, each step more strongly. Sites are assigned anew in each step
    with the least sum of ways. The result is the same for the same netlist. A netlist of few
    blocks gets no sites.

    Parameters
    ----------
    netlist : dict
        Flat, of ``synth_ecp5``; changed in place.
    top : str
    sites : dict of dict
        As of :func:`sites_of`.
    """
    cells = netlist["modules"][top]["cells"]
    kinds = np.array([cell["type"] for cell in cells.values()])
    blocks = {kind: np.flatnonzero(kinds == kind) for kind in sites}
    blocks = {kind: those for kind, those in blocks.items() if len(those)}
    # Too many blocks for the device are nextpnr's to name.
    if (sum(map(len, blocks.values())) < _MIN_BLOCKS
            or any(len(those) > len(sites[kind]) for kind, those in blocks.items())):
        return
    names = list(cells)
    for kind, chosen in _plan(cells, kinds, blocks, sites).items():
        bels = list(sites[kind])
        for cell, site in zip(blocks[kind], chosen):
            cells[names[cell]].setdefault("attributes", {})["BEL"] = bels[site]


def _plan(cells, kinds, blocks, sites):
    """The number of the site of each block, by its kind."""
    nets, pull = _nets(cells)
    where = {kind: np.array(list(those.values()), float) for kind, those in sites.items()}
    area = np.array([_AREA.get(kind, 0) for kind in kinds], float)
    region = _region(area, blocks, where)
    pins = np.bincount(np.concatenate([np.zeros(0, int), *nets]), minlength=len(kinds))
    position = _first(pull, region)
    logic = np.flatnonzero(area)
    chosen = {}
    for step in range(_STEPS):
        strength = step / (_STEPS - _FIXED)
        target, hold = position.copy(), np.zeros_like(position)
        target[logic] = _spread(position[logic], area[logic], region)
        away = np.abs(position - target) + 2
        hold[logic] = .15 * (step + 1) / _STEPS * 5 * area[logic, None] / away[logic]
        for kind, those in blocks.items():
            if strength < 1:
                chosen[kind] = _assign(position[those], where[kind])
            target[those] = where[kind][chosen[kind]]
            away = np.abs(position[those] - target[those]) + 2
            hold[those] = (1e4 if strength >= 1 else
                           1.5 * strength ** 1.5 * pins[those, None] / away)
        for _ in range(2):
            position = _settle(pull, position, target, hold)
    return chosen


def _nets(cells):
    """Cells of each net, by number; (cell, other cell, strength) of each pull.

    Cells of larger nets are pulled to a node of the net, numbered after all cells.
    """
    users = defaultdict(set)
    for number, cell in enumerate(cells.values()):
        for bits in cell["connections"].values():
            for bit in bits:
                if isinstance(bit, int):
                    users[bit].add(number)
    nets = [np.array(sorted(net)) for net in users.values() if 2 <= len(net) <= _LARGEST]
    first, second, strength, node = [], [], [], len(cells)
    for net in nets:
        if len(net) <= _PAIRS:
            a, b = np.triu_indices(len(net), 1)
            first.append(net[a])
            second.append(net[b])
            strength.append(np.full(len(a), 2 / (len(net) - 1)))
        else:
            first.append(net)
            second.append(np.full(len(net), node))
            strength.append(np.ones(len(net)))
            node += 1
    none = np.zeros(0, int)     # which keeps the type of numbers of cells if there is no net
    return nets, (node, np.concatenate([none, *first]), np.concatenate([none, *second]),
                  np.concatenate([none, *strength]))


def _region(area, blocks, where):
    """Left, upper, right and lower end of the planned part of the device: in its middle, and as
    large as its logic and its blocks need."""
    everything = np.concatenate(list(where.values()))
    low, high = everything.min(axis=0), everything.max(axis=0)
    # A column has eight half slices in each row.
    shares = [_SPREAD * area.sum() / (8 * np.prod(high - low)),
              *(len(blocks[kind]) / len(where[kind]) for kind in blocks)]
    half = (high - low) / 2 * min(1, max(shares)) ** .5
    return (*((low + high) / 2 - half), *((low + high) / 2 + half))


def _matrix(pull, weights):
    """The sparse symmetric matrix of ``weights``, and the sum of each of its rows."""
    count, first, second, _ = pull
    one_way = coo_matrix((weights, (first, second)), shape=(count, count))
    matrix = (one_way + one_way.T).tocsr()
    return matrix, np.asarray(matrix.sum(axis=1)).ravel() + 1e-9


def _first(pull, region):
    """Positions by the two slowest modes of the pulls: neighbours are near, all is in order."""
    low, high = np.array(region[:2]), np.array(region[2:])
    if pull[0] <= _MODES:
        return np.tile((low + high) / 2, (pull[0], 1))
    matrix, total = _matrix(pull, pull[3])
    scale = 1 / np.sqrt(total)
    _, modes = eigsh(diags(scale) @ matrix @ diags(scale), k=_MODES, which="LA", tol=1e-3,
                     maxiter=400, v0=np.linspace(.5, 1.5, pull[0]))
    modes = modes[:, (2, 1)] * scale[:, None]
    order = (modes.argsort(axis=0, kind="stable").argsort(axis=0, kind="stable") + .5) / pull[0]
    return low + order * (high - low)


def _settle(pull, position, target, hold):
    """Positions of the least energy, of pulls and of what ``hold`` draws to its ``target``."""
    _, first, second, strength = pull
    settled = position.copy()
    for axis in range(2):
        # Divided by the length, so that not its square counts but the length itself.
        length = np.abs(position[first, axis] - position[second, axis]) + 1
        matrix, total = _matrix(pull, strength / length)
        total = total + hold[:, axis]
        settled[:, axis], _ = cg(diags(total) - matrix, hold[:, axis] * target[:, axis],
                                 x0=position[:, axis], rtol=1e-4, maxiter=300, M=diags(1 / total))
    return settled


def _spread(position, area, region):
    """Positions in the same order, with the same area everywhere: halves of the cells go to halves
    of the region, again and again."""
    spread = position.copy()
    left = [(np.arange(len(position)), *region)]
    while left:
        cells, *ends = left.pop()
        axis = int(ends[3] - ends[1] > ends[2] - ends[0])
        if len(cells) <= _LEAF:
            for axis in range(2):
                order = cells[position[cells, axis].argsort(kind="stable")]
                share = (np.arange(len(cells)) + .5) / len(cells)
                spread[order, axis] = ends[axis] + share * (ends[axis + 2] - ends[axis])
            continue
        order = cells[position[cells, axis].argsort(kind="stable")]
        total = area[order].cumsum()
        cut = int(np.searchsorted(total, total[-1] / 2)) + 1
        middle = (ends[axis] + ends[axis + 2]) / 2
        lower, upper = list(ends), list(ends)
        lower[axis + 2] = upper[axis] = middle
        left += [(order[:cut], *lower), (order[cut:], *upper)]
    return spread


def _assign(position, sites):
    """The number of each block's site, for the least sum of their ways."""
    ways = np.abs(position[:, None] - sites[None]).sum(axis=2)
    _, chosen = linear_sum_assignment(ways)
    return chosen
