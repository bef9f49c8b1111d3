"""The Platform Designer system around the corrector, as a script for ``qsys-script``."""

from ncdc_hdl.export.platform_designer import COMPONENT, interfaces

__all__ = ["CSR_BASE", "SYSTEM", "system_tcl"]

SYSTEM = "ncdc_qsys"
CSR_BASE = 0x1000_0000          # of the registers, as the JTAG host sees them; memory is at 0


def system_tcl(board, corrector):
    """Text of ``ncdc_qsys.tcl``: clock, JTAG host, memory controller, corrector.

    Exported are ``clk``, ``reset``, ``irq``, ``front_end_idle``, ``camera_rows``, of a
    streaming corrector ``video``, and ``sdram``, the controller's pins; where the board's memory
    controller is the user's, ``memory`` in its place: an Avalon host, of a bridge through which
    all memory traffic passes. One reset is that of the corrector, of the controller and of all that
    is between them: the corrector's ``memory_reset`` tells it that what it asked for is forgotten.
    """
    lines = [
        f"# Makes {SYSTEM}.qsys: qsys-script --script={SYSTEM}.tcl --search-path=.,$",
        "package require -exact qsys 16.1", "", f"create_system {SYSTEM}",
        f"set_project_property DEVICE_FAMILY {{{board.family}}}",
        f"set_project_property DEVICE {board.device}", ""]
    lines += _instance("clk_0", "clock_source", {
        "clockFrequency": round(board.pll.core_mhz * 1e6), "clockFrequencyKnown": 1,
        "resetSynchronousEdges": "DEASSERT"})
    lines += _instance("master_0", "altera_jtag_avalon_master", {})
    lines += _instance("ncdc_0", COMPONENT, {})
    if board.sdram:
        lines += _instance("memory_0", "altera_avalon_new_sdram_controller",
                           _controller(board.sdram))
        memory, clocked = "memory_0.s1", {"clk": "memory_0.clk", "reset": "memory_0.reset"}
    else:
        lines += _instance("memory_0", "altera_avalon_mm_bridge", {
            "DATA_WIDTH": board.data_width, "ADDRESS_WIDTH": 28, "ADDRESS_UNITS": "SYMBOLS",
            "MAX_BURST_SIZE": 64, "MAX_PENDING_RESPONSES": 64, "LINEWRAPBURSTS": 0,
            "PIPELINE_COMMAND": 1, "PIPELINE_RESPONSE": 1})
        memory, clocked = "memory_0.s0", {"clk": "memory_0.clk", "reset": "memory_0.reset"}

    ports = interfaces(corrector)
    lines += [f"add_connection clk_0.clk {name}" for name in
              ("master_0.clk", "ncdc_0.clock", clocked["clk"])]
    lines += [f"add_connection clk_0.clk_reset {name}" for name in
              ("master_0.clk_reset", "ncdc_0.reset", "ncdc_0.memory_reset", clocked["reset"])]
    hosts = ["master_0.master"] + [f"ncdc_0.{name}" for name, (kind, direction, _) in ports.items()
                                   if (kind, direction) == ("avalon", "start")]
    for host in hosts:
        lines += _connect(host, memory, 0)
    lines += _connect("master_0.master", "ncdc_0.csr", CSR_BASE)
    lines.append("")
    for name, kind, inner in _exports(board, ports):
        lines += [f"add_interface {name} {kind}",
                  f"set_interface_property {name} EXPORT_OF {inner}"]
    return "\n".join([*lines, "", f"save_system {SYSTEM}.qsys", ""])


def _exports(board, ports):
    found = [("clk", "clock sink", "clk_0.clk_in"), ("reset", "reset sink", "clk_0.clk_in_reset"),
             ("irq", "interrupt sender", "ncdc_0.irq"),
             ("front_end_idle", "conduit end", "ncdc_0.front_end_idle"),
             ("camera_rows", "conduit end", "ncdc_0.camera_rows")]
    if "stream" in ports:
        found.append(("video", "avalon_streaming source", "ncdc_0.stream"))
    if board.sdram:
        return [*found, ("sdram", "conduit end", "memory_0.wire")]
    return [*found, ("memory", "avalon master", "memory_0.m0")]


def _instance(name, kind, parameters):
    return [f"add_instance {name} {kind}",
            *(f"set_instance_parameter_value {name} {key} {value}"
              for key, value in parameters.items()), ""]


def _connect(host, agent, base):
    return [f"add_connection {host} {agent}",
            f"set_connection_parameter_value {host}/{agent} baseAddress 0x{base:08x}"]


def _controller(sdram):
    """Parameters of Platform Designer's SDRAM controller."""
    return {"dataWidth": sdram.data_width, "rowWidth": sdram.rows, "columnWidth": sdram.columns,
            "numberOfBanks": sdram.banks, "numberOfChipSelects": 1,
            "casLatency": sdram.cas_latency, "TAC": sdram.t_ac, "TRCD": sdram.t_rcd,
            "TRFC": sdram.t_rfc, "TRP": sdram.t_rp, "TWR": sdram.t_wr,
            "refreshPeriod": sdram.refresh_us, "powerUpDelay": 200.0, "initRefreshCommands": 8,
            "registerDataIn": 1, "generateSimulationModel": 0}
