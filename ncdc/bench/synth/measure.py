"""Rows of ``ncdc bench synth``: each block through each open flow, kept by what it depends on."""

import inspect
import json
from statistics import median

from ncdc.bench.synth.blocks import component
from ncdc.bench.synth.ecp5_netlist import adder_inputs, multiplier_registers, output_registers
from ncdc.bench.synth.flows import (
    SCRIPTS,
    Registered,
    cyclone_iv,
    cyclone_v,
    ecp5,
    ecp5_netlist,
    tool_versions,
)
from ncdc_hdl.export.verilog import module_verilog
from ncdc_sim.builds import cached, key_of

__all__ = ["TARGETS", "WORSE", "block_rows", "regressions"]

TARGETS = ("ecp5", "cyclonev", "cycloneiv")
WORSE = 0.05            # by which a figure may be worse than the table of the documentation

_MULTIPLIER_BITS = {"ecp5": 18, "cyclonev": 27, "cycloneiv": 18}
_FLOWS = {"ecp5": ecp5, "cyclonev": cyclone_v, "cycloneiv": cyclone_iv}
_NETLIST_PARTS = (ecp5_netlist, output_registers, multiplier_registers, adder_inputs)
# Names in rows of what the flows call otherwise.
_NAMES = {"ecp5": {"dsp": "multipliers_18x18", "ram_blocks": "block_rams"},
          "cyclonev": {"lut": "alut", "ff": "alm_ff", "ram_blocks": "m10k"},
          "cycloneiv": {"dsp": "multipliers_18x18", "ram_blocks": "m9k"}}
_LARGER_IS_WORSE = ("alm", "lut", "ff", "dsp", "ram_blocks")


def block_rows(block, variant, targets=TARGETS, seeds=1, progress=lambda step: None):
    """Figures of one block, a row for each target.

    Only what depends on changed Verilog, another flow or other tools is run; all else comes from
    the folder of compiled simulations. The clock is that of the block between registers of its
    own; the sizes of the Cyclones are those of the block alone, of ECP5 with these registers.

    Parameters
    ----------
    block, variant : str
        Of ``ncdc.bench.synth.blocks.BLOCKS``.
    targets : sequence of str
        Of :data:`TARGETS`.
    seeds : int
        Placements on ECP5; the median clock counts.
    progress : callable
        Called with the name of each step.

    Returns
    -------
    list of dict
        ``block``, ``variant``, ``target``, ``multiplier_bits``, ``alm``, ``lut``, ``ff``, ``dsp``,
        ``ram_blocks``, ``fmax_mhz``, ``fmax_seeds_mhz``, ``seeds``; None for what a flow does
        not tell.

    Raises
    ------
    InputError
        If a tool is not installed.
    SynthesisError
        If one fails.
    """
    rows = []
    for target in targets:
        progress(f"{target}: Verilog")
        bits = _MULTIPLIER_BITS[target]
        part = component(block, variant, bits)
        if target == "ecp5":
            verilog = module_verilog(Registered(part, outputs=True), "block")
            runs = [_kept(target, verilog, progress, seed) for seed in range(1, seeds + 1)]
            clocks = [run["fmax_mhz"] for run in runs]
            figures = runs[0] | {"fmax_mhz": round(median(clocks), 1), "fmax_seeds_mhz": clocks}
        else:
            figures = _kept(target, module_verilog(part, "block"), progress)
        names = _NAMES[target]
        rows.append({"block": block, "variant": variant, "target": target, "multiplier_bits": bits}
                    | {name: figures.get(names.get(name, name))
                       for name in (*_LARGER_IS_WORSE, "fmax_mhz", "fmax_seeds_mhz")}
                    | {"seeds": seeds if target == "ecp5" else None})
    return rows


def _kept(target, verilog, progress, seed=None):
    """What the flow of ``target`` finds for module ``block`` of ``verilog``, run only once."""
    flow = _FLOWS[target]
    parts = [inspect.getsource(flow), *SCRIPTS.get(target, ())]
    options = {"progress": progress}
    if seed is not None:
        parts += [*map(inspect.getsource, _NETLIST_PARTS), str(seed)]
        options |= {"seeds": (seed,), "make_netlist": _kept_netlist}

    def build(folder):
        (folder / "figures.json").write_text(json.dumps(flow(verilog, "block", **options)))
    key = key_of(f"synth-{target}", verilog, repr(tool_versions()), *parts)
    return json.loads((cached(key, build) / "figures.json").read_text())


def _kept_netlist(verilog, top, *, progress):
    """:func:`ecp5_netlist`, run only once for all seeds."""
    def build(folder):
        (folder / "netlist.json").write_text(ecp5_netlist(verilog, top, progress=progress))
    key = key_of("synth-netlist", verilog, top, repr(tool_versions()),
                 *map(inspect.getsource, _NETLIST_PARTS))
    return (cached(key, build) / "netlist.json").read_text()


def regressions(rows, baseline):
    """A sentence for each figure of ``rows`` that is more than :data:`WORSE` worse than in the
    rows ``baseline``; rows that it lacks are no regression."""
    before = {(row["block"], row["variant"], row["target"]): row for row in baseline}
    worse = []
    for row in rows:
        name = row["block"], row["variant"], row["target"]
        old = before.get(name, {})
        for key in (*_LARGER_IS_WORSE, "fmax_mhz"):
            if row[key] is None or old.get(key) is None:
                continue
            limit = old[key] * (1 - WORSE if key == "fmax_mhz" else 1 + WORSE)
            if row[key] < limit if key == "fmax_mhz" else row[key] > limit:
                worse.append(f"{', '.join(name)}: {key} is {row[key]}, the limit is {limit:.1f}")
    return worse
