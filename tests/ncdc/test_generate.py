"""Generated files: the Verilog and the lenses in C, what compilers say, when they change."""

import os
import re
import subprocess
import sys
from dataclasses import replace

import amaranth
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_sim.tools import WAIVERS, environment, tool
from ncdc_spec.hardware import OUTPUTS, Hardware
from ncdc_spec.registers.host_values import host_values

FILES = ("ncdc.v", "ncdc_lenses.c")
CHECKS = (("icarus", ("-g2012", "-t", "null", "-s", "ncdc")),
          ("verilator", ("--lint-only", *WAIVERS)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with two descriptors; the raw width is no multiple of any memory word."""
    path = tmp_path_factory.mktemp("generate")
    for name, seed in (("net", 1), ("other", 2)):
        barrel_descriptor((40, 24), (50, 34), hidden_neurons=2, seed=seed,
                          fill=(250, 20, 3)).save(path / f"{name}.toml")
    return path


def descriptor(name="net"):
    return barrel_descriptor((40, 24), (50, 34), hidden_neurons=2,
                             seed={"net": 1, "other": 2}[name], fill=(250, 20, 3))


def generate(folder, output, name="net", **options):
    """Files that ``ncdc generate`` writes, as text."""
    arguments = [text for key, value in options.items()
                 for text in (f"--{key.replace('_', '-')}", str(value))]
    assert main(["generate", str(folder / f"{name}.toml"), "-o", str(output), *arguments]) == 0
    return [(output / file).read_text() for file in FILES]


def compile_with(simulator, verilog, folder, *options):
    """Exit status and the lines that a simulator's compiler prints about the Verilog."""
    (folder / "ncdc.v").write_text(verilog)
    done = subprocess.run([tool(simulator), *options, "ncdc.v"], cwd=folder, env=environment(),
                          text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    # Verilator reports its time and memory in lines that begin with a dash.
    return done.returncode, [line for line in done.stdout.splitlines() if line[:2] != "- "]


@pytest.mark.longer
def test_processes_write_identical_bytes(folder):
    """A process that hashes otherwise equals this one, or the one whose files are cached."""
    generate(folder, folder / "1")
    run = "3" if os.environ.get("PYTHONHASHSEED") == "2" else "2"
    subprocess.run(
        [sys.executable, "-c", "from ncdc.cli import main; raise SystemExit(main())",
         "generate", str(folder / "net.toml"), "-o", str(folder / "2")],
        check=True, env={**os.environ, "PYTHONHASHSEED": run})
    for file in FILES:
        assert (folder / "1" / file).read_bytes() == (folder / "2" / file).read_bytes(), file


@pytest.mark.longer
@pytest.mark.parametrize("data_width,to", [
    (32, "memory"), pytest.param(64, "memory", marks=pytest.mark.regress), (128, "stream")])
def test_compilers_accept_the_verilog(folder, tmp_path, data_width, to):
    verilog, _ = generate(folder, tmp_path / "out", data_width=data_width, to=to)
    for simulator, options in CHECKS:
        assert compile_with(simulator, verilog, tmp_path, *options) == (0, []), simulator


@pytest.mark.longer
def test_a_broken_line_is_not_accepted(folder, tmp_path):
    """The compilers' silence above means something: both name a signal that is not there."""
    verilog, _ = generate(folder, tmp_path / "out")
    broken = verilog.replace("\nendmodule", "\n  assign irq = not_there;\nendmodule")
    for simulator, options in CHECKS:
        status, lines = compile_with(simulator, broken, tmp_path, *options)
        assert status and any("not_there" in line for line in lines), simulator


@pytest.mark.longer
def test_header_of_the_verilog_names_descriptor_and_options(folder, tmp_path):
    verilog, _ = generate(folder, tmp_path, data_width=64, to="stream")
    comment = verilog.partition("\n\n")[0]
    assert all(line.startswith("//") for line in comment.splitlines())
    words = " ".join(line.removeprefix("//").strip() for line in comment.splitlines())
    for text in (descriptor().digest[:12], "2 hidden neurons", "50x34 raw RGGB", "40x24 corrected",
                 "--cache-bytes 8192", "--data-width 64", "--to stream", amaranth.__version__):
        assert text in words, text


@pytest.mark.longer
def test_another_network_gives_another_text(folder, tmp_path):
    one, two = generate(folder, tmp_path), generate(folder, tmp_path, "other")
    assert one[0] != two[0] and one[1] != two[1]
    assert descriptor("other").digest in two[0]


@pytest.mark.longer
def test_unchanged_files_are_not_rewritten(folder, tmp_path):
    generate(folder, tmp_path)
    before = [(tmp_path / file).stat() for file in FILES]
    generate(folder, tmp_path)
    after = [(tmp_path / file).stat() for file in FILES]
    assert [(s.st_mtime_ns, s.st_ino) for s in after] == [(s.st_mtime_ns, s.st_ino) for s in before]
    generate(folder, tmp_path, "other")
    assert all((tmp_path / file).stat().st_ino != s.st_ino for file, s in zip(FILES, before))


@pytest.mark.longer
def test_verilog_resets_to_the_values_of_the_host(folder, tmp_path):
    """What a host would write is what the shadow registers hold after configuration."""
    verilog, _ = generate(folder, tmp_path, data_width=128)
    _, _, verilog = verilog.partition("module ncdc_registers (")
    verilog, _, _ = verilog.partition("endmodule")
    for name, value in host_values(descriptor(), Hardware(data_width=128)).items():
        match = re.search(rf"^  reg (?:\[\d+:0\] )?{name.lower()} = (\d+)'([hb])(\w+);", verilog,
                          re.MULTILINE)
        assert match, name
        width, base, digits = int(match[1]), {"h": 16, "b": 2}[match[2]], match[3]
        assert int(digits, base) == value % 2**width, name


@pytest.mark.parametrize("options", [["--data-width", "16"], ["--to", "disk"], ["--fetch", "none"]])
def test_options_outside_the_choices(folder, tmp_path, options, capsys):
    with pytest.raises(SystemExit) as end:
        main(["generate", str(folder / "net.toml"), "-o", str(tmp_path), *options])
    assert end.value.code == 2
    error = capsys.readouterr().err
    assert options[1] in error and error.count("\n") == 1


@pytest.mark.longer
def test_every_output_and_width_has_its_ports(folder, tmp_path):
    for to in OUTPUTS:
        verilog, _ = generate(folder, tmp_path / to, to=to, data_width=64)
        assert ("stream_data" in verilog) == (to == "stream")
        assert ("write_writedata" in verilog) == (to == "memory")
        assert re.search(r"^  input  wire +\[63:0\] read0_readdata,", verilog, re.MULTILINE)


@pytest.mark.longer
def test_a_system_is_written_with_the_driver_of_its_camera(folder, capsys):
    """And without the files of a corrector alone."""
    net, output = str(folder / "net.toml"), folder / "system"
    assert main(["generate", net, "-o", str(output), "--system", "--data-width", "64"]) == 0
    names = {path.name for path in output.iterdir()}
    assert {"ncdc_system.v", "ncdc_system.vlt", "ncdc_camera.py", "ncdc_registers.h"} <= names
    assert not {"ncdc.v", "ncdc.core", "ncdc_hw.tcl"} & names
    verilog = (output / "ncdc_system.v").read_text()
    assert "--system" in verilog and "--data-width 64" in verilog
    assert re.search(r"NCDC_RAW0_BASE 0x11100u", (output / "ncdc_registers.h").read_text())
    rejected = ["generate", net, "-o", str(folder / "none"), "--system", "--board", "faka2"]
    assert main(rejected) == 2
    assert "--system" in capsys.readouterr().err
    assert not (folder / "none").exists()


CAMERAS = {"axis --samples-per-clock 2 --sample-bits 10": (
               "24 sensor_tdata", "SOURCE_FAULTS VIDEO_SHORT VIDEO_STRAY"),
           "avalon-st:vip --samples-per-clock 4 --sample-bits 8": (
               "32 sensor_data", "SOURCE_FAULTS VIDEO_SHORT VIDEO_STRAY VIDEO_SIZE"),
           "csi2:2": ("8 sensor_lane1_data", "SOURCE_FAULTS CSI_CHANNEL CSI_TYPE CSI_CHECKSUM")}


@pytest.mark.longer
@pytest.mark.parametrize("camera", CAMERAS)
def test_a_system_for_another_camera(folder, camera, tmp_path):
    """Its ports are those of the component of Platform Designer; its registers those of the
    drivers."""
    (port, names), net = CAMERAS[camera], str(folder / "net.toml")
    assert main(["generate", net, "-o", str(tmp_path), "--system", "--camera",
                 *camera.split()]) == 0
    verilog = (tmp_path / "ncdc_system.v").read_text()
    width, name = port.split()
    assert re.search(rf"^  input  wire +\[{int(width) - 1}:0\] {name},", verilog, re.MULTILINE)
    assert f"--camera {camera.split()[0]}" in verilog
    header = (tmp_path / "ncdc_registers.h").read_text()
    for register in names.split():
        assert f"NCDC_{register} " in header
    assert "CSI_TYPE" not in header or camera == "csi2:2"
    tcl = (tmp_path / "ncdc_system_hw.tcl").read_text()
    kind = "avalon_streaming end" if camera.startswith("avalon") else "conduit end"
    assert f"add_interface sensor {kind}" in tcl and f"add_interface_port sensor {name}" in tcl
    if camera.startswith("avalon"):
        assert "set_interface_property sensor associatedClock sensor_clock" in tcl
        assert "set_interface_property sensor symbolsPerBeat 4" in tcl


@pytest.mark.parametrize("options,message", [
    ("--system --board faka2", "--system and --board faka2 are given, its project is of a corr"),
    ("--bus axi --board faka2", "--bus axi and --board faka2 are given, its project is for avalon"),
    ("--name n --board faka2", "--name n and --board are given, its scripts know one core"),
    ("--name n --niosv", "--name n and --niosv are given, its scripts know one core"),
    ("--niosv --system", "--niosv is given, it needs --system and --packetiser"),
    ("--niosv --packetiser", "--niosv is given, it needs --system and --packetiser"),
    ("--niosv --system --packetiser --bus axi", "--niosv is given, it needs --system and"),
    ("--usb ft232h --sensor mt9p031", "--usb ft232h is given, it needs --system"),
    ("--usb ft232h --sensor mt9p031 --system --bus axi", "--usb ft232h and --bus axi are given"),
    ("--usb ft232h --system", "--usb and --sensor are given together"),
    ("--sensor mt9p031 --system", "--usb and --sensor are given together"),
    ("--usb ft232h --sensor imx219 --system", "--sensor imx219 is given, it has CSI-2 lanes: "
     "--camera csi2:2 is needed"),
    ("--system --testbench", "--testbench and --system are given, the test bench is of a corr"),
    ("--camera axis", "--camera axis is given, it needs --system: a corrector alone reads"),
    ("--sample-bits 10", "--sample-bits 10 is given, it needs --system"),
    ("--system --camera usb", "--camera is usb, it must be parallel, axis, avalon-st"),
    ("--system --camera csi2", "--camera is csi2, it must be"),
    ("--system --camera csi2:2 --samples-per-clock 4", "csi2:2 has 2 samples per clock, not 4"),
    ("--system --camera parallel --samples-per-clock 2", "has 1 sample per clock, not 2"),
    ("--system --sample-bits 10", "of the kind parallel has samples of 12 bits, not 10"),
    ("--to stream --video vip --board faka2", "--video vip and --board are given, the projects"),
    ("--to stream --video vip --testbench", "--video vip and --testbench are given, the test")])
def test_conflicting_options_are_rejected(folder, tmp_path, options, message, capsys):
    output = tmp_path / "out"
    assert main(["generate", str(folder / "net.toml"), "-o", str(output), *options.split()]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1 and not output.exists()


def test_a_view_is_generated_at_nodes_only(folder, tmp_path, capsys):
    """The header names the option; its lens begins with the trained picture."""
    wide = barrel_descriptor((200, 40), (210, 50), hidden_neurons=2)
    replace(wide, nodes=8).save(folder / "nodes.toml")
    nodes, hardware = str(folder / "nodes.toml"), tmp_path / "hardware"
    fixed = ["--cache-bytes", "1024", "--cache-split", "1", "--strip", "0"]
    assert main(["generate", nodes, "-o", str(hardware), "--view", "--views", "3", *fixed]) == 0
    assert " --view --views 3" in (hardware / "ncdc.v").read_text().partition("module")[0]
    assert "VIEW_X_U" in (hardware / "ncdc_lenses.py").read_text()
    assert "NCDC_VIEW2_PITCH" in (hardware / "ncdc_registers.h").read_text()
    assert main(["generate", nodes, "-o", str(hardware), "--view", "--view-rows", "3", *fixed]) == 0
    assert " --view --view-rows 3" in (hardware / "ncdc.v").read_text().partition("module")[0]
    lenses = (hardware / "ncdc_lenses.py").read_text()
    assert "VIEW_X_U" in lenses and '"VIEW_ROWS": 0' in lenses
    capsys.readouterr()
    assert main(["generate", nodes, "-o", str(tmp_path / "none"), "--views", "3"]) == 2
    assert "the number of views is 3, it needs hardware with a view" in capsys.readouterr().err
    assert main(["generate", str(folder / "net.toml"), "-o", str(tmp_path / "none"),
                 "--view"]) == 2
    assert "evaluated at every pixel, a view needs nodes" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()
    for numbers, sentence in (
            ("1 0 0 0 1 0 0 0 nan", "--matrix is 1 0 0 0 1 0 0 0 nan, nine finite numbers"),
            ("500 0 0 0 1 0 0 0 1", "the view's matrix has 500 in row 0, column 0, the limit is "
                                    "128 times its largest depth of 1")):
        assert main(["simulate", nodes, "none.png", "-o", str(tmp_path / "out.png"), "--matrix",
                     *numbers.split()]) == 2
        assert sentence in capsys.readouterr().err
