"""Formal proofs of the bridges to AXI (docs/evidence/proofs.md): covers and planted errors."""

import pytest
from amaranth import Const

from cases import cases
from formal.axi import Accesses, Reads, Writes
from formal.sby import FAIL, PASS, run
from ncdc_hdl.axi.lite_bridge import LiteBridge
from ncdc_hdl.axi.read_bridge import ReadBridge
from ncdc_hdl.axi.write_bridge import WriteBridge


class ReadsAcross(ReadBridge):
    """Sees the end of a page a word too late."""

    def _to_end(self, address):
        return super()._to_end(address) + 1


class WritesAcross(WriteBridge):
    """Sees the end of a page a word too late."""

    def _to_end(self, address):
        return super()._to_end(address) + 1


class OneTooMany(WriteBridge):
    """Lets one burst too many begin."""

    def _answers(self, m, begun, whole):
        super()._answers(m, begun, whole)
        return Const(1)


class AnswersEach(WriteBridge):
    """Answers each part of a burst as if it were one."""

    def _answers(self, m, begun, whole):
        return super()._answers(m, begun, Const(1))


class NotAgain(LiteBridge):
    """Waits for a word of before a reset of the agent."""

    @staticmethod
    def _forgotten(reset):
        return Const(0)


PROOFS = {"reads": Reads, "writes": Writes, "accesses": Accesses}
COVERS = {"reads": (Reads, 14, {"crosses", "full", "forgotten"}),
          "writes": (Writes, 16, {"crosses", "full", "words_first", "forgotten",
                                  "first_part_failed"}),
          "accesses": (Accesses, 16, {"asked_again", "rejected", "both"})}


def planted(design, *registers):
    """``design`` whose reset clears these registers of the bridge."""
    design.forgotten = [(name,) for name in registers]
    return design


# (design, depth, the rule that it breaks)
PLANTED = {
    "reads across a page": (lambda: Reads(ReadsAcross), 8, "ar_in_page"),
    "writes across a page": (lambda: Writes(WritesAcross), 8, "aw_in_page"),
    "a reset takes a burst back": (lambda: planted(Reads(), "offered"), 8, "ar_held"),
    "a reset forgets what is owed": (lambda: planted(Reads(), "owed"), 10, "owed_is_known"),
    "a reset takes a word back": (lambda: planted(Writes(), "offered"), 8, "w_held"),
    "a reset forgets the burst": (lambda: planted(Writes(), "piece"), 10, "as_many_as_named"),
    "too many bursts": (lambda: Writes(OneTooMany), 16, "addresses_are_known"),
    "an answer too many": (lambda: Writes(AnswersEach), 12, "no_answer_lost"),
    "a failure that is forgotten": (lambda: planted(Writes(), "spoiled"), 14,
                                    "failure_is_reported"),
    "a word that the agent forgot": (lambda: Accesses(NotAgain), 12, "owed"),
}


@pytest.mark.longer
@pytest.mark.parametrize("design", PROOFS.values(), ids=PROOFS)
def test_holds(design, tmp_path):
    assert run(design(), tmp_path, mode="prove", depth=3) == (PASS, set())


@pytest.mark.parametrize("design,depth,names", cases(COVERS, longer=["writes"]))
def test_is_reached(design, depth, names, tmp_path):
    assert run(design(), tmp_path, mode="cover", depth=depth) == (PASS, names)


@pytest.mark.parametrize("design,depth,rule", cases(PLANTED, longer=PLANTED.keys() - {
    "a reset forgets what is owed", "a reset forgets the burst", "a word that the agent forgot"}))
def test_planted_error_is_found(design, depth, rule, tmp_path):
    status, names = run(design(), tmp_path, mode="bmc", depth=depth, only=rule)
    assert status == FAIL and {name.rpartition(".")[2] for name in names} == {rule}
