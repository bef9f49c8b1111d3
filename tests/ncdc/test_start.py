"""How the command starts: what it imports before it knows what to do, and how it is interrupted."""

import signal
import subprocess
import sys
import time

import pytest

from ncdc import cli

HEAVY = ("numpy", "scipy", "amaranth", "cv2", "matplotlib", "PySide6")
PRINT_IMPORTED = """
import sys
from ncdc.cli import main
try:
    main(sys.argv[1:])
except SystemExit as end:
    print("status", end.code)
print("imported", *({name.partition(".")[0] for name in sys.modules} & set(%r)))
""" % (HEAVY,)


def run(*arguments):
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True)


@pytest.mark.parametrize("arguments,said,status", [
    (["--version"], "NCDC ", 0), (["--help"], "hardware that straightens", 0),
    ([], "", 2), (["corect"], "", 2)])
def test_what_needs_no_command_imports_nothing_heavy(arguments, said, status):
    done = run("-c", PRINT_IMPORTED, *arguments)
    assert said in done.stdout and f"status {status}\nimported\n" in done.stdout, done


def test_a_heavy_import_would_be_seen():
    assert "numpy" in run("-c", "import cv2" + PRINT_IMPORTED, "--version").stdout


def test_the_overview_names_every_command():
    words = " ".join(run("-m", "ncdc", "--help").stdout.split())
    for name, text in cli.COMMANDS.items():
        assert f" {name} {text}" in words


def test_it_runs_as_a_module():
    done = run("-m", "ncdc", "--version")
    assert done.stdout.startswith("NCDC ") and not done.returncode
    done = run("-m", "ncdc", "correct", "none.toml", "none.png", "-o", "out.png")
    assert (done.returncode, done.stderr) == (
        2, "ncdc correct: cannot read none.toml: No such file or directory\n")


@pytest.mark.parametrize("module", ["numpy", "ncdc.cli.roles", "ncdc_model.golden.corrector"])
def test_interrupted_while_it_imports(module):
    """An import that takes for ever, so that the signal comes while it runs."""
    code = f"""
import sys, time
class Slow:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            print("importing", flush=True)
            time.sleep(60)
sys.meta_path.insert(0, Slow())
from ncdc.cli import main
sys.exit(main(["correct", "none.toml", "none.png", "-o", "out.png"]))
"""
    # Whoever began these tests in the background has the signal ignored.
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    assert process.stdout.readline() == "importing\n"
    time.sleep(.05)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=60)
    assert (process.returncode, error) == (130, "ncdc correct: interrupted\n")
