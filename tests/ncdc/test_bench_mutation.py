"""``ncdc bench mutation`` on a small counter: faults that a bench finds, and those of a hole in it.
"""

import json
import random
import tempfile

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc.cli import main
from ncdc_bench.mutation.designs import Bench, Design, PlayedBench, designs
from ncdc_bench.mutation.equivalence import equivalents
from ncdc_bench.mutation.mutants import mutate
from ncdc_bench.mutation.page import REPORT
from ncdc_bench.mutation.reasons import explained
from ncdc_bench.mutation.score import BrokenBench, judge, row_of, summary, trial
from ncdc_sim.runner import build, command_of
from ncdc_sim.runner import run as run_program
from ncdc_sim.transcript import Transcript
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
    def run_it(verilog, transcripts):
        program = build("counter", "clocked", [("bench.v", BENCH), ("counter.v", verilog)],
                        simulator="icarus", defines={"CLEARS": int(clears)})
        lines = []
        with tempfile.TemporaryDirectory() as folder:
            run_program(command_of(program), folder, lines.append)
        assert "RESULT wrong 0" in lines
        if checks:
            transcripts.append(Transcript(tuple(command_of(program)), {}, tuple(lines), {}))
    return PlayedBench(name, run_it)


def played(script, lines=(), written=None):
    """A bench of one simulation, which is a ``script`` of the shell."""
    return PlayedBench("played", lambda verilog, transcripts: transcripts.append(
        Transcript(("sh", "-c", script, "sh", "+clock_limit=9000"), {}, lines, written or {})))


COUNTER = Design("counter", "counter", Counter, ())


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
    mutated = mutate(Counter, "counter", per_module=12)
    with trial(COUNTER, bench("strict"), mutated.verilog) as strict:
        for one in verdicts:
            if one.by == "equivalent":
                assert strict.difference(one.mutant.number) is None
                proved = equivalents(mutated.netlist, [one.mutant]) == {one.mutant.number}
                assert proved or not one.mutant.live


@pytest.mark.parametrize("kind", [Bench, PlayedBench])
def test_a_bench_that_fails_without_a_mutant_is_rejected(kind):
    def broken(verilog, _):
        raise AssertionError("the golden picture is wrong")

    with pytest.raises(BrokenBench, match="'broken' of counter fails without a mutant: the golden"):
        trial(COUNTER, kind("broken", broken), "")


def test_a_bench_that_differs_from_run_to_run_is_rejected():
    with pytest.raises(BrokenBench, match="'played' of counter does not run twice the same"):
        trial(COUNTER, played("echo 2", ("1",)), "")


MUTANT_2 = 'case "$*" in *mutant_select=2) %s;; *) %s;; esac'


@pytest.mark.parametrize("script,difference", [
    ("echo 2", "'2' instead of '1'"), ("echo 1; echo 1", "'1' instead of 'no line'"),
    ("true", "no line '1'"), ("echo 1; exit 6", "the simulation ends with status 6"),
    ("echo 1; printf 12 > out", "out differs")])
def test_what_a_mutant_changes_is_found(script, difference):
    right = "echo 1; printf 11 > out"
    with trial(COUNTER, played(MUTANT_2 % (script, right), ("1",), {"out": b"11"}), "") as made:
        assert made.difference(1) is None
        assert made.difference(2) == difference


def test_a_mutant_that_hangs_has_few_clocks_more_than_the_design():
    script = MUTANT_2.replace("mutant_select=2", "clock_limit=164*")
    with trial(COUNTER, played(script % ("echo RESULT total_clocks 100", "echo hangs"),
                                ("RESULT total_clocks 100",)), "") as made:
        assert made.difference(1) is None


@pytest.mark.parametrize("script,error", [("printf 1 > out", OSError), ("true", OSError),
                                          ("kill -9 $$", MemoryError)])
def test_a_bench_without_room_on_the_disk_or_memory_kills_nothing(script, error):
    right = "printf 11 > out"
    with trial(COUNTER, played(MUTANT_2 % (script, right), (), {"out": b"11"}), "") as made:
        with pytest.raises(error):
            made.difference(2)


def test_a_bench_that_runs_anew_kills_by_failing_but_not_by_a_full_disk():
    def run_it(verilog, more):
        if more == ("+mutant_select=2",):
            raise AssertionError("pixel 3")
        if more == ("+mutant_select=3",):
            raise OSError("no space left on device")

    with trial(COUNTER, Bench("anew", run_it), "") as made:
        assert (made.difference(1), made.difference(2)) == (None, "pixel 3")
        with pytest.raises(OSError, match="no space left"):
            made.difference(3)


def test_modules_that_are_skipped_stay_in_the_netlist():
    """Nothing is judged, nothing is built anew: not even the bench runs."""
    assert list(judge(COUNTER, per_module=2, skipped={"counter"})) == []


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
    (["--proof-seconds", "-1"], "the seconds for proofs are -1.0, the least is 0"),
    (["--model", "--proof-seconds", "0"], "--proof-seconds is given, --model does not support it"),
    (["--model", "--survivors"], "--survivors is given, --model does not support it"),
    (["--model", "--module", "lens"], "the module is lens, one of picture")])
def test_wrong_arguments(arguments, message, capsys):
    assert main(["bench", "mutation", *arguments]) == 2
    assert message in capsys.readouterr().err


SEED = 7        # of the modules that are judged again
SAMPLE = 3


def recorded_sample():
    """Some rows of the report, each of another design."""
    rows = json.loads(REPORT.read_text())["rows"]
    rng, found = random.Random(SEED), {}
    for row in rng.sample(rows, len(rows)):
        found.setdefault(row["design"], row)
    return list(found.values())[:SAMPLE]


@pytest.mark.regress
@pytest.mark.parametrize("row", recorded_sample(),
                         ids=lambda row: f"{row['design']}, {row['module']}")
def test_no_score_is_below_the_recorded_one(row):
    """The same mutants of a module, by the benches as they are now."""
    report = json.loads(REPORT.read_text())
    [verdicts] = judge(designs()[row["design"]], per_module=report["per_module"],
                       seed=report["seed"], modules=[row["module"]])
    found = explained({"design": row["design"]} | row_of(verdicts))
    assert found["mutants"] == row["mutants"] and found["score"] >= row["score"], (
        found["survivors"], row["survivors"])
