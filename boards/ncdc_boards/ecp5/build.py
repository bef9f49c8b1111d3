"""The files of a design for an ECP5, for synthesis and simulation."""

from ncdc_boards.board import project_name

__all__ = ["clock_cells", "clock_targets", "prepared"]

_ENDS = {"il": "il", "debug.v": "v", "lpf": "lpf"}


def prepared(design):
    """Text of ``ncdc_<board>.il``, ``.v`` and ``.lpf`` of a
    :class:`~ncdc_boards.camera_board.core.Design`, by name."""
    board = design.board
    name = project_name(board)
    plan = board.platform().prepare(board.top(design), name, debug_verilog=True)
    texts = {f"{name}.{end}": plan.files[f"{name}.{kind}"] for kind, end in _ENDS.items()}
    return {file: text.decode() if isinstance(text, bytes) else text
            for file, text in texts.items()}


def clock_targets(design):
    """MHz of each clock that place and route has to reach, by its name: those of the board, and the
    camera's pixel clock with the design's setup."""
    setup, _ = design.sensor
    camera = {"sensor": setup.timing.pixel_clock_hz / 1e6}
    return design.clocks.targets() | ({} if design.pattern or design.link else camera)


def clock_cells(design):
    """(Cell of the device, output) that drives each clock, by the clock's name."""
    lanes = {} if not design.link else {"sensor": ("csi2_phy.byte_clock", "CLKO"),
                                        "csi_word": ("csi2_phy.word_clock", "CDIVX")}
    gates = {domain: (f"clocks.{domain}_gate", "CLKO") for domain in design.clocks.targets()
             if domain not in lanes} | lanes
    inputs = ({} if design.pattern or design.link else {"sensor": "camera_0__pixclk"}) | (
        {"ethernet_received": "eth_rgmii_0__rx_clk"} if design.processor else {})
    return gates | {name: (f"{port}__io_buffer.buf.buf0", "O") for name, port in inputs.items()}
