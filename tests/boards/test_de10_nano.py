"""The DE10-Nano's project: system, ports, pins, constraints, and what runs on its processor."""

import importlib
import json
import re
import shutil
import subprocess
import sys
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

from camera_bus import Bus
from cameras import barrel_descriptor
from constraints import complaints
from ncdc.cli import main
from ncdc_boards.catalogue import board
from ncdc_boards.hps_board.ports import AGENT, BURST_BITS, HOST, MEMORY_PINS, PORTS
from ncdc_boards.quartus.resources import CAMERA_PINS
from ncdc_boards.quartus.sdc import FREE
from ncdc_sim.tools import environment, tool

TCL = Path(__file__).parents[1] / "support" / "tcl" / "record.tcl"
PINS = Path(__file__).parents[1] / "data" / "pins" / "de10-nano.txt"
NAME = "ncdc_de10_nano"
LOOPS = {"core_loop": 2, "pixel_loop": 1}


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """Folder of the project, as the command writes it."""
    folder = tmp_path_factory.mktemp("de10")
    barrel_descriptor((64, 24), (64, 24), hidden_neurons=2, strength=.4).save(folder / "net.toml")
    assert main(["build", str(folder / "net.toml"), "--board", "de10-nano", "-o",
                 str(folder / "project")]) == 0
    return folder / "project"


