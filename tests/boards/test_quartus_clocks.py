"""Paths between clocks of a Quartus board that are shifted: how much time the shortest one has."""

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from cameras import barrel_descriptor
from ncdc_boards.board import project_name
from ncdc_boards.camera_board.design import design_of, sensor_for
from ncdc_boards.camera_board.ethernet import MODULE
from ncdc_boards.catalogue import board
from ncdc_boards.quartus.plls import REFERENCE_MHZ
from ncdc_boards.quartus.project import top_verilog
from ncdc_boards.quartus.user import user_module
from ncdc_hdl.video.modes import mode_named
from ncdc_soc.board import board_processor
from ncdc_soc.phy.rgmii import RgmiiPhy
from transfers import Edge, Transfer, shortest_ps, transfers

MIN_PS = 3000           # that a register, a route and another register get
DOMAINS = {"clock_sys": "sync", "clock_transmit": "ethernet", "clock_late": "ethernet_late"}
# First registers of synchronisers, and those that end a reset: the constraints cut what ends there.
CUT = r"multiregimpl\d+_regs0|ars_cd_eth_|\beth_[rt]x_rst$|\|din_s1$"


def clocks_of(plan):
    """(period, delay) in ps of each domain of a plan; all loops compare the same oscillator."""
    found = {}
    for domain in plan.targets():
        mhz, late = plan.output(domain)
        mhz = Fraction(*mhz) * REFERENCE_MHZ if isinstance(mhz, tuple) else Fraction(mhz)
        found[domain] = (Fraction(10**6) / mhz, late)
    return found


def processor_transfers(folder):
    made = board_processor(board("de2-115"), 75_000_000)
    texts = {"processor.v": made.text, "core.v": Path(made.core).read_text()}
    return transfers(texts, MODULE, folder,
                     [f"{MODULE}_{name}.init" for name in ("rom", "sram")])


def too_short(found, clocks):
    """Transfers between known clocks that have less than MIN_PS and are not cut."""
    return {one for one in found if {one.launch.clock, one.capture.clock} <= clocks.keys()
            and not re.search(CUT, one.sink)
            and shortest_ps(one.launch, one.capture, clocks) < MIN_PS}


@pytest.fixture(scope="module")
def clocks():
    plan = replace(board("de2-115").clock_plan(mode_named("640x480"), 75), ethernet=True)
    domains = clocks_of(plan)
    return {name: domains[domain] for name, domain in DOMAINS.items()}


@pytest.mark.longer
def test_no_path_of_the_processor_is_shorter_than_3_ns(tmp_path, clocks):
    found = processor_transfers(tmp_path)
    assert too_short(found, clocks) == set()
    late = {(one.launch, one.capture): shortest_ps(one.launch, one.capture, clocks)
            for one in found
            if {one.launch.clock, one.capture.clock} <= set(DOMAINS) - {"clock_sys"}}
    assert late == {
        (Edge("clock_transmit"), Edge("clock_transmit", True)): 4000,
        (Edge("clock_transmit", True), Edge("clock_late")): 6000}


@pytest.mark.longer
def test_bits_made_for_the_late_cell_at_once_are_seen(tmp_path, clocks, monkeypatch):
    """As it was: two nanoseconds for comparators and a route into an output cell."""
    monkeypatch.setattr(RgmiiPhy, "_step_to_late", lambda self, clock: self.sender.clock)
    found = too_short(processor_transfers(tmp_path), clocks)
    assert found and {(one.launch, one.capture) for one in found} == {
        (Edge("clock_transmit"), Edge("clock_late"))}


@pytest.mark.regress
@pytest.mark.parametrize("name,processor", [("de2-115", True), ("de1-soc", False)])
def test_no_path_of_a_whole_board_is_shorter_than_3_ns(tmp_path, name, processor):
    lens = barrel_descriptor((64, 24), (64, 24), hidden_neurons=2, strength=.4)
    design = design_of(board(name), [("a", lens)], sensor_for("mt9p031", lens.geometry),
                       mode_named("640x480"), processor=processor)
    texts, files = {"top.v": top_verilog(design), "user.v": user_module()}, []
    if processor:
        made = board_processor(board(name), 75_000_000)
        texts |= {"processor.v": made.text, "core.v": Path(made.core).read_text()}
        files = [f"{MODULE}_{memory}.init" for memory in ("rom", "sram")]
    found = transfers(texts, project_name(board(name)), tmp_path, files)
    domains = clocks_of(design.clocks)
    clocks = {f"clocks.{loop}[{k}]": domains[domain] for loop, names in
              design.clocks.loops().items() for k, domain in enumerate(names)}
    assert len(found) > 20 and {clock for one in found for clock in (
        one.launch.clock, one.capture.clock)} & clocks.keys()
    assert too_short(found, clocks) == set()


def test_the_de10_nano_has_no_shifted_clock():
    plan = board("de10-nano").clock_plan(mode_named("640x480"), 100)
    assert {plan.output(domain)[1] for domain in plan.targets()} == {0}


@pytest.mark.parametrize("launch,capture,ps", [
    (Edge("a"), Edge("late"), 2000), (Edge("late"), Edge("a"), 6000),
    (Edge("a"), Edge("a", True), 4000), (Edge("a", True), Edge("late"), 6000),
    (Edge("a"), Edge("core"), Fraction(8000, 3)), (Edge("a"), Edge("a"), 8000)])
def test_the_shortest_time_between_two_edges(launch, capture, ps):
    clocks = {"a": (8000, 0), "late": (8000, 2000), "core": (Fraction(40000, 3), 0)}
    assert shortest_ps(launch, capture, clocks) == ps

    # Counted edge by edge, over a time in which all of them repeat.
    def edges(edge):
        period, late = map(Fraction, clocks[edge.clock])
        first = late + (period / 2 if edge.falls else 0)
        return [first + k * period for k in range(40)]

    assert min(b - a for a in edges(launch)[2:12] for b in edges(capture) if b > a) == ps


def test_a_transfer_is_found_through_logic_and_inverters(tmp_path):
    found = transfers({"top.v": """
module top (input a, input b, input d, output reg q);
    wire n = ~a;
    reg first, second;
    always @(posedge a) first <= d;
    always @(posedge n) second <= first;
    always @(negedge b) q <= second ^ first;
endmodule
"""}, "top", tmp_path)
    assert found == {Transfer("first", Edge("a"), "second", Edge("a", True)),
                     Transfer("first", Edge("a"), "q", Edge("b", True)),
                     Transfer("second", Edge("a", True), "q", Edge("b", True))}
