"""The files of a design for an ECP5, for synthesis and simulation."""

from dataclasses import dataclass

__all__ = ["Files", "clock_cells", "prepared", "project_name"]


@dataclass(frozen=True)
class Files:
    """Text of the top and of all below it in Yosys's own language and as Verilog, of its
    constraints (Lattice's preferences)."""
    rtlil: str
    verilog: str
    preferences: str


def project_name(board):
    """Name of the files and of the top."""
    return "ncdc_" + board.name.replace("-", "_")


def prepared(design):
    """The :class:`Files` of a :class:`~ncdc_boards.camera_board.core.Design`."""
    board = design.board
    name = project_name(board)
    plan = board.platform().prepare(board.top(design), name, debug_verilog=True)
    texts = {kind: plan.files[f"{name}.{kind}"] for kind in ("il", "debug.v", "lpf")}
    return Files(*(text.decode() if isinstance(text, bytes) else text for text in texts.values()))


def clock_cells(design):
    """(Cell of the device, output) that drives each clock, by the clock's name."""
    gates = {domain: (f"clocks.{domain}_gate", "CLKO") for domain in design.clocks.targets()}
    inputs = ({} if design.pattern else {"sensor": "camera_0__pixclk"}) | (
        {"ethernet_received": "eth_rgmii_0__rx_clk"} if design.processor else {})
    return gates | {name: (f"{port}__io_buffer.buf.buf0", "O") for name, port in inputs.items()}
