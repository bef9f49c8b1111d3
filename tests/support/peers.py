"""Peers of emulated devices, in a network of their own; where there can be none, a reason."""

import os
import shutil
import subprocess
from contextlib import contextmanager

import pytest

from ncdc_bench.client.measure import Served
from ncdc_sim.link.namespaces import Network
from ncdc_sim.tools import SimulationError

__all__ = ["need", "served"]


def need(*what):
    """Skip a test for lack of a program or of Aravis; on CI, which installs all, fail instead."""
    missing = [program for program in what if program != "aravis" and not shutil.which(program)]
    if "aravis" in what:
        code = "import gi; gi.require_version('Aravis', '0.8')"
        if subprocess.run(["/usr/bin/python3", "-c", code], capture_output=True).returncode:
            missing.append("gir1.2-aravis-0.8")
    if missing:
        _without(f"missing: {', '.join(missing)}; make setup installs them")


def _without(reason):
    if os.environ.get("CI"):
        pytest.fail(reason)
    pytest.skip(reason)


@contextmanager
def served(folder, descriptor, **options):
    """:class:`Served`; without network namespaces the test is skipped, on CI it fails."""
    try:
        with Network():
            pass
    except SimulationError as error:
        _without(str(error))
    with Served(folder, descriptor, **options) as one:
        yield one
