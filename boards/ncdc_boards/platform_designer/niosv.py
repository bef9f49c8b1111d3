"""The paper's whole system with a Nios V, as a script for ``qsys-script``."""

from ncdc_boards.platform_designer.script import connect, exported, header, instance
from ncdc_hdl.export.ip.platform_designer import interfaces
from ncdc_hdl.export.verilog.system_cover import SYSTEM as CAMERA
from ncdc_hdl.link.top import PACKETISER

__all__ = ["BASES", "NIOSV", "niosv_tcl"]

NIOSV = "ncdc_niosv"
BASES = {
    "ram_0.s1": 0x0000_0000, "cpu_0.dm_agent": 0x0010_0000, "cpu_0.timer_sw_agent": 0x0011_0000,
    "uart_0.avalon_jtag_slave": 0x0011_0100, "mac_0.control_port": 0x0012_0000,
    "receive_0.csr": 0x0012_0400, "receive_0.descriptor_slave": 0x0012_0420,
    "receive_0.response": 0x0012_0440, "send_0.csr": 0x0012_0460,
    "send_0.descriptor_slave": 0x0012_0480, "packets_0.csr": 0x0013_0000,
    "ncdc_0.csr": 0x0014_0000, "memory_0.s0": 0x4000_0000}
"""Byte addresses, in the processor's map; other hosts of the memory see it at 0."""
_CODE = "ram_0.s1", "cpu_0.dm_agent", "memory_0.s0"       # the processor fetches from these
_INTERRUPTS = "ncdc_0.irq", "packets_0.irq", "receive_0.csr_irq", "send_0.csr_irq", "uart_0.irq"

_FAMILY, _DEVICE = "Cyclone V", "5CSEBA6U23I7"
_CLOCK_HZ = 100_000_000
_RAM_BYTES = 128 << 10
_WORD = 32                  # bits of the streams between DMA, packetiser and MAC
_DMA = {"DATA_WIDTH": _WORD, "DATA_FIFO_DEPTH": 256, "DESCRIPTOR_FIFO_DEPTH": 32, "MAX_BYTE": 2048,
        "TRANSFER_TYPE": "{Unaligned Accesses}", "BURST_ENABLE": 1, "MAX_BURST_COUNT": 16,
        "ENHANCED_FEATURES": 1, "PACKET_ENABLE": 1, "ERROR_ENABLE": 1}
_STREAM = {"bitsPerSymbol": 8, "symbolsPerBeat": _WORD // 8, "usePackets": 1,
           "packetScheduling": 1, "numInputInterfaces": 2, "outChannelWidth": 1, "errorWidth": 0}
_PARTS = {
    "clk_0": ("clock_source", {"clockFrequency": _CLOCK_HZ, "clockFrequencyKnown": 1,
                               "resetSynchronousEdges": "DEASSERT"}),
    "cpu_0": ("intel_niosv_m", {"enableAvalonInterface": "true", "resetSlave": "Absolute",
                                "resetOffset": "0x00000000"}),
    "ram_0": ("altera_avalon_onchip_memory2", {"memorySize": _RAM_BYTES, "dataWidth": 32}),
    "uart_0": ("altera_avalon_jtag_uart", {}),
    "ncdc_0": (CAMERA, {}),
    "packets_0": (PACKETISER, {}),
    "mac_0": ("altera_eth_tse", {"core_variation": "MAC_ONLY", "ifGMII": "RGMII", "useMDIO": 1}),
    "send_0": ("altera_msgdma", _DMA | {"MODE": 1, "ERROR_WIDTH": 1}),
    "receive_0": ("altera_msgdma", _DMA | {"MODE": 2, "ERROR_WIDTH": 6, "RESPONSE_PORT": 0}),
    # The packet that the MAC sends next: the processor's, or one of a picture.
    "merge_0": ("multiplexer", _STREAM),
    "strip_0": ("altera_avalon_st_channel_stripper", {"SYMBOL_WIDTH": 8, "DATA_WIDTH": _WORD}),
}
# Clocks and resets of each instance.
_CLOCKED = {
    "cpu_0": ("clk", "reset"), "ram_0": ("clk1", "reset1"), "uart_0": ("clk", "reset"),
    "ncdc_0": ("clock", "reset"), "packets_0": ("clock", "reset"),
    "send_0": ("clock", "reset_n"), "receive_0": ("clock", "reset_n"),
    "merge_0": ("clk", "reset"), "strip_0": ("clk", "reset"), "memory_0": ("clk", "reset"),
    "mac_0": ("control_port_clock_connection", "reset_connection")}
