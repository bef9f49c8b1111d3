"""The tan-sigmoid's Verilog, golden model and exact function compared; ``ncdc bench tansig``."""

import json

import mpmath
import numpy as np
import pytest

from ncdc.cli import main
from ncdc_bench.tansig.accuracy import exact_error, measure
from ncdc_bench.tansig.command import complaint, table
from ncdc_bench.tansig.exhaustive import every_value, pipeline_outputs, scattered
from ncdc_bench.tansig.measure import sampled_inputs, tansig_row, verilog_outputs
from ncdc_bench.tansig.plots import plot_tansig
from ncdc_hdl.neural.tansig import Tansig
from ncdc_spec.errors import InputError
from ncdc_spec.tansig import FRACTION_BITS, VARIANTS, TansigDesign, design_for, tansig

DESIGN = design_for("mmhbc", 20)


class Late(Tansig):
    """Claims one clock more than it takes; its Verilog is the same."""
    latency = property(lambda self: super().latency + 1)


class Planted(TansigDesign):
    """One table entry is larger by one, and the error bound, which sees it, is not asked."""
    bound_ulp = 0.0

    @property
    def table(self):
        entries = list(super().table)
        entries[100] += 1
        return tuple(entries)


@pytest.fixture(scope="module")
def row(tmp_path_factory):
    """The row of ``DESIGN`` as the command reports it, sampled."""
    report = tmp_path_factory.mktemp("bench") / "report.json"
    assert main(["bench", "tansig", "--variant", "mmhbc", "--bits", "20", "--sampled",
                 "--no-synth", "--json", str(report)]) == 0
    rows = json.loads(report.read_text())["rows"]
    assert len(rows) == 1
    return rows[0]


@pytest.mark.longer
def test_sampled_verilog(row):
    assert row["differences"] == 0 and not row["exhaustive"] and row["inputs"] > 65000
    assert row["max_ulp"] <= .79 and row["correctly_rounded"] >= .95
    assert row["odd"] and row["zero"] and row["monotonic"] and row["saturated"]
    assert (row["variant"], row["fraction_bits"], row["multipliers"]) == ("mmhbc", 20, 0)
    assert row["adders"] <= 36 and row["table_bits"] <= 12800
    assert complaint(row) is None


@pytest.mark.parametrize("options,figures", [([], {"lut", "alm"}), (["--no-route"], {"alm"}),
                                             (["--no-synth"], set())])
def test_figures_of_synthesis_can_be_left_out(options, figures, monkeypatch, capsys):
    measured = "ncdc_bench.tansig.measure"
    monkeypatch.setattr("ncdc_bench.tansig.command.check_tools", lambda otherwise: None)
    monkeypatch.setattr(f"{measured}.verilog_outputs", lambda component, n, **_: tansig(n, DESIGN))
    monkeypatch.setattr(f"{measured}.cyclone_v", lambda *_, **__: {"alm": 1})
    monkeypatch.setattr(f"{measured}.synthesise", lambda *_, **__: {"lut": 2, "alm": 1})
    assert main(["bench", "tansig", "--variant", "mmhbc", "--bits", "20", "--sampled", "--json",
                 "-", *options]) == 0
    row, = json.loads(capsys.readouterr().out)["rows"]
    assert {"lut", "alm"} & set(row) == figures


@pytest.mark.longer
def test_comparison_sees_a_stage_out_of_step():
    n = sampled_inputs(DESIGN.input, 1 << 12)
    golden = tansig(n, DESIGN)
    np.testing.assert_array_equal(verilog_outputs(Tansig(DESIGN), n), golden)
    assert (verilog_outputs(Late(DESIGN), n) != golden).mean() > .99


@pytest.mark.many_clocks
@pytest.mark.regress
@pytest.mark.parametrize("bits", FRACTION_BITS)
@pytest.mark.parametrize("variant", VARIANTS)
def test_every_input_of_the_verilog(variant, bits):
    row = tansig_row(design_for(variant, bits), synthesis=False)
    assert row["inputs"] == 1 << 24 and row["exhaustive"]
    assert complaint(row) is None
    assert row["bound_ulp"] <= 1.3 * row["max_ulp"]
    assert row["mse"] < row["mse_ideal"] * (1.3 if bits == 16 else 1.1)
    if (variant, bits) == ("mmhbc", 20):
        assert row["max_ulp"] <= .79 and row["correctly_rounded"] >= .95


@pytest.mark.many_clocks
@pytest.mark.regress
def test_exhaustive_comparison_sees_one_wrong_table_entry():
    wrong = Planted(DESIGN.input, 20, DESIGN.width, DESIGN.region_bits)
    n = every_value(DESIGN.input)
    differs = n[verilog_outputs(Tansig(wrong), n) != tansig(n, DESIGN)]
    # Entry 100 is that of 100/32 <= |n| < 101/32, and an error of 2**-25 shows in few results.
    assert 0 < differs.size < 20000
    assert set((np.abs(differs) >> DESIGN.fine_bits).tolist()) == {100}


