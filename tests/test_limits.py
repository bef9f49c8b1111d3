"""Limits of time and of clocks: a component that hangs makes a test fail, and not wait."""

import subprocess
import sys

import pytest
from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from pipelines import run_stream

HANGS = """
import pytest

def test_hangs():
    while True:
        pass

def test_goes_on():
    pass
"""


class Deaf(wiring.Component):
    """Takes nothing and gives nothing."""
    i: In(stream.Signature(8))
    o: Out(stream.Signature(8))

    def elaborate(self, platform):
        m = Module()
        m.d.sync += self.o.payload.eq(self.i.payload)
        return m


def test_a_bench_that_does_not_end_fails(monkeypatch):
    monkeypatch.setattr(run_stream.__globals__["run_bench"], "__kwdefaults__", {
        "background": (), "results": None, "clocks": 500})
    with pytest.raises(AssertionError, match="have not ended after 500 clocks"):
        run_stream(Deaf(), [1], 1, lambda: False, lambda: False)


@pytest.mark.longer
def test_a_test_that_hangs_fails_and_the_next_one_runs(tmp_path):
    (tmp_path / "test_it.py").write_text(HANGS)
    done = subprocess.run([sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--timeout",
                           "1", "test_it.py"], cwd=tmp_path, text=True, capture_output=True)
    assert "1 failed, 1 passed" in done.stdout and "Timeout" in done.stdout


def test_every_test_has_a_limit(request):
    assert 0 < float(request.config.getini("timeout")) <= 900


@pytest.mark.regress
def test_those_of_make_regress_have_another(request):
    assert request.node.get_closest_marker("timeout").args[0] > 900
