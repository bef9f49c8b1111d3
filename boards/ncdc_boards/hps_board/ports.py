"""The ports between the FPGA's logic and the processor, by the names of Platform Designer."""

__all__ = ["AGENT", "BURST_BITS", "BURST_WORDS", "DATA_WIDTH", "HOST", "MEMORY_PINS", "PORTS",
           "SCREEN_WIDTH", "SYSTEM"]

SYSTEM = "ncdc_qsys"
DATA_WIDTH, SCREEN_WIDTH = 64, 32       # bits, of the corrector's ports and of the screen's
BURST_WORDS = 32                        # of the longest burst, the screen's
BURST_BITS = BURST_WORDS.bit_length()   # of a count of them
PORTS = {"read0": (DATA_WIDTH, "Avalon-MM Read-Only"),
         "write": (DATA_WIDTH, "Avalon-MM Write-Only"),
         "screen": (SCREEN_WIDTH, "Avalon-MM Read-Only")}
"""Ports to the memory: bits, and what the processor's settings call them; in its order."""

AGENT = {"address": "i", "read": "i", "write": "i", "burstcount": "i", "writedata": "i",
         "byteenable": "i", "debugaccess": "i", "waitrequest": "o", "readdata": "o",
         "readdatavalid": "o"}
"""Signals of altera_avalon_mm_bridge's agent, and their direction."""
HOST = {name: "io"[way == "i"] for name, way in AGENT.items()}
"""Those of its host."""
MEMORY_PINS = {"a": 15, "ba": 3, "ck": 1, "ck_n": 1, "cke": 1, "cs_n": 1, "ras_n": 1, "cas_n": 1,
               "we_n": 1, "reset_n": 1, "odt": 1, "dm": 4, "dq": 32, "dqs": 4, "dqs_n": 4}
"""Signals of the processor's memory, and their width; `oct_rzqin`, a resistor, is beside them."""
