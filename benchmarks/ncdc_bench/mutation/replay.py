"""Simulations of benches, run again with mutants: no golden model, no files made anew."""

import re
import signal
import subprocess
import tempfile
from contextlib import ExitStack
from pathlib import Path

from ncdc_bench.mutation.mutants import selecting
from ncdc_sim.tools import environment

__all__ = ["Replay"]

_LIMIT = re.compile(r"\+clock_limit=\d+")
_TOTAL = re.compile(r"RESULT total_clocks (\d+)")
_INPUT = "input.txt"
_MARGIN = 64        # clocks that a mutant gets more than the design; with one more it differs


class Replay:
    """The simulations of a bench, ready to run with any mutant; a context.

    Without a mutant a simulation does the same each time. So a mutant is found if anything differs
    that the simulation prints or writes: results, clocks, rules of buses that are violated.

    Parameters
    ----------
    name : str
        Of the bench.
    transcripts : sequence of Transcript
        Of its simulations without a mutant.
    """

    def __init__(self, name, transcripts):
        self.name, self._runs = name, [_Run(one) for one in transcripts]
        self._opened = ExitStack()

    def __enter__(self):
        for run in self._runs:
            run.fill(Path(self._opened.enter_context(
                tempfile.TemporaryDirectory(prefix="ncdc-"))))
        return self

    def __exit__(self, *_):
        self._opened.close()

    def difference(self, number):
        """First difference that the mutant ``number`` makes, in words; None if it makes none.

        Raises
        ------
        OSError
            If a simulation cannot run or write its files.
        MemoryError
            If a simulation was killed from outside.
        """
        return next((found for run in self._runs
                     if (found := run.difference(selecting(number))) is not None), None)


class _Run:
    """One simulation."""

    def __init__(self, transcript):
        self._transcript = transcript
        totals = [int(found[1]) for line in transcript.lines if (found := _TOTAL.match(line))]
        limit = f"+clock_limit={totals[-1] + _MARGIN}" if totals else ""
        self._command = [_LIMIT.sub(limit, word) if totals else word
                         for word in transcript.command]
        self._folder = None

    def fill(self, folder):
        """Write what the simulation reads into its ``folder``."""
        self._folder = folder
        for name, content in self._transcript.files.items():
            (folder / name).write_bytes(content)
        (folder / _INPUT).write_text(self._transcript.given)

    def difference(self, plusargs):
        """See :meth:`Replay.difference`."""
        for name in self._transcript.written:
            (self._folder / name).unlink(missing_ok=True)
        with (self._folder / _INPUT).open() as given, subprocess.Popen(
                [*self._command, *plusargs], cwd=self._folder, env=environment(), text=True,
                errors="replace", stdin=given, stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT) as process:
            try:
                found = self._lines(process.stdout)
            except BaseException:       # Ctrl-C too must not leave the simulation running
                process.kill()
                raise
            if found is not None:
                process.kill()
                return found
        if process.returncode in (-signal.SIGKILL, -signal.SIGTERM):
            raise MemoryError(f"a simulation was ended by signal {-process.returncode}")
        if process.returncode:
            return f"the simulation ends with status {process.returncode}"
        return self._written()

    def _lines(self, stream):
        """The first line that differs, or None; the rest is not read."""
        expected = iter(self._transcript.lines)
        for line in stream:
            wanted = next(expected, "no line")
            if line.rstrip() != wanted:
                return f"{line.rstrip()!r} instead of {wanted!r}"
        missing = next(expected, None)
        # A simulation that crashes ends early too; its status says so.
        return None if missing is None else f"no line {missing!r}"

    def _written(self):
        """The first file that differs, or None."""
        for name, expected in self._transcript.written.items():
            found = (self._folder / name).read_bytes()
            if len(found) != len(expected):     # whatever the design does, the bench writes all
                raise OSError(f"a simulation wrote {len(found)} bytes of {name} instead of "
                              f"{len(expected)}")
            if found != expected:
                return f"{name} differs"
        return None
