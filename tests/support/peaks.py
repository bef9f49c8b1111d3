"""Peak memory of processes, as Linux counts it from their start on."""

import re
import subprocess
import sys
from pathlib import Path

__all__ = ["command_peak", "peak_of"]

# The peak of a process's own memory: what ``getrusage`` gives a parent holds its own memory too.
_COMMAND = """import sys
from ncdc.cli import main
status = main(sys.argv[1:])
print(open("/proc/self/status").read(), file=sys.stderr)
sys.exit(status)"""


def peak_of(pid):
    """Peak resident memory of the running process ``pid``, MB of 1024 x 1024 bytes."""
    return _peak(Path(f"/proc/{pid}/status").read_text())


def command_peak(*words):
    """Peak memory in MB of the command ``ncdc`` with these arguments, and its standard output."""
    done = subprocess.run([sys.executable, "-c", _COMMAND, *map(str, words)], capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr
    return _peak(done.stderr), done.stdout


def _peak(status):
    return int(re.search(r"^VmHWM:\s*(\d+) kB", status, re.MULTILINE)[1]) / 1024
