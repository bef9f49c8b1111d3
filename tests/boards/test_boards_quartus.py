"""Quartus projects of the boards: each Tcl file run with recording stubs, checked against ports."""

import re
import subprocess
from fnmatch import fnmatchcase
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_boards import catalogue
from ncdc_boards.catalogue import board, board_names
from ncdc_boards.de2_115 import BOARD as DE2_115
from ncdc_boards.system import CSR_BASE
from ncdc_boards.top import system_ports
from ncdc_model.errors import InputError

RECORDER = Path(__file__).parents[1] / "support" / "tcl" / "record.tcl"
WITH_PINS = ("de2-115", "de1-soc")
KINDS = {"_hw.tcl": "hw", "_qsys.tcl": "qsys", ".qsf": "qsf", ".sdc": "sdc"}
# Ports that Platform Designer gives to what the system exports.
EXPORTED = {"clk": {"clk_clk"}, "reset": {"reset_reset_n"}, "irq": {"irq_irq"},
            "front_end_idle": {"front_end_idle_export"}, "camera_rows": {"camera_rows_export"},
            "video": {f"video_{name}" for name in ("valid", "ready", "data", "startofpacket",
                                                   "endofpacket")},
            "sdram": {f"sdram_{name}" for name in ("addr", "ba", "cas_n", "cke", "cs_n", "dq",
                                                   "dqm", "ras_n", "we_n")}}


@pytest.fixture(scope="module")
def projects(tmp_path_factory):
    """Folder of the generated project by board, and None for a generation without one."""
    folder = tmp_path_factory.mktemp("boards")
    barrel_descriptor((640, 480), (640, 480)).save(folder / "net.toml")
    for name in board_names():
        assert main(["generate", str(folder / "net.toml"), "-o", str(folder / name),
                     "--board", name]) == 0
    assert main(["generate", str(folder / "net.toml"), "-o", str(folder / "None")]) == 0
    return {name: folder / str(name) for name in (None, *board_names())}


def run_tcl(path):
    """Calls that a Tcl file makes: lists of words."""
    kind = next(kind for ending, kind in KINDS.items() if path.name.endswith(ending))
    done = subprocess.run(["tclsh", RECORDER, kind, path], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, cwd=path.parent)
    assert done.returncode == 0, done.stderr
    return [line.split("\x1f") for line in done.stdout.splitlines()]


# In the list of ports, or behind it as Amaranth's converter declares those of the board's top.
_PORT = r"^  (input|output|inout) +(?:wire +|reg +)?(?:\[(\d+):0\] )?(\w+)"


def ports_of(path, module):
    """(direction, width) of each port of a module of a Verilog file, by name."""
    body = re.search(rf"^module {module} ?\(.*?^endmodule", path.read_text(), re.M | re.S).group()
    return {name: (flow, int(high or 0) + 1) for flow, high, name in
            re.findall(_PORT, body, re.M)}


@pytest.mark.parametrize("name", [None, *WITH_PINS, "faka2"])
def test_component_has_every_port_of_the_verilog_once(projects, name):
    calls = run_tcl(projects[name] / "ncdc_hw.tcl")
    declared = [call[2:] for call in calls if call[0] == "add_interface_port"]
    assert len({port for port, *_ in declared}) == len(declared)
    flow = {"Input": "input", "Output": "output"}
    assert {port: (flow[direction], int(width)) for port, _, direction, width in declared} == \
        ports_of(projects[name] / "ncdc.v", "ncdc")
    interfaces = {call[1]: call[2:] for call in calls if call[0] == "add_interface"}
    assert {call[1] for call in calls if call[0] in ("add_interface_port",
                                                     "set_interface_property")} <= set(interfaces)
    hosts = {i for i, kind in interfaces.items() if kind == ["avalon", "start"]}
    assert hosts == {i for i in interfaces if i.startswith(("read", "write"))} != set()
    for call in calls:
        if call[0] == "set_interface_property" and call[2].startswith("associated"):
            assert call[3] in interfaces
    roles = {call[1]: set() for call in calls if call[0] == "add_interface"}
    for call in calls:
        if call[0] == "add_interface_port":
            roles[call[1]].add(call[3])
    assert roles["read0"] == {"address", "read", "burstcount", "waitrequest", "readdata",
                              "readdatavalid"}
    assert roles["csr"] == {"address", "read", "write", "writedata", "readdata", "readdatavalid",
                            "waitrequest"}
    files = {call[1] for call in calls if call[0] == "add_fileset_file"}
    assert files == {"ncdc.v"}