def recorded(kind, path):
    """Calls that a Tcl file makes: lists of words."""
    done = subprocess.run(["tclsh", TCL, kind, path], text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    return [line.split("\x1f") for line in done.stdout.splitlines()]


def header_of(module, calls):
    """Verilog of a module with the ports that the recorded system exports, and nothing in it."""
    parameters = {tuple(call[1:3]): call[3] for call in calls
                  if call[0] == "set_instance_parameter_value"}
    inner = {call[1]: call[3].partition(".")[0] for call in calls
             if call[0] == "set_interface_property" and call[2] == "EXPORT_OF"}
    ports = [("input", 1, "clk_clk"), ("input", 1, "reset_reset_n"),
             ("output", 1, "hps_reset_reset_n"), ("input", 32, "irq_irq"),
             ("input", 1, "memory_oct_rzqin")]
    ports += [("inout" if name.startswith("dq") else "output", width, f"memory_mem_{name}")
              for name, width in MEMORY_PINS.items()]
    for export in ("csr", *PORTS):
        settings = {key: parameters[inner[export], key] for key in
                    ("DATA_WIDTH", "ADDRESS_WIDTH", "MAX_BURST_SIZE")}
        data = int(settings["DATA_WIDTH"])
        widths = {"address": int(settings["ADDRESS_WIDTH"]), "readdata": data, "writedata": data,
                  "byteenable": data // 8,
                  "burstcount": int(settings["MAX_BURST_SIZE"]).bit_length()}
        ports += [({"i": "input", "o": "output"}[way], widths.get(name, 1), f"{export}_{name}")
                  for name, way in (HOST if export == "csr" else AGENT).items()]
    lines = ",\n".join(f"  {way} [{width - 1}:0] {name}" for way, width, name in ports)
    return f"module {module} (\n{lines}\n);\nendmodule\n"


def lint(project, stub, tmp_path):
    """What Icarus says of the top's ports to the system."""
    cells = Path(__file__).parents[2] / "sim" / "ncdc_sim" / "hdl" / "altera_cells.v"
    (tmp_path / "stub.v").write_text(stub)
    done = subprocess.run(
        [tool("icarus"), "-Wportbind", "-g2012", "-s", NAME, "-o", str(tmp_path / "out"),
         str(project / f"{NAME}.v"), str(project / "ncdc_user.v"), str(cells),
         str(tmp_path / "stub.v")], text=True, capture_output=True, env=environment())
    return done.returncode, [line for line in (done.stdout + done.stderr).splitlines()
                             if "ncdc_qsys" in line or "processor" in line or "error" in line]


@pytest.mark.longer
def test_the_top_has_each_port_of_the_system_as_wide(project, tmp_path):
    stub = header_of("ncdc_qsys", recorded("qsys", project / "ncdc_qsys.tcl"))
    assert lint(project, stub, tmp_path) == (0, [])
    assert f"[{BURST_BITS - 1}:0] screen_burstcount" in stub
    _, narrow = lint(project, stub.replace("[63:0] write_writedata", "[31:0] write_writedata"),
                     tmp_path)
    assert narrow
    code, missing = lint(project, stub.replace("csr_waitrequest", "csr_waitrequset"), tmp_path)
    assert code and missing
    instance = re.search(r"^  ncdc_qsys processor \((.*?)^  \);",
                         (project / f"{NAME}.v").read_text(), re.M | re.S).group(1)
    assert set(re.findall(r"\.(\w+)\(", instance)) == set(re.findall(r"\] (\w+)", stub))


@pytest.mark.longer
def test_the_system_connects_what_the_processor_has(project):
    calls = recorded("qsys", project / "ncdc_qsys.tcl")
    instances = {call[1]: call[2] for call in calls if call[0] == "add_instance"}
    assert set(instances) == {"clk_0", "hps_0", "csr_0", *(f"{name}_0" for name in PORTS)}
    processor = {call[2]: call[3] for call in calls
                 if call[0] == "set_instance_parameter_value" and call[1] == "hps_0"}
    assert processor["F2SDRAM_Width"] == "64 64 32"
    # Words of a list of Tcl's; a blank in one is escaped.
    assert re.split(r"(?<!\\) ", processor["F2SDRAM_Type"]) == [
        "Avalon-MM\\ Read-Only", "Avalon-MM\\ Write-Only", "Avalon-MM\\ Read-Only"]
    # At most six command ports, and four of 64 bits for data each way (HPS manual, 12.4.4).
    assert len(PORTS) <= 6 and sum("Read" in kind for _, kind in PORTS.values()) <= 4
    connected = {tuple(call[1:3]) for call in calls if call[0] == "add_connection"}
    for k, name in enumerate(PORTS):
        assert (f"{name}_0.m0", f"hps_0.f2h_sdram{k}_data") in connected
        assert ("clk_0.clk", f"hps_0.f2h_sdram{k}_clock") in connected
    assert ("hps_0.h2f_lw_axi_master", "csr_0.s0") in connected
    ends = {end.partition(".")[0] for pair in connected for end in pair}
    assert ends <= set(instances)
    for instance in set(instances) - {"clk_0", "hps_0"}:
        assert ("clk_0.clk", f"{instance}.clk") in connected
        assert ("clk_0.clk_reset", f"{instance}.reset") in connected


def pins_of(project):
    return {to: pin for command, _, to, pin in (
        call for call in recorded("qsf", project / f"{NAME}.qsf")
        if call[0] == "set_location_assignment")}


@pytest.mark.longer
def test_every_port_is_constrained_or_free(project, tmp_path):
    """But those of the processor's memory, which has constraints of its own."""
    ports = {bit.partition("[")[0] for bit in pins_of(project)}
    ways = {port: "inout" if port.endswith(("scl__io", "sda__io")) else
            "input" if any(fnmatchcase(port, pattern) for pattern in
                           ("clk50*", "camera_0__[dflp]*")) else "output"
            for port in ports if not port.startswith("hps_ddr3")}
    sdc = project / f"{NAME}.sdc"
    assert complaints(recorded("sdc", sdc), ways, FREE, LOOPS) == []
    assert "hps_ddr3" not in sdc.read_text()
    for old, new, said in (("hdmi_0__de__io* ", "", "hdmi_0__de__io has no delays"),
                           ("general[1]", "general[2]", "comes of output 2 of core_loop")):
        (tmp_path / "planted.sdc").write_text(sdc.read_text().replace(old, new))
        found = complaints(recorded("sdc", tmp_path / "planted.sdc"), ways, FREE, LOOPS)
        assert any(said in sentence for sentence in found)


@pytest.mark.longer
def test_a_pin_is_where_others_have_it(project):
    """Red is the transmitter's upper eight, as others drive it; the memory's pins are left out, of
    which there is one source only."""
    theirs = dict(line.split() for line in PINS.read_text().splitlines() if line[0] != "#")
    ours = {to: pin.removeprefix("PIN_") for to, pin in pins_of(project).items()}
    expected = {"clk50_0__io": theirs["FPGA_CLK1_50"]}
    for name in ("clk", "de", "hs", "vs"):
        expected[f"hdmi_0__{name}__io"] = theirs[f"HDMI_TX_{name.upper()}"]
    for name in ("scl", "sda"):
        expected[f"hdmi_0__{name}__io"] = theirs[f"HDMI_I2C_{name.upper()}"]
    for first, colour in ((0, "b"), (8, "g"), (16, "r")):
        expected |= {f"hdmi_0__{colour}__io[{k}]": theirs[f"HDMI_TX_D[{first + k}]"]
                     for k in range(8)}
    expected |= {f"led_{k}__io": theirs[f"LED[{k}]"] for k in range(8)}
    header = {k + 1 + 2 * (k >= 10) + 2 * (k >= 26): theirs[f"GPIO_0[{k}]"] for k in range(36)}
    for name, numbers in CAMERA_PINS.items():
        for k, number in enumerate(numbers):
            bit = f"[{k}]" if len(numbers) > 1 else ""
            expected[f"camera_0__{name}__io{bit}"] = header[number]
    assert {to: pin for to, pin in ours.items() if not to.startswith("hps_ddr3")} == expected
    assert len(set(ours.values())) == len(ours)
    assert sum(to.startswith("hps_ddr3") for to in ours) == sum(MEMORY_PINS.values()) + 1


@pytest.mark.longer
def test_the_device_tree_compiles(project):
    text = (project / f"{NAME}.dtsi").read_text()
    assert "reg = <0xff200000 0x20000>" in text and "interrupts = <0 40 4>" in text
    settings = json.loads((project / "ncdc_board.json").read_text())
    assert f"reg = <{settings['frames']:#x} {settings['frame_bytes']:#x}>" in text
    if shutil.which("dtc"):
        tree = ('/dts-v1/;\n/ { #address-cells = <1>; #size-cells = <1>;\n'
                'intc: interrupt-controller { interrupt-controller; #interrupt-cells = <3>; };\n'
                '};\n')
        done = subprocess.run(["dtc", "-q", "-I", "dts", "-O", "dtb", "-o", "/dev/null"],
                              input=tree + text, text=True, capture_output=True)
        assert done.returncode == 0, done.stderr


@pytest.fixture
def host(project, monkeypatch):
    """The project's module for the processor, and the names of its registers."""
    monkeypatch.syspath_prepend(str(project))
    mine = [path.stem for path in project.glob("ncdc_*.py")]
    for name in mine:
        monkeypatch.delitem(sys.modules, name, raising=False)
    yield importlib.import_module("ncdc_board"), importlib.import_module("ncdc_registers")
    for name in mine:
        sys.modules.pop(name, None)


def started(host, project, **changed):
    module, names = host
    settings = json.loads((project / "ncdc_board.json").read_text()) | changed
    sensor = settings["sensor"]
    bus = Bus(names, {sensor["i2c_address"]: {
        bytes([register]): value.to_bytes(2, "big") for register, value in sensor["chip_id"]},
        settings["transmitter"]["i2c_address"]: {}})
    for name, size in (("RAW_BYTES", 5000), ("CORRECTED_BYTES", 9000)):
        bus.words[names.OFFSET[name]] = size
    made = module.Board(bus.read, bus.write, settings)
    made.start()
    return made, bus, settings


@pytest.mark.longer
def test_the_processor_sets_transmitter_and_sensor_up(host, project):
    _, bus, settings = started(host, project)
    sent = [entry for entry in bus.log if isinstance(entry, tuple)]
    transmitter, sensor = settings["transmitter"], settings["sensor"]
    assert sent == [(0x39, bytes([w["register"], w["value"]])) for w in transmitter["writes"]] + [
        (sensor["i2c_address"], bytes([w["register"]]) + w["value"].to_bytes(2, "big"))
        for w in sensor["writes"]]
    # Frames have buffers, and the camera waits, before the sensor sends.
    order = [entry if isinstance(entry, str) else "i2c" for entry in bus.log]
    last = len(order) - 1 - order[::-1].index("i2c")
    enabled = len(order) - 1 - order[::-1].index("CAMERA_ENABLE")
    assert order.index("RAW0_BASE") < order.index("i2c") < enabled < last
    assert bus.words[bus.names.OFFSET["CAMERA_ENABLE"]] == 1
    for name, value in settings["registers"].items():
        assert bus.words[bus.names.OFFSET[name]] == value


@pytest.mark.longer
def test_frames_lie_apart_in_the_memory_reserved_for_them(host, project):
    _, bus, settings = started(host, project)
    bases = sorted((value, name) for name, offset in bus.names.OFFSET.items()
                   if name.endswith("_BASE") and name[0] in "RC"
                   for value in [bus.words.get(offset)])
    sizes = {"R": 5000, "C": 9000}
    assert len(bases) == 10 and bases[0][0] == settings["frames"]
    for (base, name), (after, _) in zip(bases, bases[1:] + [
            (settings["frames"] + settings["frame_bytes"], "")]):
        assert base % 4096 == 0 and base + sizes[name[0]] <= after
    with pytest.raises(MemoryError, match="frames take 102400 bytes, 102399 are reserved for them"):
        started(host, project, frame_bytes=102399)


HANDOFF = 0x1FF     # that U-Boot's bridge enable writes: qts/sdram_config.h of its de10-nano
FPGAPORTRST = 0xFFC25080


@pytest.mark.longer
def test_each_memory_port_is_asked_for_its_reset(project):
    """The bits are those of the ports that the system has, and U-Boot's handoff lacks some."""
    resets = json.loads((project / "ncdc_board.json").read_text())["port_resets"]
    processor = {call[2]: call[3] for call in recorded("qsys", project / "ncdc_qsys.tcl")
                 if call[0] == "set_instance_parameter_value" and call[1] == "hps_0"}
    kinds = re.split(r"(?<!\\) ", processor["F2SDRAM_Type"])
    assert (resets["address"], resets["all"]) == (FPGAPORTRST, 0x3FFF)
    commands = sum(bits & 0x3F00 for bits in resets["used"].values())
    assert commands == sum(0x100 << k for k in range(len(kinds)))
    for low, way in ((0, "Read"), (4, "Write")):
        queues = sum(bits >> low & 0xF for bits in resets["used"].values())
        assert queues == (1 << sum(way in kind for kind in kinds)) - 1
    assert {name for name, bits in resets["used"].items() if bits & ~HANDOFF} == {"write", "screen"}


def opened(host, project, folder, value):
    """The board's module opens the board, whose memory controller has this word; the word then."""
    module, _ = host
    memory, registers = folder / "mem", folder / "uio0"
    with memory.open("wb") as file:
        file.truncate(0x1_0000_0000)            # of 4 GB, without a block on the disk
        file.seek(FPGAPORTRST)
        file.write(value.to_bytes(4, "little"))
    registers.write_bytes(bytes(1 << 17))
    module.open_board(str(registers), str(project / "ncdc_board.json"), str(memory))
    with memory.open("rb") as file:
        file.seek(FPGAPORTRST)
        return int.from_bytes(file.read(4), "little")


@pytest.mark.longer
def test_memory_ports_leave_their_resets_and_it_is_said(host, project, tmp_path, capsys):
    assert opened(host, project, tmp_path, HANDOFF) == 0x3FFF
    assert capsys.readouterr().out == ("memory ports write, screen were in reset: 0x3fff is "
                                       "written to 0xffc25080\n")
    assert opened(host, project, tmp_path, 0x3FFF) == 0x3FFF
    assert capsys.readouterr().out == ""


@pytest.mark.longer
def test_a_memory_port_that_stays_in_reset_is_an_error(host, project):
    class Stuck(list):
        def __setitem__(self, at, value):
            super().__setitem__(at, value & ~0x400)

    resets = json.loads((project / "ncdc_board.json").read_text())["port_resets"]
    with pytest.raises(OSError, match="the memory ports screen stay in reset: 0xffc25080 reads "
                                      "0x3bff after 0x3fff was written; load the bitstream"):
        host[0].release_ports(Stuck([0]), resets)


@pytest.mark.longer
def test_the_project_makes_what_u_boot_loads(project):
    settings = [call[2:4] for call in recorded("qsf", project / f"{NAME}.qsf")
                if call[0] == "set_global_assignment"]
    for name in ("GENERATE_RBF_FILE", "ON_CHIP_BITSTREAM_DECOMPRESSION"):
        assert [name, "ON"] in settings


@pytest.mark.longer
def test_the_page_has_the_command_and_the_files(project):
    page = (Path(__file__).parents[2] / "docs" / "reference" / "de10_nano.md").read_text()
    assert "    ncdc build net.toml --board de10-nano -o board\n" in page
    rows = "".join(re.findall(r"^\|.*\n", page, re.M))
    files = set(re.findall(r"`(\w+\.(?:v|tcl|sh|md|qsf|sdc|dtsi|py|json|c))`", rows))
    assert len(files) >= 15 and files - {path.name for path in project.iterdir()} == set()


def test_the_memory_is_the_processors_for_plan(tmp_path, capsys):
    barrel_descriptor((64, 24), (64, 24), hidden_neurons=2).save(tmp_path / "net.toml")
    assert main(["plan", str(tmp_path / "net.toml"), "--board", "de10-nano"]) == 2
    assert "ncdc plan --memory hps --data-width 64" in capsys.readouterr().err
    assert main(["generate", str(tmp_path / "net.toml"), "-o", str(tmp_path / "out"),
                 "--board", "de10-nano"]) == 2
    assert "ncdc build --board de10-nano" in capsys.readouterr().err
    assert board("de10-nano").device == "5CSEBA6U23I7"
