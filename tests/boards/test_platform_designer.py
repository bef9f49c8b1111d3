"""The component and the project for Platform Designer: each Tcl file run with recording stubs,
compared with the ports."""

import re
import subprocess
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_boards import catalogue
from ncdc_boards.catalogue import board, board_names
from ncdc_boards.platform_designer.faka2 import BOARD as FAKA2
from ncdc_boards.platform_designer.system import CSR_BASE
from ncdc_spec.errors import InputError
from ncdc_spec.registers.link_map import LINK_WORDS_BITS
from ncdc_spec.registers.system_map import SYSTEM_WORDS_BITS

RECORDER = Path(__file__).parents[1] / "support" / "tcl" / "record.tcl"
KINDS = {"_hw.tcl": "hw", "_qsys.tcl": "qsys", ".qsf": "qsf", ".sdc": "sdc"}


@pytest.fixture(scope="module")
def projects(tmp_path_factory):
    """Folder of the generated project by board, and None for a generation without one."""
    folder = tmp_path_factory.mktemp("boards")
    barrel_descriptor((640, 480), (640, 480)).save(folder / "net.toml")
    assert main(["generate", str(folder / "net.toml"), "-o", str(folder / "faka2"),
                 "--board", "faka2"]) == 0
    assert main(["generate", str(folder / "net.toml"), "-o", str(folder / "None")]) == 0
    return {name: folder / str(name) for name in (None, "faka2")}


def run_tcl(path, kind=None):
    """Calls that a Tcl file makes: lists of words. ``kind``: if its name does not say."""
    kind = kind or next(kind for ending, kind in KINDS.items() if path.name.endswith(ending))
    done = subprocess.run(["tclsh", RECORDER, kind, path], capture_output=True, text=True,
                          cwd=path.parent)
    assert done.returncode == 0, done.stderr
    return [line.split("\x1f") for line in done.stdout.splitlines()]


# In the list of ports, or after it as Amaranth's converter declares those of the board's top.
_PORT = r"^  (input|output|inout) +(?:wire +|reg +)?(?:\[(\d+):0\] )?(\w+)"


def ports_of(path, module):
    """(direction, width) of each port of a module of a Verilog file, by name."""
    body = re.search(rf"^module {module} ?\(.*?^endmodule", path.read_text(), re.M | re.S).group()
    return {name: (flow, int(high or 0) + 1) for flow, high, name in
            re.findall(_PORT, body, re.M)}


@pytest.mark.longer
@pytest.mark.parametrize("name", [None, "faka2"])
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


@pytest.mark.longer
def test_system_connects_what_exists(projects):
    name = "faka2"
    calls = run_tcl(projects[name] / "ncdc_qsys.tcl")
    hw = run_tcl(projects[name] / "ncdc_hw.tcl")
    ours = {call[1]: call[2:] for call in hw if call[0] == "add_interface"}
    instances = {call[1]: call[2] for call in calls if call[0] == "add_instance"}
    assert set(instances) == {"clk_0", "master_0", "ncdc_0", "memory_0"}
    # The memory forgets in the reset of the corrector, and the corrector is notified.
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
    exports = {call[1] for call in calls if call[0] == "add_interface"}
    named = re.findall(r"^- `(\w+)`", (projects[name] / "PORTS.md").read_text(), re.M)
    assert set(named) == exports


# Interfaces of the vendor's components, as scripts for qsys-script of other projects have them.
VENDOR = {
    "clock_source": "clk_in clk_in_reset clk clk_reset",
    "intel_niosv_m": "clk reset data_manager instruction_manager platform_irq_rx timer_sw_agent "
                     "dm_agent",
    "altera_avalon_onchip_memory2": "clk1 reset1 s1",
    "altera_avalon_jtag_uart": "clk reset avalon_jtag_slave irq",
    "altera_avalon_mm_bridge": "clk reset s0 m0",
    "altera_eth_tse": "control_port_clock_connection reset_connection transmit_clock_connection "
                      "receive_clock_connection control_port transmit receive "
                      "pcs_mac_tx_clock_connection pcs_mac_rx_clock_connection "
                      "mac_rgmii_connection mac_mdio_connection mac_status_connection "
                      "mac_misc_connection",
    "altera_msgdma": "clock reset_n csr csr_irq descriptor_slave response mm_read mm_write "
                     "st_source st_sink",
    "multiplexer": "clk reset in0 in1 out",
    "altera_avalon_st_channel_stripper": "clk reset in out"}


@pytest.fixture(scope="module")
def niosv(projects, tmp_path_factory):
    """Calls of the Nios V's script; interfaces of each of its instances, ours by their files."""
    folder = tmp_path_factory.mktemp("niosv")
    assert main(["generate", str(projects["faka2"].parent / "net.toml"), "-o", str(folder),
                 "--system", "--packetiser", "--niosv"]) == 0
    calls = run_tcl(folder / "ncdc_niosv.tcl", "qsys")
    found = {}
    for _, name, kind in (call for call in calls if call[0] == "add_instance"):
        if kind in VENDOR:
            found[name] = set(VENDOR[kind].split())
        else:
            found[name] = {call[1] for call in run_tcl(folder / f"{kind}_hw.tcl")
                           if call[0] == "add_interface"}
    return calls, found