@pytest.mark.parametrize("name", [*WITH_PINS, "faka2"])
def test_system_connects_what_exists(projects, name):
    calls = run_tcl(projects[name] / "ncdc_qsys.tcl")
    hw = run_tcl(projects[name] / "ncdc_hw.tcl")
    ours = {call[1]: call[2:] for call in hw if call[0] == "add_interface"}
    instances = {call[1]: call[2] for call in calls if call[0] == "add_instance"}
    assert set(instances) == {"clk_0", "master_0", "ncdc_0", "memory_0"}
    # The memory forgets in the reset of the corrector, and the corrector is told.
    assert {call[2] for call in calls if call[:2] == ["add_connection", "clk_0.clk_reset"]} \
        >= {"ncdc_0.reset", "ncdc_0.memory_reset", "memory_0.reset"}
    assert ours["memory_reset"] == ["reset", "end"]
    changed = {call[1] for call in calls if call[0] == "set_instance_parameter_value"}
    assert changed <= set(instances)
    used = set()
    for call in calls:
        ends = call[1:3] if call[0] == "add_connection" else \
            [call[3]] if call[0] == "set_interface_property" else []
        for instance, interface in (end.split(".") for end in ends):
            assert instance in instances
            if instance == "ncdc_0":
                assert interface in ours
                used.add(interface)
    assert used == set(ours), "an interface of the corrector is neither connected nor exported"
    bases = {call[1]: int(call[3], 16) for call in calls
             if call[0] == "set_connection_parameter_value"}
    assert bases.pop("master_0.master/ncdc_0.csr") == CSR_BASE
    assert set(bases.values()) == {0}
    sdram = board(name).sdram
    assert sdram is None or sdram.bytes <= CSR_BASE
    exports = {call[1] for call in calls if call[0] == "add_interface"}
    if name in WITH_PINS:
        assert set().union(*(EXPORTED[export] for export in exports)) == system_ports()
    else:
        named = re.findall(r"^- `(\w+)`", (projects[name] / "PORTS.md").read_text(), re.M)
        assert set(named) == exports


def test_memory_sizes_are_the_boards():
    assert DE2_115.sdram.bytes == 128 << 20 and board("de1-soc").sdram.bytes == 64 << 20


@pytest.mark.parametrize("name", WITH_PINS)
def test_every_port_bit_of_the_top_has_its_own_pin(projects, name):
    folder, project = projects[name], f"ncdc_{name.replace('-', '_')}"
    calls = run_tcl(folder / f"{project}.qsf")
    pins = {to: pin for command, _, to, pin in
            (call for call in calls if call[0] == "set_location_assignment")}
    bits = {f"{port}[{k}]" if width > 1 else port
            for port, (_, width) in ports_of(folder / f"{project}.v", project).items()
            for k in range(width)}
    assert set(pins) == bits
    assert len(set(pins.values())) == len(pins), "a pin is used twice"
    settings = {call[2]: call[3] for call in calls if call[0] == "set_global_assignment"}
    assert settings["DEVICE"] == board(name).device
    assert settings["TOP_LEVEL_ENTITY"] == project
    # Facts of the board's published assignments.
    some = {"de2-115": {"clk50_0__io": "PIN_Y2", "sdram_0__clk__io": "PIN_AE5",
                        "sdram_0__dq__io[31]": "PIN_U1", "vga_0__r__io[7]": "PIN_H10",
                        "d5m_0__pixclk__io": "PIN_AB22", "d5m_0__d__io[11]": "PIN_AC15",
                        "d5m_0__d__io[0]": "PIN_AF15", "d5m_0__sclk__io": "PIN_AH25"},
            "de1-soc": {"clk50_0__io": "PIN_AF14", "sdram_0__clk__io": "PIN_AH12",
                        "sdram_0__dq__io[15]": "PIN_AJ5", "vga_0__g__io[0]": "PIN_J9",
                        "d5m_0__pixclk__io": "PIN_AC18"}}[name]
    assert {to: pins[to] for to in some} == some
    table = dict(re.findall(r"^\| `([^`]+)` \| (\w+) \|", (folder / "PORTS.md").read_text(), re.M))
    assert {to: f"PIN_{pin}" for to, pin in table.items()} == pins


@pytest.mark.parametrize("name", WITH_PINS)
def test_constraints_name_ports_that_exist(projects, name):
    folder, project = projects[name], f"ncdc_{name.replace('-', '_')}"
    calls = run_tcl(folder / f"{project}.sdc")
    ports = ports_of(folder / f"{project}.v", project)
    patterns = [pattern for call in calls if call[0] == "get_ports" for pattern in call[1].split()]
    assert len(patterns) > 10
    assert [p for p in patterns if not any(fnmatchcase(port, p) for port in ports)] == []
    delayed = {port for call in calls if call[0] in ("set_output_delay", "set_input_delay")
               for port in ports for pattern in re.findall(r"[\w*]+", call[-1])
               if fnmatchcase(port, pattern)}
    # The SDRAM's clock and byte masks, which are constant, and the camera held in reset need none.
    assert {port for port in ports if port.startswith(("sdram", "vga"))} - delayed <= \
        {"sdram_0__clk__io", "sdram_0__dqm__io"}
    clock, = (call for call in calls if call[0] == "create_clock")
    assert clock[clock.index("-period") + 1] == "20.0"


