"""Formal proofs of the CSI-2 receiver (docs/evidence/proofs.md): covers and planted errors."""

import pytest

from formal.csi2 import Bursts, Headers
from formal.sby import FAIL, PASS, run
from ncdc_hdl.camera.csi2 import header
from ncdc_hdl.camera.csi2.header import HeaderDecoder


class Believes(HeaderDecoder):
    """Takes every odd syndrome for that of one wrong bit of the 24 or the six."""

    @staticmethod
    def _single(low, high):
        return low.xor()


class Trusts(HeaderDecoder):
    """Does not look at the two zeros above the code."""

    @staticmethod
    def _single(low, high):
        return HeaderDecoder._single(low, high & 0)


@pytest.mark.longer
def test_holds(tmp_path):
    assert run(Headers(), tmp_path, mode="prove", depth=4) == (PASS, set())


def test_is_reached(tmp_path):
    assert run(Headers(), tmp_path, mode="cover", depth=4) == (
        PASS, {"none_wrong", "one_wrong", "two_wrong"})


@pytest.mark.parametrize("kind,rule", [(Believes, "two_are_reported"),
                                       (Trusts, "one_is_corrected")])
def test_planted_error_is_found(kind, rule, tmp_path):
    status, names = run(Headers(kind), tmp_path, mode="bmc", depth=4, only=rule)
    assert status == FAIL and {name.rpartition(".")[2] for name in names} == {rule}


def test_a_wrong_column_is_found(tmp_path, monkeypatch):
    columns = list(header._COLUMNS)
    columns[7], columns[8] = columns[8], columns[7]
    monkeypatch.setattr(header, "_COLUMNS", columns)
    status, names = run(Headers(), tmp_path, mode="bmc", depth=4, only="handed_on")
    assert status == FAIL and {name.rpartition(".")[2] for name in names} == {"handed_on"}


@pytest.mark.longer
def test_bursts_are_apart(tmp_path):
    assert run(Bursts(), tmp_path, mode="bmc", depth=20) == (PASS, set())


@pytest.mark.longer
def test_bursts_are_reached(tmp_path):
    assert run(Bursts(), tmp_path, mode="cover", depth=20) == (
        PASS, {"skew", "dropped", "second_burst"})


@pytest.mark.longer
def test_a_gap_that_is_too_short_is_found(tmp_path):
    status, names = run(Bursts(1), tmp_path, mode="bmc", depth=20, only="apart")
    assert status == FAIL and {name.rpartition(".")[2] for name in names} == {"apart"}
