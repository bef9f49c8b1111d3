"""The ports between the FPGA's logic and the processor, named as in Platform Designer."""

__all__ = ["AGENT", "BURST_BITS", "BURST_WORDS", "DATA_WIDTH", "HOST", "MEMORY_PINS", "PORTS",
           "PORT_RESETS", "PORT_RESETS_ALL", "SCREEN_WIDTH", "SYSTEM", "port_resets"]

SYSTEM = "ncdc_qsys"
DATA_WIDTH, SCREEN_WIDTH = 64, 32       # bits, of the corrector's ports and of the screen's
BURST_WORDS = 32                        # longest burst, the screen's
BURST_BITS = BURST_WORDS.bit_length()   # bits of their number
PORTS = {"read0": (DATA_WIDTH, "Avalon-MM Read-Only"),
         "write": (DATA_WIDTH, "Avalon-MM Write-Only"),
         "screen": (SCREEN_WIDTH, "Avalon-MM Read-Only")}
"""Ports to the memory in the processor's order: bits, and their names in its settings."""

PORT_RESETS = 0xFFC2_5080
"""Address of FPGAPORTRST in the memory controller: a 0 holds the port in reset.
Intel, Cyclone V Hard Processor System Technical Reference Manual (683126), SDRAM controller."""
PORT_RESETS_ALL = 0x3FFF
"""Value with which no port is in reset."""
# Lowest bits of FPGAPORTRST: 4 read queues, 4 write queues, 6 command ports. Linux,
# drivers/fpga/altera-fpga2sdram.c, has the same three numbers.
_READ_QUEUES, _WRITE_QUEUES, _COMMANDS = 0, 4, 8

AGENT = {"address": "i", "read": "i", "write": "i", "burstcount": "i", "writedata": "i",
         "byteenable": "i", "debugaccess": "i", "waitrequest": "o", "readdata": "o",
         "readdatavalid": "o"}
"""Signals of altera_avalon_mm_bridge's agent, and their direction."""
HOST = {name: "io"[way == "i"] for name, way in AGENT.items()}
"""Signals of its host, and their direction."""
MEMORY_PINS = {"a": 15, "ba": 3, "ck": 1, "ck_n": 1, "cke": 1, "cs_n": 1, "ras_n": 1, "cas_n": 1,
               "we_n": 1, "reset_n": 1, "odt": 1, "dm": 4, "dq": 32, "dqs": 4, "dqs_n": 4}
"""Signals of the processor's memory, and their width, without the resistor `oct_rzqin`."""


def port_resets(ports=None):
    """{name of a port: its bits of FPGAPORTRST}.

    Each port has a command port of its own. A port that reads gets the next read queue of 64 bits,
    one that writes the next write queue. Platform Designer assigns both in the order of the ports
    (inferred, not checked with Quartus).

    Parameters
    ----------
    ports : dict, optional
        By default :data:`PORTS`; none is wider than 64 bits.
    """
    found, reads, writes = {}, 0, 0
    for command, (name, (_, kind)) in enumerate((PORTS if ports is None else ports).items()):
        bits = 1 << _COMMANDS + command
        if "Write-Only" not in kind:
            bits |= 1 << _READ_QUEUES + reads
            reads += 1
        if "Read-Only" not in kind:
            bits |= 1 << _WRITE_QUEUES + writes
            writes += 1
        found[name] = bits
    return found
