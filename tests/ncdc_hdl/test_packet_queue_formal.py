"""Proof that a packet which has begun never waits for a beat, with covers and planted errors."""

import pytest

from formal.packets import WholePackets
from formal.sby import FAIL, PASS, run
from ncdc_hdl.link.packet_queue import PacketQueue


class Hasty(PacketQueue):
    """A packet begins with its first beat."""

    def _may_begin(self, whole):
        return self.put | (whole != 0)


@pytest.mark.longer
def test_holds(tmp_path):
    assert run(WholePackets(), tmp_path, mode="prove", depth=3) == (PASS, set())


@pytest.mark.longer
def test_is_reached(tmp_path):
    assert run(WholePackets(), tmp_path, mode="cover", depth=12) == (PASS, {"full", "around"})


@pytest.mark.parametrize("rule", ["there", "ends"])
def test_planted_error_is_found(rule, tmp_path):
    status, names = run(WholePackets(Hasty), tmp_path, mode="bmc", depth=8, only=rule)
    assert status == FAIL and {name.rpartition(".")[2] for name in names} == {rule}