def test_a_board_without_published_pins_says_so(projects):
    calls = run_tcl(projects["faka2"] / "ncdc_faka2.qsf")
    assert not [call for call in calls if call[0] == "set_location_assignment"]
    run_tcl(projects["faka2"] / "ncdc_faka2.sdc")
    assert "every pin: the board's pin-out was never published" in \
        (projects["faka2"] / "PORTS.md").read_text()


@pytest.mark.parametrize("name", WITH_PINS)
def test_top_elaborates_with_its_instances(projects, name, tmp_path):
    """Icarus accepts the top beside empty modules that have the ports it connects."""
    folder, project = projects[name], f"ncdc_{name.replace('-', '_')}"
    width = board(name).sdram.data_width
    widths = {"sdram_addr": 13, "sdram_ba": 2, "sdram_dq": width, "sdram_dqm": width // 8,
              "video_data": 24, "camera_rows_export": 13}
    flows = dict.fromkeys(("clk_clk", "reset_reset_n", "video_ready", "camera_rows_export"),
                          "input") | {
        "sdram_dq": "inout"}
    system = ", ".join(f"{flows.get(port, 'output')} [{widths.get(port, 1) - 1}:0] {port}"
                       for port in sorted(system_ports()))
    (tmp_path / "system.v").write_text(f"module ncdc_qsys({system}); endmodule\n")
    done = subprocess.run(["iverilog", "-g2001", "-Wall", "-Wno-timescale", "-t", "null",
                           "-s", project, folder / f"{project}.v", tmp_path / "system.v",
                           Path(__file__).parents[1] / "support" / "hdl" / "altera_stubs.v"],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode == 0, done.stdout
    assert "port" not in done.stdout, done.stdout


@pytest.mark.parametrize("name", [*WITH_PINS, "faka2"])
def test_build_script_is_a_shell_script_of_quartus_tools(projects, name):
    script = projects[name] / "build.sh"
    subprocess.run(["sh", "-n", script], check=True)
    commands = [line.split()[0] for line in script.read_text().splitlines()
                if line and not line.startswith(("#", "set"))]
    assert commands == ["qsys-script", "qsys-generate", "quartus_map", "quartus_fit", "quartus_asm",
                        "quartus_sta"]


def test_a_misspelt_command_is_noticed(projects, tmp_path):
    text = (projects["faka2"] / "ncdc_hw.tcl").read_text()
    (tmp_path / "bad_hw.tcl").write_text(text.replace("add_interface_port csr csr_read ",
                                                      "add_interface_prot csr csr_read ", 1))
    with pytest.raises(AssertionError, match='invalid command name "add_interface_prot"'):
        run_tcl(tmp_path / "bad_hw.tcl")


def test_two_generations_are_identical(projects, tmp_path):
    folder = projects["de2-115"]
    assert main(["generate", str(folder.parent / "net.toml"), "-o", str(tmp_path),
                 "--board", "de2-115"]) == 0
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == \
        {p.name: p.read_bytes() for p in folder.iterdir()}


def test_other_packages_may_offer_boards(monkeypatch):
    points = [EntryPoint("mine", "ncdc_boards.de2_115:BOARD", catalogue.GROUP)]
    monkeypatch.setattr(catalogue, "entry_points", lambda group: points)
    assert board_names() == ["mine"] and board("mine") is DE2_115
    with pytest.raises(InputError, match="board is 'de2-115', one of mine is needed"):
        board("de2-115")


@pytest.mark.parametrize("options,message", [
    (["--board", "de0"], "board is 'de0', one of de1-soc, de2-115, faka2 is needed"),
    (["--board", "de2-115", "--to", "memory"], "board de2-115 shows the corrected stream"),
])
def test_bad_boards_are_refused(projects, tmp_path, capsys, options, message):
    net = projects["de2-115"].parent / "net.toml"
    assert main(["generate", str(net), "-o", str(tmp_path / "out"), *options]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1 and not (tmp_path / "out").exists()


def test_a_picture_beyond_every_video_mode_is_refused(tmp_path, capsys):
    barrel_descriptor((2048, 1100), (640, 480)).save(tmp_path / "net.toml")
    assert main(["generate", str(tmp_path / "net.toml"), "-o", str(tmp_path / "out"),
                 "--board", "de1-soc"]) == 2
    assert "2048x1100 pixels, the largest video mode has 1920x1080" in capsys.readouterr().err
