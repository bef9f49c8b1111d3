"""A checker of timing constraints: what a project leaves open, or cuts that it must not."""

import re
from fnmatch import fnmatchcase

__all__ = ["complaints", "unlimited"]

_COLLECTION = re.compile(r"<(\w+) ([^>]*)>")
# What a false path may end at, besides the ports without timing: first registers of synchronisers,
# the resets of such. And what it may begin at, if it ends at a clock.
_CUT_TO = ("*altera_std_synchronizer:*|din_s1", "*altera_std_synchronizer*|clrn",
           "*ncdc_processor:processor|*multiregimpl*_regs0*",
           "*ncdc_processor:processor|*ars_cd_eth_*")
_CUT_FROM = ("*:page|values*", "*:balance|offered*", "*:jtag|request*", "*:jtag|answer*")


class _Sdc:
    """The calls of an .sdc, as ``tcl/record.tcl`` prints them, with the ports of the top."""

    def __init__(self, calls, ports):
        self.calls, self.ports = [call for call in calls if not call[0].startswith("get_")], ports

    def of(self, command):
        return [call[1:] for call in self.calls if call[0] == command]

    def found(self, word):
        """Ports that a collection, or a plain name, stands for; patterns that match none."""
        match = _COLLECTION.fullmatch(word)
        if match and match.group(1) != "ports":
            return set(), []
        text = (match.group(2) if match else word).removeprefix("-nowarn")
        patterns = text.strip("{}").split()
        hits = {pattern: {port for port in self.ports if fnmatchcase(port, pattern)}
                for pattern in patterns}
        return set().union(*hits.values()), [p for p, ports in hits.items() if not ports]


def option(words, name):
    """The word after an option, or None."""
    return words[words.index(name) + 1] if name in words else None


def complaints(calls, ports, free, loops):
    """Sentences on what is wrong with the constraints; an empty list if nothing is.

    Parameters
    ----------
    calls : list of list of str
        Of the .sdc.
    ports : dict
        Direction of each port of the top: "input", "output", "inout".
    free : sequence of str
        Patterns of ports without timing.
    loops : dict
        Outputs that each phase-locked loop has, by its instance's name.
    """
    sdc = _Sdc(calls, ports)
    clocks, clock_ports, said = _clocks(sdc, loops)
    delayed, more = _delays(sdc, clocks, clock_ports)
    cut, cuts = _cuts(sdc, free)
    said += more + cuts
    for port, direction in ports.items():
        needed = {"input": {"in"}, "output": {"out"}, "inout": {"in", "out"}}[direction]
        there = {way for way in ("in", "out") for bound in ("-max", "-min")
                 if (port, way, bound) in delayed}
        whole = {way for way in there
                 if {(port, way, "-max"), (port, way, "-min")} <= delayed}
        there_cut = {way for way in ("in", "out") if (port, way) in cut}
        if port in clock_ports and not there | there_cut:
            continue
        if needed - whole - there_cut:
            said.append(f"{port} has no delays and is not named as free")
        if whole & there_cut:
            said.append(f"{port} has delays and is named as free")
    return said


def _clocks(sdc, loops):
    """Names of clocks, the ports that they are at, complaints."""
    names, at, said = [], {}, []
    for command in ("create_clock", "create_generated_clock"):
        for words in sdc.of(command):
            found, missing = sdc.found(words[-1])
            names.append(option(words, "-name"))
            at |= dict.fromkeys(found, names[-1])
            if len(found) != 1 or missing:
                said.append(f"the clock {names[-1]} is at {len(found)} ports")
            if command == "create_generated_clock":
                said += _source(names[-1], option(words, "-source"), loops)
    if len(set(names)) != len(names):
        said.append("two clocks have one name")
    if not sdc.of("derive_pll_clocks") or not sdc.of("derive_clock_uncertainty"):
        said.append("clocks of loops, or their uncertainty, are not derived")
    return set(names), at, said


def _source(name, source, loops):
    """Complaints on what a clock is generated from: an output of a loop that exists."""
    for loop, outputs in loops.items():
        match = re.search(rf"\*{loop}\|(?:auto_generated\|pll1\|clk|general)\[(\d)\]", source or "")
        if match:
            return [] if int(match.group(1)) < outputs else \
                [f"{name} comes of output {match.group(1)} of {loop}, which has {outputs}"]
    return [f"{name} has no source: {source}"]


def _delays(sdc, clocks, clock_ports):
    """{(port, "in" or "out", "-max" or "-min")} with a delay, and complaints."""
    delayed, said = set(), []
    for command, way in (("set_input_delay", "in"), ("set_output_delay", "out")):
        for words in sdc.of(command):
            found, missing = sdc.found(words[-1])
            said += [f"no port is called {pattern}" for pattern in missing]
            clock = option(words, "-clock")
            if clock not in clocks and not clock.startswith("<clocks"):
                said.append(f"{command} names the clock {clock}, which there is not")
            said += [f"{port} is a clock in a data group" for port in found & set(clock_ports)]
            bound = next((bound for bound in ("-max", "-min") if bound in words), None)
            delayed |= {(port, way, bound) for port in found}
    return delayed, said


def _cuts(sdc, free):
    """{(port, "in" or "out")} without timing, and complaints on paths that are cut otherwise."""
    cut, said = set(), []
    said += ["groups of clocks are cut" for _ in sdc.of("set_clock_groups")]
    for words in sdc.of("set_false_path"):
        for end, way in (("-from", "in"), ("-to", "out")):
            word = option(words, end)
            match = _COLLECTION.fullmatch(word or "")
            if not match:
                continue
            kind, pattern = match.group(1), match.group(2).split()[-1].strip("{}")
            if kind == "ports":
                found, missing = sdc.found(word)
                cut |= {(port, way) for port in found}
                said += [f"no port is called {pattern}" for pattern in missing]
                if pattern not in free:
                    said.append(f"{pattern} is cut, and is not named as free")
            elif not (pattern in _CUT_TO and end == "-to" or pattern in _CUT_FROM
                      or kind == "clocks" and "-from" in words):
                said.append(f"paths {end[1:]} {pattern} are cut")
    return cut, said


def unlimited(calls, counters, period):
    """Pairs of ``counters`` whose bits may cross apart by a period, in ns, or more.

    What bounds them is the delay of their routes: of what is cut as well nothing else counts.
    """
    limits = {}
    for words in _Sdc(calls, {}).of("set_net_delay"):
        pair = tuple(_COLLECTION.fullmatch(option(words, end)).group(2) for end in ("-from", "-to"))
        limits[tuple(pattern.strip("{}") for pattern in pair)] = float(option(words, "-max"))
    return [pair for pair in counters if limits.get(pair, period) >= period]
