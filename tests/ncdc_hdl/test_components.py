"""Components of Platform Designer next to the corrector's: their Tcl, run with recording stubs,
has the ports of the Verilog."""

import re
import subprocess
from pathlib import Path

import pytest
from amaranth import Module
from amaranth.sim import Simulator

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_hdl.export.ip.platform_designer import packetiser_hw_tcl
from ncdc_hdl.export.verilog import module_verilog
from ncdc_hdl.link.packetiser import Packetiser
from ncdc_hdl.link.top import PACKETISER, PacketiserTop

RECORDER = Path(__file__).parents[1] / "support" / "tcl" / "record.tcl"
MODULES = "ncdc_system", "ncdc_packetiser"
PORT = re.compile(r"^  (input|output) +(?:wire +|reg +)?(?:\[(\d+):0\] )? *(\w+)", re.MULTILINE)


@pytest.fixture(scope="module")
def net(tmp_path_factory):
    path = tmp_path_factory.mktemp("components") / "net.toml"
    barrel_descriptor((64, 48), (64, 48), hidden_neurons=2).save(path)
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The packetiser's files."""
    path, packetiser = tmp_path_factory.mktemp("packetiser"), PacketiserTop(64)
    (path / f"{PACKETISER}.v").write_text(module_verilog(packetiser, PACKETISER))
    (path / f"{PACKETISER}_hw.tcl").write_text(packetiser_hw_tcl(packetiser))
    return path


@pytest.fixture(scope="module")
def system_folder(net):
    """Everything, by the command."""
    path = net.parent / "system"
    assert main(["generate", str(net), "-o", str(path), "--system", "--usb", "ft601",
                 "--sensor", "mt9p031", "--packetiser", "--data-width", "64"]) == 0
    return path


def calls_of(path):
    done = subprocess.run(["tclsh", RECORDER, "hw", path], capture_output=True, text=True,
                          cwd=path.parent)
    assert done.returncode == 0, done.stderr
    return [line.split("\x1f") for line in done.stdout.splitlines()]


def ports_of(path, module):
    body = re.search(rf"^module {module} ?\(.*?^endmodule", path.read_text(), re.M | re.S).group()
    return {name: (flow, int(high or 0) + 1) for flow, high, name in PORT.findall(body)}


def declared(calls):
    ports = [call[2:] for call in calls if call[0] == "add_interface_port"]
    assert len({port for port, *_ in ports}) == len(ports)
    flow = {"Input": "input", "Output": "output"}
    return {port: (flow[direction], int(width)) for port, _, direction, width in ports}


@pytest.mark.regress
@pytest.mark.parametrize("module", MODULES)
def test_what_the_command_writes(system_folder, module):
    check(system_folder, module)


def test_each_port_of_the_packetiser_is_in_one_interface(folder):
    check(folder, PACKETISER)


def check(folder, module):
    """The component of a ``module`` has the ports of its Verilog, each in one interface."""
    calls = calls_of(folder / f"{module}_hw.tcl")
    assert declared(calls) == ports_of(folder / f"{module}.v", module)
    names = {call[1] for call in calls if call[0] == "add_interface"}
    for call in calls:
        if call[0] == "set_interface_property":
            assert call[1] in names
            assert not call[2].startswith("associated") or call[3] in names
    files = {call[1] for call in calls if call[0] == "add_fileset_file"}
    assert files == {f"{module}.v"} and (folder / f"{module}.v").is_file()


@pytest.mark.regress
def test_a_camera_system_has_what_a_board_connects(system_folder):
    calls = calls_of(system_folder / "ncdc_system_hw.tcl")
    kinds = {call[1]: call[2] for call in calls if call[0] == "add_interface"}
    assert {name for name, kind in kinds.items() if kind == "conduit"} == {
        "sensor", "i2c", "usb", "front_end_idle"}
    # The corrector's read host and, after it, that of the link.
    assert {name for name, kind in kinds.items() if kind == "avalon"} == {
        "csr", "read0", "read1", "write"}


def test_packets_have_their_first_byte_highest(folder):
    calls = calls_of(folder / "ncdc_packetiser_hw.tcl")
    properties = {call[2]: call[3] for call in calls
                  if call[0] == "set_interface_property" and call[1] == "stream"}
    assert properties["symbolsPerBeat"] == "4"
    assert properties["firstSymbolInHighOrderBits"] == "true"


def test_a_port_that_the_verilog_lacks_is_found(folder):
    text = (folder / "ncdc_packetiser_hw.tcl").read_text()
    wrong = folder / "wrong_hw.tcl"
    wrong.write_text(text.replace("stream_empty empty Output 2", "stream_empty empty Output 3"))
    assert declared(calls_of(wrong)) != ports_of(folder / "ncdc_packetiser.v", "ncdc_packetiser")


@pytest.mark.parametrize("options,text", [
    (["--usb", "ft232h", "--sensor", "mt9p031"], "it needs --system"),
    (["--system", "--usb", "ft232h"], "--usb and --sensor are given together"),
    (["--system", "--usb", "ft232h", "--sensor", "mt9p031", "--bus", "axi"],
     "USB is there for avalon only"),
    (["--to", "stream", "--video", "vip", "--testbench"], "plain video only")])
def test_what_does_not_go_together(net, capsys, options, text):
    target = net.parent / "nothing"
    assert main(["generate", str(net), "-o", str(target), *options]) == 2
    assert text in capsys.readouterr().err and not target.exists()


def test_first_byte_of_a_packet_is_highest(monkeypatch):
    """As Altera's MAC and DMAs have it, so that they can be joined."""
    monkeypatch.setattr(Packetiser, "elaborate", lambda self, platform: Module())
    top = PacketiserTop()
    packets = top.packetiser.o

    async def bench(ctx):
        ctx.set(packets.p.data, int.from_bytes(b"\x11\x22\x33\x44", "little"))
        ctx.set(packets.p.empty, 1)         # the last byte is none
        await ctx.delay(1e-9)
        assert ctx.get(top.stream_data).to_bytes(4, "big")[:3] == b"\x11\x22\x33"
        assert ctx.get(top.stream_empty) == 1

    simulator = Simulator(top)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
