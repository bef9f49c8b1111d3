"""The part of ``ncdc build`` that runs open tools: from a design's files to a bitstream."""

import json
import tempfile
from pathlib import Path

from ncdc.toolchain.bitstream import (
    clock_nets,
    clock_preferences,
    nextpnr_options,
    pack,
    place_and_route,
    resources,
    synthesise_board,
    used_cells,
)
from ncdc.toolchain.ecp5_device import check_blocks
from ncdc.toolchain.flows import SynthesisError
from ncdc_boards.board import project_name
from ncdc_boards.ecp5.build import clock_cells, clock_targets
from ncdc_spec.errors import InputError

__all__ = ["implemented", "print_implemented"]


def implemented(design, files, sources, steps, *, seeds, synthesize_only=False):
    """Synthesise, place and route a design for an ECP5.

    Parameters
    ----------
    design : Design
    files : dict
        Text of the design's files, by name.
    sources : dict
        Text of other Verilog files and of what their memories begin with, by name.
    steps : callable
        Called with the name of each step.
    seeds : int
        Place-and-route runs.
    synthesize_only : bool
        Stop before place and route: the netlist takes the bitstream's position.

    Returns
    -------
    dict
        Text or bytes of the files to write, by name: bitstream or netlist come first.
    dict
        The report's part.

    Raises
    ------
    InputError
        If a tool fails, the device has too few blocks, or no run meets timing.
    """
    name = project_name(design.board)
    rtlil, preferences = files.pop(f"{name}.il"), files[f"{name}.lpf"]
    with tempfile.TemporaryDirectory(prefix="ncdc-") as made:
        folder = Path(made)
        try:
            steps("synthesis: Yosys")
            netlist = synthesise_board(rtlil, name, folder, sources)
            cells = used_cells(netlist)
            check_blocks(design.board.device, cells)
            nets = clock_nets(netlist, clock_cells(design))
            preferences += clock_preferences(nets, clock_targets(design))
            files[f"{name}.lpf"] = preferences
            if synthesize_only:
                return {f"{name}.json": json.dumps(netlist), **files}, {
                    "cells": cells, "clocks": _targets(design)}
            runs = []
            for seed in range(1, seeds + 1):
                steps(f"place and route: nextpnr, seed {seed} of {seeds}")
                runs.append(place_and_route(folder, design.board.device, preferences, nets, seed))
            best = max(runs, key=lambda one: one.slack)
            _check_clocks(best, seeds)
            steps("packing the bitstream")
            bits = pack(folder, best.seed)
        except SynthesisError as error:
            steps("failed")
            raise InputError(str(error)) from error
    return {f"{name}.bit": bits, **files}, _report(best, runs, bits)


def _targets(design):
    """The clocks before place and route."""
    return [{"name": name, "target_mhz": mhz} for name, mhz in clock_targets(design).items()]


def _check_clocks(best, seeds):
    """Raise InputError if the best place-and-route run does not meet timing."""
    for clock in best.clocks:
        if clock.slack < 0:
            raise InputError(
                f"the clock {clock.name} reaches {clock.achieved_mhz:.1f} of "
                f"{clock.target_mhz:.1f} MHz in the best of {seeds} seeds: more --seeds, or a "
                f"smaller network or interpolation, may fit")


def _report(best, runs, bits):
    return {
        "clocks": [vars(clock) for clock in best.clocks], **resources(best),
        "seeds": [{"seed": one.seed, "slack": one.slack,
                   "clocks": [vars(clock) for clock in one.clocks]} for one in runs],
        "seed": best.seed, "bitstream_bytes": len(bits)}


def print_implemented(report, board, output):
    """Print what was made in the folder ``output``, and how to use it."""
    name = project_name(board)
    if "cells" in report:
        cells = report["cells"]
        print(f"{cells['LUT4']} LUT4, {cells['TRELLIS_FF']} flip-flops, "
              f"{cells.get('MULT18X18D', 0)} multipliers, {cells['DP16KD']} block RAMs, before "
              f"place and route")
        print(f"nextpnr-ecp5 {' '.join(nextpnr_options(board.device))} --json "
              f"{output / name}.json --lpf {output / name}.lpf --textcfg {output / name}.config")
        return
    print("least slack of a clock: " + ", ".join(
        f"{100 * one['slack']:.0f} % with seed {one['seed']}" for one in report["seeds"]))
    print(f"{report['lut']} LUTs, {report['ff']} flip-flops, {report['dsp']} multipliers, "
          f"{report['ram_blocks']} block RAMs; seed {report['seed']}")
    print(f"{output / name}.bit: {report['bitstream_bytes']} bytes, in {report['seconds']:.0f} s; "
          f"openFPGALoader -b {board.name} {output / name}.bit")
