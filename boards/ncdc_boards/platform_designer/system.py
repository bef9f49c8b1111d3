"""The Platform Designer system around the corrector, as a script for ``qsys-script``."""

from ncdc_boards.platform_designer.script import connect, exported, header, instance
from ncdc_hdl.export.ip.platform_designer import COMPONENT, interfaces

__all__ = ["CSR_BASE", "SYSTEM", "exports", "system_tcl"]

SYSTEM = "ncdc_qsys"
CSR_BASE = 0x1000_0000          # of the registers in the JTAG host's map; memory is at 0


def system_tcl(board, corrector):
    """Text of ``ncdc_qsys.tcl``: clock, JTAG host, corrector, and a bridge to its memory.

    The exports are those of :func:`exports`. ``memory`` is an Avalon host of a bridge through
    which all memory traffic passes. One reset is that of the corrector, of the bridge and of all
    between them: ``memory_reset`` makes the corrector drop its requests.
    """
    lines = header(SYSTEM, board.family, board.device, " --search-path=.,$")
    lines += instance("clk_0", "clock_source", {
        "clockFrequency": round(board.core_mhz * 1e6), "clockFrequencyKnown": 1,
        "resetSynchronousEdges": "DEASSERT"})
    lines += instance("master_0", "altera_jtag_avalon_master", {})
    lines += instance("ncdc_0", COMPONENT, {})
    lines += instance("memory_0", "altera_avalon_mm_bridge", {
        "DATA_WIDTH": board.data_width, "ADDRESS_WIDTH": 28, "ADDRESS_UNITS": "SYMBOLS",
        "MAX_BURST_SIZE": 64, "MAX_PENDING_RESPONSES": 64, "LINEWRAPBURSTS": 0,
        "PIPELINE_COMMAND": 1, "PIPELINE_RESPONSE": 1})

    ports = interfaces(corrector)
    lines += [f"add_connection clk_0.clk {name}" for name in
              ("master_0.clk", "ncdc_0.clock", "memory_0.clk")]
    lines += [f"add_connection clk_0.clk_reset {name}" for name in
              ("master_0.clk_reset", "ncdc_0.reset", "ncdc_0.memory_reset", "memory_0.reset")]
    hosts = ["master_0.master"] + [f"ncdc_0.{name}" for name, (kind, direction, _) in ports.items()
                                   if (kind, direction) == ("avalon", "start")]
    for host in hosts:
        lines += connect(host, "memory_0.s0", 0)
    lines += connect("master_0.master", "ncdc_0.csr", CSR_BASE)
    lines.append("")
    for name, kind, inner in exports(corrector):
        lines += exported(name, kind, inner)
    return "\n".join([*lines, "", f"save_system {SYSTEM}.qsys", ""])


def exports(corrector):
    """Name, kind and inner interface of what the system exports."""
    found = [("clk", "clock sink", "clk_0.clk_in"), ("reset", "reset sink", "clk_0.clk_in_reset"),
             ("irq", "interrupt sender", "ncdc_0.irq"),
             ("front_end_idle", "conduit end", "ncdc_0.front_end_idle"),
             ("camera_rows", "conduit end", "ncdc_0.camera_rows"),
             ("memory", "avalon master", "memory_0.m0")]
    if "stream" in interfaces(corrector):
        found.append(("video", "avalon_streaming source", "ncdc_0.stream"))
    return found
