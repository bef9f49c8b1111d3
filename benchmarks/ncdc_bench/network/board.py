"""A board's own memory and its gigabit line: how many frames per second go through both."""

from ncdc.cli.hardware import planned
from ncdc_bench.throughput.lenses import Lens, trained
from ncdc_boards.camera_board.design import hardware_for
from ncdc_model.planner.plan import Fixed
from ncdc_sim.board.network import CORE_MHZ, NetworkModel
from ncdc_sim.board.rates import SETTLE, corrected_rates, replayed_rates
from ncdc_spec.errors import InputError
from ncdc_spec.interpolation import DEFAULT

__all__ = ["CORE_MHZ", "FULL", "board_rows", "shortfalls"]

FULL = (1280, 1024)
_GOALS = {"corrected": 28, "raw, from memory": 90}      # frames per second of that size
_VIEW = 105             # degrees of the lens
_SENSOR_FPS = 30        # of that size; smaller pictures come as often as the exposure allows
_FRAMES = 5             # of which time is taken
_MTU = 1500


def board_rows(board, size, step, core_mhz=CORE_MHZ, screen=False):
    """Rows for pictures of that size, (width, height), on a board with Ethernet at RGMII.

    Parameters
    ----------
    board : Board
    size : (int, int)
    step : callable
        ``step(text)`` is called with the name of each measurement.
    core_mhz : number
        Clock of the board's core and its SDRAM.
    screen : bool
        Whether to let a screen show the pictures in one more run.

    Returns
    -------
    list of dict
        Those of :func:`ncdc_bench.network.measure.rows_of`, and more; None if absent.
        ``frames_per_second``, ``slowest_per_second``: by the line's clock, from last byte to last
        byte, of all frames and of the two furthest apart. ``sensor_per_second``. ``dropped``: raw
        frames without a sent picture. ``lost``: frames that camera, corrector or a reader lost.
        ``screen_underruns``. ``memory_percent``: share of the clocks in which the SDRAM moves
        data. ``clocks_per_pixel``.

    Raises
    ------
    InputError
        If the board has no such Ethernet, or no screen.
    """
    if getattr(board, "ethernet", None) is None:
        raise InputError(f"the board {board.name} has no Ethernet chip at RGMII: the de2-115 has "
                         "one")
    if not board.screen:
        raise InputError(f"the board {board.name} has no screen, the bench's has one: the de2-115")
    step("a lens")
    lens = trained(Lens(_VIEW, size, interpolation=DEFAULT.name))
    step("compiling")
    hardware, _ = planned(hardware_for(board), Fixed(None, None, None), lens)
    model = NetworkModel(board, lens, _SENSOR_FPS if size == FULL else 0, hardware=hardware,
                         core_mhz=core_mhz)
    sensor = model.setup.timing.frames_per_second
    step("corrected pictures")
    rows = [_row(model, "corrected", corrected_rates(model, SETTLE + _FRAMES), sensor)]
    if screen:
        step("with a screen")
        rates = corrected_rates(model, SETTLE + _FRAMES, screen=True)
        rows.append(_row(model, f"corrected, a screen at {_refresh(model.design):.1f} Hz", rates,
                         sensor))
    step("raw pictures from memory")
    rows.append(_row(model, "raw, from memory", replayed_rates(model, 1 + _FRAMES)))
    step("done")
    return rows


def _refresh(design):
    """Frames per second of a design's screen."""
    mode = design.mode
    return 1e6 * design.clocks.pixel_mhz / (sum(mode.horizontal) * sum(mode.vertical))


def _row(model, what, rates, sensor=None):
    """A row on what a run has shown; ``sensor``: its frames per second, None if it is off."""
    steady, design = rates.steady, model.design
    width, height = model.descriptor.geometry.corrected
    return {
        "what": what, "peer": "golden model", "mtu": _MTU, "width": width, "height": height,
        "link": f"RGMII, 1000 Mbit/s, {design.board.name} at {design.core_hz / 1e6:g} MHz",
        "format": rates.format, "frames": steady.frames,
        "pixels_different": steady.pixels_different,
        "megabytes_per_second": round(steady.megabytes_per_second, 2),
        "underruns": rates.underruns, "clocks_per_command": None, "most_clocks_per_command": None,
        "resent": None, "frames_per_second": round(steady.frames_per_second, 2),
        "slowest_per_second": round(steady.slowest, 2),
        "sensor_per_second": sensor and round(sensor, 2),
        "dropped": rates.dropped if sensor else None, "lost": rates.lost,
        "screen_underruns": rates.screen_underruns,
        "memory_percent": round(100 * rates.memory_share, 1),
        "clocks_per_pixel": sensor and round(rates.corrector_clocks / (width * height), 3)}


def shortfalls(rows):
    """Sentences on frames lost and on rates below the goals in ``rows``."""
    found = []
    for row in rows:
        name, goal = row["what"], _GOALS.get(row["what"])
        if row["lost"]:
            found.append(f"{name}: {row['lost']} frames were lost")
        if goal and (row["width"], row["height"]) == FULL and row["frames_per_second"] < goal:
            found.append(f"{name}: {row['frames_per_second']} frames per second, goal {goal}")
    return found
