"""The SDRAM controller on random traffic, and the chip's model that checks its commands.

The model is checked itself: each of its rules is seen to fire, and LiteDRAM's controller, which we
did not write, works with it and keeps its rules.
"""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from ncdc_boards.sdram.banks import Banks
from ncdc_boards.sdram.chips import (
    AS4C16M16SA_6,
    AS4C16M16SA_7,
    IS42S16320D_7,
    MT48LC16M16A2_75,
    ULX3S_32MB,
    clocks_of,
    in_parallel,
)
from ncdc_boards.sdram.controller import SdramController
from ncdc_boards.sdram.init_refresh import InitRefresh
from ncdc_boards.sdram.segments import Segments
from ncdc_boards.sdram.write_words import WriteWords
from ncdc_sim.runner import HDL, build_bench
from ncdc_sim.sdram import (
    ALONE,
    ANYWHERE,
    CORRECTOR,
    ONWARDS,
    SILENT,
    Host,
    chip_parameters,
    run_sdram,
    sdram_results,
)
from ncdc_spec.builds import built, key_of

SUPPORT = Path(__file__).resolve().parents[1] / "support"
OFF = Host(SILENT)
BUSY = [Host(ANYWHERE, 60, 1, 8), Host(CORRECTOR, 60, 2, 4), Host(ONWARDS, 150, 16, 16),
        Host(ONWARDS, 150, 1, 16)]
# Name: chip, Hz, bits of a word.
CONTROLLERS = {"16 bits": (AS4C16M16SA_6, 133e6, 32),
               "two side by side": (in_parallel(IS42S16320D_7, 2), 100e6, 32),
               "words of four beats": (IS42S16320D_7, 142e6, 64),
               "any chip": (ULX3S_32MB, 100e6, 16)}


def controller(name="16 bits", reads=3, **options):
    """A controller of :data:`CONTROLLERS`, and its clock. The chip's pause is 2 us."""
    chip, clock_hz, data_width = CONTROLLERS[name]
    return SdramController(replace(chip, pause=2), clock_hz, data_width, reads, 16,
                           **options), clock_hz


def outcome(made, hosts, clocks, **settings):
    made, clock_hz = made
    return run_sdram(made, hosts, clocks=clocks, clock_hz=clock_hz, **settings)


def assert_clean(result):
    assert not result["rules"] and (result["violations"], result["port_errors"]) == (0, 0)
    assert result["wrong"] == 0 and result["checked"] >= result["unsure"]


@pytest.mark.parametrize("simulator,name,clocks,resets", [
    pytest.param("verilator", "16 bits", 200_000, 0, marks=pytest.mark.longer),
    ("verilator", "16 bits", 100_000, 3000),
    ("icarus", "two side by side", 4000, 0), ("icarus", "words of four beats", 3000, 0),
    ("icarus", "any chip", 3000, 1500)])
def test_words_and_commands(simulator, name, clocks, resets):
    result = outcome(controller(name), BUSY, clocks, simulator=simulator, resets=resets)
    assert_clean(result)
    assert result["refreshes"] * clocks_of(CONTROLLERS[name][0], CONTROLLERS[name][1]).refresh \
        > clocks
    assert all(words > clocks / 1000 for words in result["words"])
    assert result["resets"] > (clocks / 10_000 if resets else 0)


@pytest.mark.regress
@pytest.mark.parametrize("resets", (0, 5000))
@pytest.mark.parametrize("name", CONTROLLERS)
def test_ten_million_clocks(name, resets):
    """Longer than the 64 ms in which all rows must be refreshed: `retention` counts."""
    result = outcome(controller(name), BUSY, 10_000_000, resets=resets, seed=2)
    assert_clean(result)
    assert resets or result["refreshes"] > 8192


@pytest.mark.parametrize("host,hosts", [
    ("read", [Host(ANYWHERE, ALONE, 16, 16), *[Host(ANYWHERE, 0, 16, 16)] * 3]),
    ("video", [*[Host(ANYWHERE, 0, 16, 16)] * 2, Host(ANYWHERE, ALONE, 16, 16),
               Host(ANYWHERE, 0, 16, 16)]),
    ("write", [*[Host(ANYWHERE, 0, 16, 16)] * 3, Host(ANYWHERE, ALONE, 16, 16)])])
def test_no_host_waits_longer_than_the_bound(host, hosts):
    """With all others asking for whole bursts anywhere, in each clock."""
    made = controller()
    result = outcome(made, hosts, 60_000)
    assert_clean(result)
    index = {"read": 0, "video": 2, "write": 3}[host]
    assert 100 < result["longest"][index] <= made[0].bounds[host]
    assert min(result["words"]) > 30


