"""What is kept between runs is used again if nothing has changed, and only then."""

import shutil

import numpy as np
import pytest

import kept
from ncdc_hdl.lib import memory
from ncdc_model.training.problem import Problem
from ncdc_sim.system import frame
from ncdc_sim.tools import SimulationError
from ncdc_spec.geometry import Geometry
from pipelines import run_pipeline
from tansigs import DESIGNS, gateware


@pytest.fixture(autouse=True)
def empty(tmp_path, monkeypatch):
    monkeypatch.setenv("NCDC_CACHE", str(tmp_path))


@pytest.fixture
def again(monkeypatch):
    """Makes the next call one of another run of the same test; changes its name, if asked to."""
    def again(name=None):
        kept._calls.clear()
        if name:
            monkeypatch.setenv("PYTEST_CURRENT_TEST", f"tests/test_kept.py::{name} (call)")
    return again


@pytest.fixture
def simulate():
    """What a simulation that counts its runs shows: a list and an array."""
    def simulate(about="design", error=None):
        seen, memory_of = [0], np.zeros(3, int)

        def run():
            runs.append(1)
            seen.extend([1, (2, 3)])
            memory_of[1] = 7
            if error:
                raise error

        kept.kept_lists(run, about, (seen, memory_of))
        return seen, memory_of.tolist(), len(runs)

    runs = []
    return simulate


SHOWN = [0, 1, (2, 3)], [0, 7, 0]


def test_lists_and_arrays_of_the_same_test_are_used_again(simulate, again):
    again()
    assert simulate() == (*SHOWN, 1)
    again()
    assert simulate() == (*SHOWN, 1)
    assert simulate() == (*SHOWN, 2), "the second simulation of a test is another one"
    again("test_other[1]")
    assert simulate() == (*SHOWN, 3)
    again()
    assert simulate("another design") == (*SHOWN, 4)


def test_another_source_is_simulated(simulate, again, monkeypatch):
    assert simulate() == (*SHOWN, 1)
    again()
    monkeypatch.setattr(kept, "sources_of", lambda *_: "changed")
    assert simulate() == (*SHOWN, 2)


def test_a_patched_design_and_a_fixture_are_simulated(simulate, again, monkeypatch):
    assert simulate() == (*SHOWN, 1)
    again()
    with monkeypatch.context() as patch:
        patch.setattr(memory, "Fifo", None)
        assert simulate() == (*SHOWN, 2)
    monkeypatch.setenv("PYTEST_CURRENT_TEST", "tests/test_kept.py::test (setup)")
    assert [simulate()[2], simulate()[2]] == [3, 4]


def test_a_failure_is_not_kept(simulate, again):
    for _ in range(2):
        again()
        with pytest.raises(AssertionError):
            simulate(error=AssertionError())
    again()
    assert simulate() == (*SHOWN, 3)


def test_gateware_is_not_simulated_again(again, monkeypatch):
    again()
    first = gateware(DESIGNS[0], np.arange(9))
    again()
    monkeypatch.setattr("pipelines.Simulator", None)
    np.testing.assert_array_equal(gateware(DESIGNS[0], np.arange(9)), first)
    with pytest.raises(TypeError):
        run_pipeline(DESIGNS[0], [], None, None)


def test_a_training_is_shared_and_tells_its_progress_again(monkeypatch):
    u, v = (a.ravel() for a in np.mgrid[:40:4., :32:4.])
    problem, told = Problem(u, v, u + .001 * u * v, v, Geometry(40, 32, 40, 32)), []
    for _ in range(2):
        network, curve = kept.kept_trainer(starts=2, rounds=0)(
            problem, 1, progress=lambda *about: told.append(about))
        assert network.hidden_neurons == 1 and curve
        monkeypatch.setattr(kept, "train_levenberg", None)
    assert told[:len(told) // 2] == told[len(told) // 2:] != []
    with pytest.raises(TypeError):
        kept.kept_trainer(starts=2, rounds=0)(problem, 1, seed=1)


PROGRAM = """#!/bin/sh
echo run >> "$NCDC_CACHE/count"
echo "$1" "$(cat input)"
echo "$1" > output
exit "$2"
"""


def test_what_a_program_prints_and_writes_is_used_again(tmp_path):
    """Once for each of its arguments, its input and its build; a failure is found again."""
    for build in "ab":
        (tmp_path / build).mkdir()
        (tmp_path / build / "program").write_text(PROGRAM)
        (tmp_path / build / "program").chmod(0o755)
    count = tmp_path / "count"

    def simulate(build, argument, content, status=0):
        lines, folder = [], tmp_path / "folder"
        folder.mkdir()
        (folder / "input").write_text(content)
        try:
            frame.run_program([str(tmp_path / build / "program"), argument, str(status)], folder,
                              lines.append)
            return lines, (folder / "output").read_text(), count.read_text().count("run")
        finally:
            shutil.rmtree(folder)

    assert simulate("a", "x", "1") == simulate("a", "x", "1") == (["x 1"], "x\n", 1)
    assert simulate("a", "y", "1") == (["y 1"], "y\n", 2)
    assert simulate("a", "x", "2") == (["x 2"], "x\n", 3)
    assert simulate("b", "x", "1") == (["x 1"], "x\n", 4)
    for n in (5, 6):
        with pytest.raises(SimulationError, match="status 3"):
            simulate("a", "z", "1", status=3)
        assert count.read_text().count("run") == n
    assert simulate("a", "x", "0" * (1 << 19 | 1))[2] == simulate("a", "x", "0")[2] - 1 == 7
    assert simulate("a", "x", "0" * (1 << 19 | 1))[2] == 9, "what is large is not kept"
