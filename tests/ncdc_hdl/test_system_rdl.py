"""SystemRDL: the table of registers, as its compiler and peakrdl read it."""

import subprocess
import sys
from pathlib import Path

import pytest
from systemrdl import RDLCompileError, RDLCompiler
from systemrdl.node import FieldNode, MemNode, RegNode

from drivers import ROWS
from ncdc_spec.registers.register_map import TABLE


def compiled(path):
    compiler = RDLCompiler()
    compiler.compile_file(str(path))
    return compiler.elaborate().top


def test_system_rdl_is_the_table(corrector, folder):
    top, found = compiled(folder / "ncdc.rdl"), {}
    for node in top.children():
        if isinstance(node, RegNode):
            found[node.inst_name] = node
    assert list(found) == [r.name for r in ROWS]
    values = {**corrector.registers.values, **corrector.registers.constants}
    for r in ROWS:
        node = found[r.name]
        assert node.absolute_address == 4 * r.address and node.get_property("regwidth") == 32
        fields = [child for child in node.children() if isinstance(child, FieldNode)]
        if r.flags:
            assert [(f.inst_name, f.lsb, f.msb) for f in fields] == [
                (flag.name, flag.low, flag.bit) for flag in r.flags]
            for f, flag in zip(fields, r.flags):
                assert f.is_sw_readable == (flag.access != "w1"), flag
                assert f.is_sw_writable == (flag.access != "ro"), flag
                assert (f.get_property("onwrite") is not None) == (flag.access == "w1c"), flag
            continue
        field, = fields
        assert (field.lsb, field.msb) == (0, r.shape.width - 1), r.name
        assert field.is_sw_writable == (r.access in ("rw", "shadow")), r.name
        assert field.get_property("reset") == values.get(r.name, 0) % 2**r.shape.width, r.name
    memory, = (node for node in top.children() if isinstance(node, MemNode))
    assert memory.absolute_address == 4 * TABLE and memory.get_property("memwidth") == 32
    assert top.size == memory.absolute_address + memory.size == 1 << 16


def test_peakrdl_accepts_the_file(folder):
    for command in (["dump", "ncdc.rdl"], ["ip-xact", "ncdc.rdl", "-o", "ncdc.xml"]):
        done = subprocess.run([Path(sys.executable).parent / "peakrdl", *command], cwd=folder,
                              text=True, capture_output=True)
        assert not done.returncode, done.stderr
    assert all(f"<ipxact:name>{r.name}<" in (folder / "ncdc.xml").read_text() for r in ROWS)


def test_registers_at_one_address_are_not_accepted(folder, tmp_path):
    """The compiler's silence above means something."""
    text = (folder / "ncdc.rdl").read_text().replace("} STATUS @ 0x0010", "} STATUS @ 0x000C")
    (tmp_path / "wrong.rdl").write_text(text)
    with pytest.raises(RDLCompileError):
        compiled(tmp_path / "wrong.rdl")