# (hosts, least share of clocks with data at 16 bits and 133 MHz), see docs/reference/sdram.md.
SHARES = {
    "bursts of 2 to 4 words of a picture": ([*[Host(CORRECTOR, 0, 2, 4)] * 2, OFF, OFF], .85),
    "a camera's bursts of 16": ([OFF, OFF, OFF, Host(ONWARDS, 0, 16, 16)], .97),
    "video's bursts of 16": ([OFF, OFF, Host(ONWARDS, 0, 16, 16), OFF], .97),
    "bursts of 16 anywhere": ([OFF, OFF, Host(ANYWHERE, 0, 16, 16), OFF], .9),
    "all at once": ([*[Host(CORRECTOR, 0, 2, 4)] * 2, *[Host(ONWARDS, 0, 16, 16)] * 2], .8)}


@pytest.mark.parametrize("hosts,least", SHARES.values(), ids=SHARES)
def test_share_of_clocks_with_data(hosts, least):
    result = outcome(controller(), hosts, 40_000)
    assert_clean(result)
    assert result["beats"] / 40_000 > least


def test_latency_is_what_it_says():
    """A word alone, of a row that is open or not: rows of its bank are closed before, at most."""
    made, clock_hz = controller()
    result = outcome((made, clock_hz), [Host(ANYWHERE, ALONE, 1, 1), OFF, OFF, OFF], 40_000)
    times = made.sequencer.banks.times
    refresh = made.sequencer.delay + made.clocks.rfc
    assert made.latency <= result["longest"][0] <= (
        made.latency + times["rp"] + times["rcd"] + 2 + refresh)
    # Between two refreshes all words but the first of a row find it open.
    quick = outcome((made, clock_hz), [Host(ONWARDS, 0, 1, 1), OFF, OFF, OFF], 40_000,
                    times={"REFRESH_GAP": 10**9})
    assert quick["beats"] > 40_000 * .5


# A time of the chip that is longer than the controller knows: the rule that must fire. The
# controller's own steps leave more than tRRD and tMRD, and its registers come after the pause.
SLOWER = {"RCD": "tRCD", "RP": "tRP", "RAS": "tRAS-min", "RC": "tRC", "RFC": "tRFC", "WR": "tWR",
          "RRD": "tRRD", "MRD": "tMRD", "PAUSE": "tPAUSE", "REFRESH_GAP": "refresh-gap",
          "CAS3": "mode", "RAS_MAX": "tRAS-max"}
MORE = {"RRD": 4, "MRD": 8, "PAUSE": 10}        # clocks by which it must be longer to be seen


# A rule of a command each, one of refreshes, one of the mode; the others in `make regress`.
@pytest.mark.parametrize("name,rule", [
    pytest.param(name, rule, marks=[] if name in {
        "RCD", "RP", "RC", "WR", "REFRESH_GAP", "CAS3"} else [pytest.mark.regress])
    for name, rule in SLOWER.items()])
def test_a_chip_that_is_slower_by_a_clock_is_seen(name, rule):
    made, clock_hz = controller("16 bits")
    period, clocks = 1e12 / clock_hz, made.clocks
    own = {"RAS": made.sequencer.banks.times["ras"], "PAUSE": clocks.pause, "CAS3": 1,
            "RC": made.sequencer.banks.times["ras"] + clocks.rp}
    count = own.get(name) or getattr(clocks, name.lower(), 0)
    time = {"REFRESH_GAP": int(made.sequencer.period * period),
            "RAS_MAX": int(20 * period)}.get(
                name, int((count + MORE.get(name, 0)) * period) + 100)
    result = outcome((made, clock_hz), [Host(ANYWHERE, 0, 1, 2)] * 4, 20_000, times={name: time})
    assert rule in result["rules"]
    assert result["rules"] <= {rule, *({"tRC"} if name in ("RAS", "RP") else {})}


@pytest.mark.longer
@pytest.mark.parametrize("cycles,seen", [(16, set()), (20, {"retention"})])
def test_rows_that_are_refreshed_too_seldom_are_seen(cycles, seen):
    """So many refreshes reach every row, within the time of 16."""
    chip, clock_hz, data_width = CONTROLLERS["16 bits"]
    chip = replace(chip, pause=2, refresh_cycles=cycles)
    made = SdramController(chip, clock_hz, data_width, 3, 16)
    result = run_sdram(made, BUSY, clocks=40_000, clock_hz=clock_hz,
                       times={"RETENTION": 16 * int(1000 * chip.refresh)})
    assert result["rules"] == seen


