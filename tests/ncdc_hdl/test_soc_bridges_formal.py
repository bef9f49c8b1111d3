"""Proofs of the bridges between our ports and LiteX's."""

import pytest

from cases import cases
from formal.native import NativeReads, NativeWrites, WishboneAccesses
from formal.sby import FAIL, PASS, run
from ncdc_hdl.avalon.native import NativeWriter
from planted_bridges import CommandOnly, Forgets, TooEarly

_WRITE_CLOCKS = 8       # of the bounded proof: the queue of 2 is filled and emptied


class NoSpace(NativeWriter):
    """Does not ask whether there is space for the word."""

    @staticmethod
    def _space(for_command, for_word):
        return for_command


PROOFS = {"reads": (NativeReads, "prove", 3), "writes": (NativeWrites, "bmc", _WRITE_CLOCKS),
          "accesses": (WishboneAccesses, "prove", 3)}
COVERS = {"reads": (NativeReads, 8, {"next_at_once"}),
          "writes": (NativeWrites, 14, {"second_burst"}),
          "accesses": (WishboneAccesses, 10, {"after_one_given_up", "rejected"})}
PLANTED = {"a burst too early": (lambda: NativeReads(TooEarly), 8, "none_lost"),
           "no space for the word": (lambda: NativeWrites(NoSpace), _WRITE_CLOCKS,
                                    "a_word_is_there"),
           "answered by the command": (lambda: NativeWrites(CommandOnly), 8, "answered_then"),
           "another's word": (lambda: WishboneAccesses(Forgets), 8, "own_word")}


@pytest.mark.parametrize("design,mode,depth", cases(PROOFS, longer=["reads", "writes"]))
def test_proof(tmp_path, design, mode, depth):
    assert run(design(), tmp_path, mode=mode, depth=depth) == (PASS, set())


@pytest.mark.parametrize("design,depth,names", cases(COVERS, longer=["writes"]))
def test_covers(tmp_path, design, depth, names):
    assert run(design(), tmp_path, mode="cover", depth=depth) == (PASS, names)


@pytest.mark.parametrize("make,depth,rule", cases(PLANTED))
def test_planted_errors_are_found(tmp_path, make, depth, rule):
    assert run(make(), tmp_path, mode="bmc", depth=depth, only=rule)[0] == FAIL
