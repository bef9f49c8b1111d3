"""The processor in Platform Designer, and bridges to it, as a script for ``qsys-script``."""

from ncdc_boards.hps_board.ports import BURST_WORDS, PORTS, SYSTEM
from ncdc_boards.platform_designer.script import connect, exported, header, instance

__all__ = ["EXPORTS", "system_tcl"]

_REGISTER_BITS = 17         # byte addresses of a camera system's registers, 128 KB
EXPORTS = {
    "clk": ("clock sink", "clk_0.clk_in"), "reset": ("reset sink", "clk_0.clk_in_reset"),
    "hps_reset": ("reset source", "hps_0.h2f_reset"),
    "irq": ("interrupt receiver", "hps_0.f2h_irq0"), "memory": ("conduit end", "hps_0.memory"),
    "csr": ("avalon master", "csr_0.m0"),
    **{name: ("avalon slave", f"{name}_0.s0") for name in PORTS}}
"""Kind and inner interface of what the system exports."""


def system_tcl(board):
    """Text of ``ncdc_qsys.tcl``: the processor, its ports to the memory, its bridge to registers.

    The registers are at the beginning of the lightweight bridge. The processor's own pins
    (Ethernet, card, serial port) are left out: U-Boot configures them.
    """
    lines = header(SYSTEM, board.family, board.device)
    lines += instance("clk_0", "clock_source", {
        "clockFrequency": round(board.core_mhz * 1e6), "clockFrequencyKnown": 1,
        "resetSynchronousEdges": "DEASSERT"})
    kinds = " ".join(kind.replace(" ", "\\ ") for _, kind in PORTS.values())
    lines += instance("hps_0", "altera_hps", {
        "F2S_Width": 0, "S2F_Width": 0, "LWH2F_Enable": "true", "F2SINTERRUPT_Enable": 1,
        "MPU_EVENTS_Enable": 0, "F2SDRAM_Type": f"{{{kinds}}}",
        "F2SDRAM_Width": f"{{{' '.join(str(width) for width, _ in PORTS.values())}}}",
        **board.memory})
    lines += _bridge("csr_0", 32, _REGISTER_BITS, 1)
    for name, (width, _) in PORTS.items():
        lines += _bridge(f"{name}_0", width, 32, BURST_WORDS)
    clocked = ["hps_0.h2f_lw_axi_clock", "csr_0.clk"]
    for k, name in enumerate(PORTS):
        clocked += [f"hps_0.f2h_sdram{k}_clock", f"{name}_0.clk"]
    lines += [f"add_connection clk_0.clk {name}" for name in clocked]
    lines += [f"add_connection clk_0.clk_reset {name}_0.reset" for name in ("csr", *PORTS)]
    lines += connect("hps_0.h2f_lw_axi_master", "csr_0.s0", 0)
    for k, name in enumerate(PORTS):
        lines += connect(f"{name}_0.m0", f"hps_0.f2h_sdram{k}_data", 0)
    lines.append("")
    for name, (kind, inner) in EXPORTS.items():
        lines += exported(name, kind, inner)
    return "\n".join([*lines, "", f"save_system {SYSTEM}.qsys", ""])


def _bridge(name, width, address_bits, burst):
    return instance(name, "altera_avalon_mm_bridge", {
        "DATA_WIDTH": width, "ADDRESS_WIDTH": address_bits, "ADDRESS_UNITS": "SYMBOLS",
        "MAX_BURST_SIZE": burst, "MAX_PENDING_RESPONSES": 64 if burst > 1 else 1,
        "LINEWRAPBURSTS": 0, "PIPELINE_COMMAND": 1, "PIPELINE_RESPONSE": 1})