def shorter(**times):
    """``Banks.times`` with some of them a clock shorter."""
    own = Banks.times.fget
    return property(lambda self: (plain := own(self)) | {
        name: plain[name] - by for name, by in times.items()})


# Errors planted in the controller: (class, attribute, what replaces it, what must be seen).
PLANTED = {
    "tRCD": (Banks, "times", shorter(rcd=1), "tRCD"),
    "tRP": (Banks, "times", shorter(rp=1), "tRP"),
    "tRAS": (Banks, "times", shorter(ras=1), "tRAS-min"),
    "tWR": (Banks, "times", shorter(write_precharge=1), "tWR"),
    "tRFC": (Banks, "times", shorter(rfc=1), "tRFC"),
    "turn of DQ": (Banks, "times", shorter(read_write=1), "contention"),
    "read cut off": (Banks, "times", shorter(read_precharge=2), "cut"),
    "another row": (Banks, "_other", lambda self, opened, row: 0, "wrong"),
    "row's end": (Segments, "_crosses", staticmethod(lambda end: 0), "wrong"),
    "written before it is read": (SdramController, "_owed", lambda self, bursts, written: 0,
                                  "wrong"),
    "queue of words": (WriteWords, "_full", lambda self, level: 0, "wrong"),
    "refresh": (InitRefresh, "elaborate", None, "refresh-gap")}
QUICK = ("tRCD", "turn of DQ", "another row", "written before it is read")


@pytest.mark.parametrize("kind,attribute,wrong,seen", [
    pytest.param(*case, id=name, marks=[] if name in QUICK else [pytest.mark.regress])
    for name, case in PLANTED.items()])
def test_planted_error_is_seen(kind, attribute, wrong, seen, monkeypatch):
    made, clock_hz = controller("words of four beats" if attribute == "times" and seen == "cut"
                                else "16 bits")
    if wrong is None:
        made.sequencer.init_refresh.period += made.sequencer.delay
    else:
        monkeypatch.setattr(kind, attribute, wrong)
    hosts = [Host(ANYWHERE, 0, 1, 2)] * 3 + [Host(ANYWHERE, 0, 1, 16)]
    result = outcome((made, clock_hz), hosts, 6000, simulator="icarus")
    assert result["wrong"] if seen == "wrong" else seen in result["rules"]


def litedram(chip, name, **times):
    """Results of LiteDRAM's controller for its chip ``name`` before our model of ``chip``."""
    pytest.importorskip("litedram")
    script = SUPPORT / "litedram_sdr.py"

    def generate(folder):
        done = subprocess.run([sys.executable, "-W", "ignore", script, name, "100"], text=True,
                              capture_output=True, check=True)
        (folder / "litedram.v").write_text(done.stdout)

    made = built(key_of("litedram-sdr", name, script.read_text()), generate)
    # LiteDRAM rounds the time between refreshes up, and lets no clock pass between read and
    # written data.
    parameters = chip_parameters(replace(chip, pause=2), 100e6, STORED=3, TURNAROUND=0,
                                 REFRESH_GAP=2 * int(1000 * chip.refresh))
    text = (SUPPORT / "hdl/sdram_litedram.v").read_text().replace(
        "CHIP_PARAMETERS) chip", ", ".join(f".{key}({value})" for key, value in
                                           parameters.items()) + ") chip")
    program = build_bench("sdram-litedram", "sdram_bench", [
        ("litedram.v", (made / "litedram.v").read_text()), ("sdram_litedram.v", text),
        ("sdram_chip.v", (HDL / "sdram_chip.v").read_text())],
        optimise="-O0", options=("-Wno-fatal", "-Wno-COMBDLY"))
    return sdram_results(program, {"rounds": 300} | times)


@pytest.mark.longer
def test_litedram_works_with_the_chip_and_keeps_its_rules():
    results = litedram(MT48LC16M16A2_75, "MT48LC16M16")
    assert (results["violations"], results["wrong"], results["rules"]) == (0, 0, set())
    assert results["checked"] == 300 * 64 and results["refreshes"] > 100
    # Its clocks are 2 for tRCD and tRP: a slower chip is seen.
    slow = litedram(MT48LC16M16A2_75, "MT48LC16M16", RCD=21000, RP=21000)
    assert slow["rules"] == {"tRCD", "tRP"}


@pytest.mark.regress
def test_litedram_with_a_chip_slower_than_it_thinks():
    """LiteDRAM knows no grades of this chip: tRCD and tRP of grade 7 are 21 ns, not 18."""
    assert {"tRCD", "tRP"} <= litedram(AS4C16M16SA_7, "AS4C16M16")["rules"]
