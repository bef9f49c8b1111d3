"""The SDRAM controller of two readers, a video reader and a writer, with the chip's model."""

from dataclasses import replace
from functools import cache

from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_boards.sdram.chips import AS4C16M16SA_6
from ncdc_boards.sdram.controller import SdramController
from ncdc_sim.sdram import (
    ALONE,
    ANYWHERE,
    CORRECTOR,
    ONWARDS,
    SDRAM_CONTROLLER,
    SILENT,
    Host,
    run_sdram,
)

__all__ = ["DESIGN"]

_CLOCK_HZ = 133e6
_PAUSE_US = 2           # of the chip's initialisation: that of the data sheet takes 200
_STEPS = 2              # clocks of a few steps of the controller
_OFF = Host(SILENT)
_MIXED = [Host(ANYWHERE, 60, 1, 8), Host(CORRECTOR, 60, 2, 4), Host(ONWARDS, 150, 16, 16),
          Host(ONWARDS, 150, 1, 16)]
_SHORT = [Host(ANYWHERE, 0, 1, 2)] * 3 + [Host(ANYWHERE, 0, 1, 16)]
_WHOLE = Host(ANYWHERE, 0, 16, 16)


def make():
    """The controller, anew: words of two beats."""
    return SdramController(replace(AS4C16M16SA_6, pause=_PAUSE_US), _CLOCK_HZ, 32, 3, 16)


@cache
def controller():
    """The controller, made once, for its figures."""
    return make()


def outcome(hosts, clocks, verilog, transcripts, **settings):
    """Results of a run in which no rule is broken and no word is wrong."""
    result = run_sdram(controller(), hosts, clocks=clocks, clock_hz=_CLOCK_HZ, verilog=verilog,
                       transcripts=transcripts, **settings)
    assert not result["rules"], result["rules"]
    assert (result["violations"], result["port_errors"], result["wrong"]) == (0, 0, 0)
    assert result["checked"] >= result["unsure"]
    assert result["refreshes"] * controller().clocks.refresh > clocks
    pause = controller().clocks.pause
    assert pause < result["ready_first"] < pause + initialisation()
    return result


def initialisation():
    """Clocks that the initialisation takes after the chip's pause, at most."""
    clocks, times = controller().clocks, controller().sequencer.banks.times
    return times["rp"] + controller().chip.refreshes * clocks.rfc + clocks.mrd + _STEPS


def mixed(verilog, transcripts):
    """Each host with pauses of its own; the share of clocks with data."""
    result = outcome(_MIXED, 30_000, verilog, transcripts)
    assert min(result["words"]) > 100
    assert result["beats"] > .8 * 30_000
    period = controller().sequencer.period
    assert result["refreshes"] < 30_000 / period + controller().chip.refreshes + 2


def short(verilog, transcripts):
    """Short bursts anywhere, in each clock: another row nearly always."""
    result = outcome(_SHORT, 15_000, verilog, transcripts, seed=2)
    assert min(result["words"]) > 30


def onwards(verilog, transcripts):
    """Bursts one after the other: a word in nearly each pair of clocks, of each host alone."""
    for k, share in enumerate((.93, .93, .97, .97)):
        hosts = [_OFF] * 4
        hosts[k] = Host(ONWARDS, 0, 16, 16)
        result = outcome(hosts, 4000, verilog, transcripts)
        assert result["beats"] > share * 4000, (k, result["beats"])
    # With short bursts each turn counts: the video reader alone gives none to another host.
    result = outcome([_OFF, _OFF, Host(ONWARDS, 0, 1, 2), _OFF], 3000, verilog, transcripts)
    assert result["beats"] > .6 * 3000, result["beats"]


def waits(verilog, transcripts):
    """A host alone has its word after the least time; one among busy hosts within its bound."""
    made = controller()
    result = outcome([Host(ANYWHERE, ALONE, 1, 1), _OFF, _OFF, _OFF], 4000, verilog, transcripts)
    times, refresh = made.sequencer.banks.times, made.sequencer.delay + made.clocks.rfc
    limit = made.latency + times["rp"] + times["rcd"] + 2 + refresh
    assert made.latency <= result["longest"][0] <= limit
    for index, host in enumerate(("read", "read", "video", "write")):
        hosts = [_WHOLE] * 4
        hosts[index] = Host(ANYWHERE, ALONE, 16, 16)
        result = outcome(hosts, 6000, verilog, transcripts)
        assert result["longest"][index] <= made.bounds[host], (host, result["longest"])


def resets(verilog, transcripts):
    """Resets in the midst of all: what was written well before is still there."""
    result = outcome(_MIXED, 40_000, verilog, transcripts, resets=1200, seed=3)
    assert result["resets"] > 15
    # The content must stay: no pause as after power-up.
    settle = controller().sequencer.init_refresh.settle
    assert 0 < result["ready_longest"] < settle + initialisation()
    # At any time, also in a refresh and in the initialisation.
    result = outcome(_SHORT, 10_000, verilog, transcripts, resets=60, seed=4)
    assert result["resets"] > 100


_RUNS = {"short bursts": short, "mixed hosts": mixed, "one host alone": onwards,
         "waits": waits, "resets": resets}

DESIGN = Design("sdram", SDRAM_CONTROLLER, make,
                tuple(PlayedBench(*item) for item in _RUNS.items()))
