"""``ncdc bench mutation`` on a small counter: faults that a bench finds, and those of a hole in it.
"""

import json
import random

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc.cli import main
from ncdc_bench.mutation.designs import Bench, Design, designs
from ncdc_bench.mutation.equivalence import equivalents
from ncdc_bench.mutation.mutants import mutate
from ncdc_bench.mutation.page import PAGE, REPORT, filled
from ncdc_bench.mutation.score import BrokenBench, judge, row_of, summary
from ncdc_sim.runner import build, results_of
from ncdc_spec.errors import InputError

LIMIT = 11
BENCH = """
module bench (input wire clk);
  reg rst = 1, en = 0, clear = 0;
  reg [3:0] expected = 0;
  integer clocks = 0, wrong = 0, seed = 1;
  wire [3:0] o;
  counter counter (.clk(clk), .rst(rst), .en(en), .clear(clear), .o(o));
  always @(posedge clk) begin
    clocks = clocks + 1;
    if (clocks > 2 && o !== expected) wrong = wrong + 1;
    if (rst || clear) expected = 0;
    else if (en && expected != 11) expected = expected + 1;
    rst <= clocks < 2 || clocks == 70;
    en <= $urandom(seed) % 8 != 0;
    clear <= `CLEARS && $urandom(seed) % 23 == 0;
    if (clocks == 300) begin $display("RESULT wrong %0d", wrong); $finish; end
  end
endmodule
module clocked;
  reg clk = 0;
  bench bench (.clk(clk));
  always #5 clk = ~clk;
endmodule
"""


class Counter(wiring.Component):
    """Counts clocks with ``en`` up to a limit, until ``clear``."""
    en: In(1)
    clear: In(1)
    o: Out(4)

    def elaborate(self, platform):
        m = Module()
        with m.If(self.clear):
            m.d.sync += self.o.eq(0)
        with m.Elif(self.en & (self.o != LIMIT)):
            m.d.sync += self.o.eq(self.o + 1)
        return m


def bench(name, clears=True, checks=True):
    """A bench of the counter; without ``clears`` it never clears, without ``checks`` it is blind.
    """
    def run_it(verilog, more):
        program = build("counter", "clocked", [("bench.v", BENCH), ("counter.v", verilog)],
                        simulator="icarus", defines={"CLEARS": int(clears)})
        results = results_of(program, dict(one.lstrip("+").split("=") for one in more))
        assert not checks or results["wrong"] == 0
    return Bench(name, run_it)


def verdicts_of(*benches, per_module=40):
    [verdicts] = judge(Design("counter", "counter", Counter, benches), per_module=per_module)
    return verdicts


@pytest.mark.longer
def test_a_hole_in_a_bench_is_found():
    """What only a clear shows survives a bench that never clears."""
    verdicts = verdicts_of(bench("never clears", clears=False), bench("clears"))
    last = [one.mutant for one in verdicts if one.by == "clears"]
    assert any("`clear[0]`" in one.change and "test_bench_mutation.py:" in one.line for one in last)
    row = row_of(verdicts)
    assert row["survived"] == 0 and row["killed"] + row["equivalent"] == row["mutants"] == 40
    assert row["killed_by"]["never clears"] > 10


@pytest.mark.longer
def test_a_bench_that_checks_nothing_kills_nothing():
    verdicts = verdicts_of(bench("blind", checks=False), per_module=12)
    row = row_of(verdicts)
    assert row["killed"] == row["score"] == 0 and summary([row])["score"] == 0
    assert len(row["survivors"]) == row["survived"] == row["mutants"] - row["equivalent"] > 6
    # What is called equivalent no bench may kill.
    mutated, strict = mutate(Counter, "counter", per_module=12), bench("strict")
    for one in verdicts:
        if one.by == "equivalent":
            strict.run(mutated.verilog, (f"+mutant_select={one.mutant.number}",))
            proved = equivalents(mutated.netlist, [one.mutant]) == {one.mutant.number}
            assert proved or not one.mutant.live


def test_a_bench_that_fails_without_a_mutant_is_rejected():
    def broken(verilog, more):
        raise AssertionError("the golden picture is wrong")

    with pytest.raises(BrokenBench, match="'broken' of counter fails without a mutant: the golden"):
        verdicts_of(Bench("broken", broken), per_module=2)


def test_a_bench_without_room_on_the_disk_kills_nothing():
    def full(verilog, more):
        if more != ("+mutant_select=0",):
            raise OSError("no space left on device")

    with pytest.raises(OSError, match="no space left"):
        verdicts_of(Bench("full", full), per_module=2)


@pytest.mark.parametrize("report", [
    "[]", '{"seed": 1, "per_module": 40}',
    '{"seed": 1, "per_module": 40, "rows": [{"module": "picture"}]}'])
def test_another_file_is_not_added_to(report, tmp_path, capsys):
    (tmp_path / "other.json").write_text(report)
    assert main(["bench", "mutation", "--add", "--json", str(tmp_path / "other.json")]) == 2
    assert "is no report of this command" in capsys.readouterr().err
    assert (tmp_path / "other.json").read_text() == report


def test_modules_that_there_are_not_are_named():
    with pytest.raises(InputError, match="no_module is no module of counter, it has counter"):
        mutate(Counter, "counter", per_module=2, modules=["no_module"])


@pytest.mark.parametrize("arguments,message", [
    (["--design", "lens"], "the design is lens, one of core"),
    (["--per-module", "0"], "mutants per module are 0, the least is 1"),
    (["--model", "--survivors"], "--survivors is given, --model does not support it"),
    (["--model", "--module", "lens"], "the module is lens, one of picture")])
def test_wrong_arguments(arguments, message, capsys):
    assert main(["bench", "mutation", *arguments]) == 2
    assert message in capsys.readouterr().err


SAMPLE = 3      # modules of the recorded ones that are judged again


@pytest.mark.regress
def test_no_score_is_below_the_recorded_one():
    report = json.loads(REPORT.read_text())
    recorded = random.Random(7).sample(report["rows"], SAMPLE)
    for row in recorded:
        [verdicts] = judge(designs()[row["design"]], per_module=report["per_module"],
                           seed=report["seed"], modules=[row["module"]])
        assert row_of(verdicts)["score"] >= row["score"], row["module"]


def test_the_page_shows_the_report():
    page = PAGE.read_text()
    assert filled(page, json.loads(REPORT.read_text())) == page, (
        "run python -m ncdc_bench.mutation.page, and look at git diff")