_STREAMS = (("send_0.st_source", "merge_0.in0"), ("packets_0.stream", "merge_0.in1"),
            ("merge_0.out", "strip_0.in"), ("strip_0.out", "mac_0.transmit"),
            ("mac_0.receive", "receive_0.st_sink"))
_MAC_PINS = ("mac_rgmii_connection", "mac_mdio_connection", "mac_status_connection",
             "mac_misc_connection")


def niosv_tcl(data_width, system, packetiser):
    """Text of ``ncdc_niosv.tcl``: Nios V/m, camera system, packetiser, Altera's MAC with two DMAs.

    The memory is an Avalon agent of the user, reached through an exported bridge of ``data_width``
    bits. The sensor's pins, the I2C bus, and RGMII are exported. The device is that of a DE10-Nano.
    """
    lines = header(NIOSV, _FAMILY, _DEVICE, " --search-path=.,$")
    for name, (kind, parameters) in _PARTS.items():
        lines += instance(name, kind, parameters)
    lines += instance("memory_0", "altera_avalon_mm_bridge", {
        "DATA_WIDTH": data_width, "ADDRESS_WIDTH": 28, "ADDRESS_UNITS": "SYMBOLS",
        "MAX_BURST_SIZE": 64, "MAX_PENDING_RESPONSES": 64, "LINEWRAPBURSTS": 0,
        "PIPELINE_COMMAND": 1, "PIPELINE_RESPONSE": 1})
    ports = {"ncdc_0": interfaces(system), "packets_0": interfaces(packetiser)}
    for name, (clock, reset) in _CLOCKED.items():
        lines += [f"add_connection clk_0.clk {name}.{clock}",
                  f"add_connection clk_0.clk_reset {name}.{reset}"]
    lines += [f"add_connection clk_0.clk mac_0.{side}_clock_connection"
              for side in ("transmit", "receive")]
    lines += [f"add_connection clk_0.clk_reset {name}.memory_reset" for name in ports]
    lines += [f"add_connection {source} {sink}" for source, sink in _STREAMS]
    for agent, base in BASES.items():
        lines += connect("cpu_0.data_manager", agent, base)
    for agent in _CODE:
        lines += connect("cpu_0.instruction_manager", agent, BASES[agent])
    hosts = [f"{part}.{name}" for part, found in ports.items()
             for name, (kind, direction, _) in found.items()
             if (kind, direction) == ("avalon", "start")]
    for host in (*hosts, "send_0.mm_read", "receive_0.mm_write"):
        lines += connect(host, "memory_0.s0", 0)
    for number, sender in enumerate(_INTERRUPTS):
        lines += [f"add_connection cpu_0.platform_irq_rx {sender}",
                  f"set_connection_parameter_value cpu_0.platform_irq_rx/{sender} irqNumber "
                  f"{number}"]
    lines.append("")
    lines += exported("clk", "clock sink", "clk_0.clk_in")
    lines += exported("reset", "reset sink", "clk_0.clk_in_reset")
    lines += exported("memory", "avalon master", "memory_0.m0")
    for name, (kind, direction, _) in ports["ncdc_0"].items():
        if kind == "conduit":
            lines += exported(name, f"{kind} {direction}", f"ncdc_0.{name}")
    for side in ("tx", "rx"):
        lines += exported(f"mac_{side}_clock", "clock sink",
                          f"mac_0.pcs_mac_{side}_clock_connection")
    for name in _MAC_PINS:
        lines += exported(name, "conduit end", f"mac_0.{name}")
    return "\n".join([*lines, "", f"save_system {NIOSV}.qsys", ""])