def test_doubles_are_as_exact_as_measure_takes_them_to_be():
    rng = np.random.default_rng(3)
    n = np.concatenate([rng.integers(1, DESIGN.input.hi, 1500), np.arange(1, 300)])
    real = np.tanh(DESIGN.input.real(n) / 2)
    with mpmath.workdps(50):
        for k in range(n.size):
            assert abs(real[k] - mpmath.tanh(mpmath.mpf(int(n[k])) / 2**20)) < 2.0**-51


def test_hard_cases_are_decided_exactly():
    # f(n) of n units is n units less a cube: the odd result half a unit below is nearer.
    n = np.arange(1, 12)
    for raw, within in ((2 * n - 1, n.size), (2 * n + 1, 0)):
        accuracy = measure(n, raw, DESIGN)
        assert accuracy.hard_cases == n.size and accuracy.within_half == within
        assert all(abs(exact_error(a, b, DESIGN)) != .5 for a, b in zip(n, raw))


def test_measure_sees_planted_errors():
    n = sampled_inputs(DESIGN.input, 1 << 12)
    raw = tansig(n, DESIGN)
    good = measure(n, raw, DESIGN)
    assert good.odd and good.zero and good.monotonic and good.saturated and good.max_ulp < 1
    k = int(np.searchsorted(n, 1 << 19))

    def planted(index, difference):
        wrong = raw.copy()
        wrong[index] += difference
        return measure(n, wrong, DESIGN)

    worse = planted(k, 4)
    assert worse.max_ulp > 1.2 and worse.worst_input == n[k]
    assert not worse.odd and worse.mse > good.mse
    assert not planted(k, -(1 << 16)).monotonic
    assert not planted(int(np.searchsorted(n, 0)), 2).zero
    assert not planted(-1, -2).saturated


@pytest.mark.parametrize("n, raw", [([2, 1], [1, 1]), ([1, 1], [1, 1]), ([1], [1, 1]), ([], [])])
def test_measure_rejects(n, raw):
    with pytest.raises(ValueError, match="ascending inputs"):
        measure(np.array(n), np.array(raw), DESIGN)


def test_scattered_visits_all_and_keeps_neighbours_apart():
    order = scattered(1 << 16)
    np.testing.assert_array_equal(np.sort(order), np.arange(1 << 16))
    assert np.abs(np.diff(order)).min() > 1 << 10
    with pytest.raises(ValueError, match="count is 12"):
        scattered(12)


def test_sampled_inputs_come_in_pairs():
    n = sampled_inputs(DESIGN.input)
    assert n[0] == DESIGN.input.lo and n[-1] == DESIGN.input.hi
    np.testing.assert_array_equal(n[1:], -n[:0:-1])
    assert set(range(-2, 3)) <= set(n.tolist())


def test_inputs_must_fit_the_port():
    dut = Tansig(DESIGN)
    dut._MustUse__silence = dut.variant._MustUse__silence = True    # never elaborated
    dut.variant.quotient._MustUse__silence = True
    with pytest.raises(InputError, match="8388608 do not fit 24 bits"):
        pipeline_outputs(dut, [0, 1 << 23])


def test_complaints(row):
    assert "3 results differ" in complaint(row | {"differences": 3})
    assert "limits are 1 and" in complaint(row | {"max_ulp": 1.0, "bound_ulp": 1.2})
    assert "bound, 0.7000" in complaint(row | {"max_ulp": .71, "bound_ulp": .7})
    assert complaint(row | {"monotonic": False, "odd": False}).endswith("not odd, not monotonic")


def test_wrong_result_is_exit_status_1(monkeypatch, row, capsys):
    monkeypatch.setattr("ncdc_bench.tansig.command.tansig_row",
                        lambda *args, **options: row | {"differences": 1})
    assert main(["bench", "tansig", "--variant", "mmhbc", "--bits", "20", "--no-synth"]) == 1
    out, err = capsys.readouterr()
    assert err == "ncdc bench tansig: mmhbc at 20 bits: 1 results differ from the golden model\n"
    assert "mmhbc" in out and "MHz" not in out


def test_table(row):
    with_synthesis = row | {"lut": 1580, "ff": 1537, "fmax_mhz": 223.6, "alm": 681}
    head, titles, line = table([with_synthesis]).splitlines()
    assert "sampled" in head and len(titles) == len(line)
    assert line.split()[-4:] == ["1580", "1537", "224", "681"]


@pytest.mark.longer
def test_plots(tmp_path, row):
    plot_tansig(tmp_path, [row, row | {"fraction_bits": 18, "mse": 1.3e-12}])
    names = {path.name: path.stat().st_size for path in tmp_path.iterdir()}
    assert set(names) == {f"tansig-fig{k}.png" for k in (10, 11, 13, 14)}
    assert max(names.values()) < 100000