@pytest.mark.longer
def test_niosv_joins_what_exists(niosv):
    calls, found = niosv
    ends = [end for call in calls if call[0] == "add_connection" for end in call[1:3]]
    ends += [call[3] for call in calls if call[0] == "set_interface_property"]
    used = {name: set() for name in found}
    for instance, interface in (end.split(".") for end in ends):
        assert interface in found[instance], (instance, interface)
        used[instance].add(interface)
    for ours in ("ncdc_0", "packets_0"):
        assert used[ours] == found[ours], "an interface is neither connected nor exported"
    sinks = [call[2] for call in calls if call[0] == "add_connection"]
    for instance in set(found) - {"clk_0"}:
        assert any(sink.startswith(f"{instance}.") and "reset" in sink for sink in sinks)


@pytest.mark.longer
def test_niosv_s_addresses_do_not_overlap(niosv):
    calls, _ = niosv
    bases = {call[1]: int(call[3], 16) for call in calls
             if call[0] == "set_connection_parameter_value" and call[2] == "baseAddress"}
    sizes = {"ram_0.s1": 128 << 10, "cpu_0.dm_agent": 64 << 10, "cpu_0.timer_sw_agent": 64,
             "uart_0.avalon_jtag_slave": 8, "mac_0.control_port": 1 << 10, "receive_0.csr": 32,
             "receive_0.descriptor_slave": 32, "receive_0.response": 8, "send_0.csr": 32,
             "send_0.descriptor_slave": 32, "packets_0.csr": 4 << LINK_WORDS_BITS,
             "ncdc_0.csr": 4 << SYSTEM_WORDS_BITS, "memory_0.s0": 1 << 28}
    for host in ("cpu_0.data_manager", "cpu_0.instruction_manager"):
        spans = sorted((base, base + sizes[name.partition("/")[2]]) for name, base in bases.items()
                       if name.startswith(f"{host}/"))
        assert all(base % (end - base) == 0 for base, end in spans)
        assert all(end <= base for (_, end), (base, _) in zip(spans, spans[1:]))
    assert {base for name, base in bases.items() if not name.startswith("cpu_0")} == {0}
    numbers = [call[3] for call in calls
               if call[0] == "set_connection_parameter_value" and call[2] == "irqNumber"]
    assert sorted(numbers) == [str(k) for k in range(5)]


@pytest.mark.longer
def test_niosv_needs_what_it_joins(projects, tmp_path, capsys):
    net = projects["faka2"].parent / "net.toml"
    assert main(["generate", str(net), "-o", str(tmp_path / "out"), "--niosv"]) == 2
    assert "--niosv is given, it needs --system and --packetiser" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.longer
def test_a_board_without_published_pins_says_so(projects):
    calls = run_tcl(projects["faka2"] / "ncdc_faka2.qsf")
    assert not [call for call in calls if call[0] == "set_location_assignment"]
    run_tcl(projects["faka2"] / "ncdc_faka2.sdc")
    assert "every pin: the board's pin-out was never published" in \
        (projects["faka2"] / "PORTS.md").read_text()


@pytest.mark.longer
def test_build_script_is_a_shell_script_of_quartus_tools(projects):
    script = projects["faka2"] / "build.sh"
    subprocess.run(["sh", "-n", script], check=True)
    commands = [line.split()[0] for line in script.read_text().splitlines()
                if line and not line.startswith(("#", "set"))]
    assert commands == ["qsys-script", "qsys-generate", "quartus_map", "quartus_fit", "quartus_asm",
                        "quartus_sta"]


@pytest.mark.longer
def test_a_misspelt_command_is_noticed(projects, tmp_path):
    text = (projects["faka2"] / "ncdc_hw.tcl").read_text()
    (tmp_path / "bad_hw.tcl").write_text(text.replace("add_interface_port csr csr_read ",
                                                      "add_interface_prot csr csr_read ", 1))
    with pytest.raises(AssertionError, match='invalid command name "add_interface_prot"'):
        run_tcl(tmp_path / "bad_hw.tcl")


@pytest.mark.longer
def test_two_generations_are_identical(projects, tmp_path):
    folder = projects["faka2"]
    assert main(["generate", str(folder.parent / "net.toml"), "-o", str(tmp_path),
                 "--board", "faka2"]) == 0
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == \
        {p.name: p.read_bytes() for p in folder.iterdir()}


def test_other_packages_may_offer_boards(monkeypatch):
    points = [EntryPoint("mine", "ncdc_boards.platform_designer.faka2:BOARD", catalogue.GROUP)]
    monkeypatch.setattr(catalogue, "entry_points", lambda group: points)
    assert board_names() == ["mine"] and board("mine") is FAKA2
    with pytest.raises(InputError, match="board is 'faka2', one of mine is needed"):
        board("faka2")


@pytest.mark.longer
@pytest.mark.parametrize("options,message", [
    (["--board", "de0"], "board is 'de0', one of colorlight-i9, de0-cv, de1-soc, "
     "de10-nano, de2-115, faka2, ulx3s is needed"),
    (["--board", "de2-115"], "de2-115 has a whole design, with camera and screen: ncdc build"),
])
def test_bad_boards_are_rejected(projects, tmp_path, capsys, options, message):
    net = projects["faka2"].parent / "net.toml"
    assert main(["generate", str(net), "-o", str(tmp_path / "out"), *options]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1 and not (tmp_path / "out").exists()
