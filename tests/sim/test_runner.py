"""Building once, finding the simulators, cleaning up."""

import re
import subprocess
import sys
import threading

import pytest

from ncdc_sim import runner, tools
from ncdc_sim.ports import ports_of
from ncdc_sim.runner import build, command_of, run
from ncdc_sim.tools import SimulationError
from ncdc_spec.builds import built, key_of, without_header
from ncdc_spec.errors import InputError

HELLO = 'module hello;\n  initial begin $display("hello"); $finish; end\nendmodule\n'


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("NCDC_CACHE", str(tmp_path / "cache"))


def build_hello(text=HELLO, **options):
    return build("hello", "hello", [("hello.v", text)], simulator="icarus", **options)


def test_second_build_is_not_made(monkeypatch, tmp_path):
    program = build_hello()
    monkeypatch.setattr(runner, "call", None)
    assert build_hello() == program
    assert build_hello("// made on another day\n\n" + HELLO) == program
    lines = []
    run(command_of(program), tmp_path, lines.append)
    assert lines[0] == "hello"


@pytest.mark.parametrize("change", [{"text": HELLO.replace("hello\")", "bye\")")},
                                    {"defines": {"X": 1}}])
def test_a_change_is_built(change):
    assert build_hello() != build_hello(**change)


def test_failed_build_leaves_nothing(tmp_path):
    with pytest.raises(SimulationError, match="iverilog failed"):
        build_hello("module hello; nonsense\n")
    assert [p.suffix for p in (tmp_path / "cache").iterdir()] == [".lock"]


def test_two_at_once_build_once():
    made, first_inside = [], threading.Event()

    def make(folder):
        made.append(folder)
        first_inside.set()
        second.join(0.2)        # the second is now waiting for the lock
        (folder / "done").write_text("")

    second = threading.Thread(target=lambda: first_inside.wait() and built("k-1", make))
    second.start()
    folder = built("k-1", make)
    second.join()
    assert len(made) == 1 and (folder / "done").exists()


def test_failing_simulation_shows_its_last_lines(tmp_path):
    code = "print('the reason'); raise SystemExit(3)"
    with pytest.raises(SimulationError, match="(?s)status 3.*the reason"):
        run([sys.executable, "-c", code], tmp_path)


@pytest.mark.longer
def test_the_compiler_takes_the_precompiled_header(monkeypatch, tmp_path):
    """Of two builds one precompiles it; a compiler that would rather read the text fails."""
    main = tmp_path / "main.cpp"
    main.write_text('#include "Vhello.h"\nint main() { Vhello().eval(); }\n')
    commands = []

    def strict(command, folder):
        commands.append(str(command[0]))
        tools.call([part.replace("-include", "-Werror=invalid-pch -include")
                    for part in command], folder)

    monkeypatch.setattr(runner, "call", strict)
    for text in HELLO, HELLO.replace("hello\")", "bye\")"):
        build("hello", "hello", [("hello.v", text)], optimise="-O0", main=main)
    assert [name == "g++" for name in commands] == [True, False, False]


@pytest.mark.parametrize("changed", [{"optimise": "-O2"}, {"options": ("--trace-vcd",)},
                                     {"options": ("--timing", "--main")}])
def test_other_builds_have_another_header(monkeypatch, changed):
    commands = []
    monkeypatch.setattr(runner, "call", lambda command, folder: commands.append(command))
    build("hello", "hello", [("hello.v", HELLO)], **{"optimise": "-O0", **changed})
    assert len(commands) == 1 and not any("-include" in part for part in commands[0])


def test_interrupted_run_ends_the_simulation(tmp_path):
    code = "import time; print('pid', flush=True); time.sleep(60)"
    started = []
    popen = subprocess.Popen

    def remember(*args, **options):
        started.append(popen(*args, **options))
        return started[0]

    def interrupt(line):
        raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runner.subprocess, "Popen", remember)
        with pytest.raises(KeyboardInterrupt):
            run([sys.executable, "-c", code], tmp_path, interrupt)
    assert started[0].returncode == -9


def test_missing_simulator(monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr(tools, "_wheel", lambda: None)
    with pytest.raises(InputError, match=r"\(iverilog\) is not installed: apt install iverilog"):
        build_hello()
    with pytest.raises(InputError, match=r"verilator \(verilator\) is not installed"):
        tools.tool("verilator")


@pytest.mark.parametrize("there,said", [
    ((), "perl and make and g++ are not installed, which Verilator compiles with: "
         "apt install perl make g++"),
    (("perl", "make"), "g++ is not installed, which Verilator compiles with: apt install g++")])
def test_missing_compiler(monkeypatch, tmp_path, there, said):
    """The simulator itself is there, as where a wheel has brought it."""
    for name in (*there, "verilator"):
        (tmp_path / name).write_text("#!/bin/sh\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(tools, "_wheel", lambda: None)
    with pytest.raises(InputError, match=re.escape(said)):
        build("hello", "hello", [("hello.v", HELLO)])


def test_cache_that_cannot_be_written(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("NCDC_CACHE", str(tmp_path / "file" / "cache"))
    with pytest.raises(InputError, match="cannot write the folder of builds"):
        build_hello()


def test_header_is_not_part_of_the_key():
    assert without_header("// a\n/* b\n * c */\n\nmodule m;\n// d\n") == "module m;\n// d\n"
    assert key_of("n", "ab", "c") != key_of("n", "a", "bc")


def test_ports():
    verilog = ("module a(x);\n  input x;\nendmodule\n"
               "module top(clk, \\odd , o);\n  input clk;\n  wire clk;\n  input [13:0] data ;\n"
               "  output signed [3:0] o;\n  output reg q;\nendmodule\n")
    assert ports_of(verilog, "top") == {"clk": 1, "data": 14, "o": 4, "q": 1}
