"""From descriptors and a sensor to the design of a board."""

from dataclasses import replace

from ncdc_boards.camera_board.budget import screen_burst
from ncdc_boards.camera_board.core import Design
from ncdc_boards.camera_board.programs import I2C_HZ, configuration_program, lens_program
from ncdc_boards.camera_board.waking import Times
from ncdc_hdl.export.drivers.lenses import check_lens
from ncdc_hdl.link.processor import READERS
from ncdc_hdl.system import System
from ncdc_model.raw_lens import raw_lens
from ncdc_spec.cache_options import TILE_MEMORIES
from ncdc_spec.camera_port import CSI2, CameraPort
from ncdc_spec.errors import InputError
from ncdc_spec.frames import BGR8, output_format
from ncdc_spec.hardware import Hardware
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.field import FULL
from ncdc_spec.sensors.framing import grid_row, setup_around
from ncdc_spec.sensors.sensor import Settings
from ncdc_spec.sensors.waking import wake_times

__all__ = ["READER_OF_HOST", "SENSOR_CLOCK_HZ", "design_of", "hardware_for",
           "requested_sensor", "sensor_for", "times_for"]

_DATA_WIDTH = 32        # of the memory ports
SENSOR_CLOCK_HZ = 25_000_000
"""Clock that the boards give to a sensor."""
_CSI_RATE = 24          # frames a second: more would leave the memory no time to correct them
READER_OF_HOST = 0      # for a host at the serial port; the processor's readers come after it


def hardware_for(board, lanes=1, colour=False):
    """The :class:`Hardware` that suits a board, before configuration; ``lanes`` pixels a clock,
    with gains, tone curve and sums if ``colour``."""
    return Hardware(data_width=_DATA_WIDTH, format=BGR8.name, lanes=lanes,
                    multiplier_bits=board.multiplier_bits, colour=colour,
                    tile_memory=board.tile_memory if lanes == 1 else TILE_MEMORIES[0])


def sensor_for(name, geometry, *, pixel_clock_hz=0, **settings):
    """:func:`~ncdc_spec.sensors.framing.setup_around` with the boards' clock to the sensor, which
    is by default also the pixel clock; modules with CSI-2 have their own. ``settings``: ``field``,
    and those of the sensor."""
    if sensor_named(name).lanes:
        return setup_around(name, geometry, pixel_clock_hz=pixel_clock_hz, **settings)
    return setup_around(name, geometry, clock_hz=SENSOR_CLOCK_HZ,
                        pixel_clock_hz=pixel_clock_hz or SENSOR_CLOCK_HZ, **settings)


def requested_sensor(request, geometry, board):
    """:func:`sensor_for` of a :class:`~ncdc_boards.board.Request`, by default with the largest
    field that fits, and with lanes that the board can take.

    Raises
    ------
    InputError
        If the board has no pins for the sensor; as of :func:`sensor_for`.
    """
    sensor, settings = sensor_named(request.sensor), {"field": FULL} | dict(request.settings)
    if sensor.lanes:
        most = getattr(board, "csi_lane_hz", 0)
        if not most:
            raise InputError(f"the sensor {sensor.name} has CSI-2 lanes, the {board.name} takes "
                             "parallel sensors: the ulx3s and the colorlight-i9 take both")
        usual = setup(sensor, Settings()).link.lane_hz
        settings |= {"lane_hz": most} if usual > most else {}
        if settings.get("exposure_us", Settings.exposure_us) < .9e6 / _CSI_RATE:
            settings["frames_per_second"] = _CSI_RATE
    return sensor_for(request.sensor, geometry, **settings)


def design_of(board, named, sensor, mode, *, hardware=None, core_mhz=None, processor=False,
              **more):
    """The :class:`Design` that shows the first lens, and the others by push button.
    Without a screen it has one lens, which clients of the network change.

    Parameters
    ----------
    board : CameraBoard
    named : sequence of (path, Descriptor)
    sensor : (Setup, Crop)
        As in :func:`sensor_for`.
    mode : VideoMode or None
        None if the board has no screen.
    hardware : Hardware, optional
        By default that of :func:`hardware_for`.
    core_mhz : number, optional
        By default the board's.
    processor : bool
        With a processor and Ethernet.
    more :
        Other fields of :class:`Design`; ``waits`` of :func:`configuration_program`.

    Raises
    ------
    InputError
        If the board has no block RAM for the lens's interpolation; if another lens does not fit
        the first one's corrector, or shows another size. If the board has no
        Ethernet for a processor, or no screen and more than a lens. If rows of frames are no whole
        words of a memory that writes whole words only.
    """
    if processor and not board.ethernet:
        raise InputError(f"the board {board.name} has no Ethernet chip, which --system needs: "
                         "the de2-115 and the colorlight-i9 have one")
    if mode is None and len(named) > 1:
        raise InputError(f"{len(named)} descriptors are given, the board {board.name} has no "
                         "buttons to choose one: 1 fits, others are loaded over the network")
    descriptor = named[0][1]
    hardware = hardware or hardware_for(board)
    interpolation = descriptor.geometry.interpolation.name
    if interpolation not in board.interpolations:
        raise InputError(f"the interpolation is {interpolation}, the device of "
                         f"{board.name} has space for {' and '.join(board.interpolations)}: "
                         f"ncdc train --interpolation {board.interpolations[-1]}")
    _check_rows(board, descriptor.geometry, hardware)
    core_mhz, waits = core_mhz or board.core_mhz, more.pop("waits", True)
    i2c_hz = more.pop("i2c_hz", I2C_HZ)
    clocks = board.clock_plan(mode, core_mhz)
    if processor:
        clocks = replace(clocks, ethernet=True)
    link, camera = sensor[0].link, CameraPort()
    if link:
        clocks = replace(clocks, lane_mhz=link.lane_hz / 1e6)
        camera = CameraPort(CSI2, link.lanes, aligned=False, serial=sensor[1].grid)
    system = System(descriptor, hardware, readers=1 + processor * READERS,
                    screens=int(mode is not None), grid=grid_row(*sensor), camera=camera)
    for path, other in named[1:]:
        check_lens(system.corrector, path, other)
        for what in ("corrected", "distorted"):
            sizes = [getattr(one.geometry, what) for one in (descriptor, other)]
            if sizes[0] != sizes[1]:
                raise InputError(f"{path}: the {what} picture has {sizes[1][0]}x{sizes[1][1]} "
                                 f"pixels, that of {named[0][0]} {sizes[0][0]}x{sizes[0][1]}")
    lenses = [one for _, one in named] + [raw_lens(descriptor)] if mode else []
    programs = [configuration_program(system, *sensor, round(core_mhz * 1e6), waits, i2c_hz),
                *(lens_program(system, lens) for lens in lenses)]
    pixel_bytes = output_format(hardware.format).pixel_bytes
    design = Design(board, system, mode, pixel_bytes, clocks, sensor, tuple(programs), len(named),
                    screen_burst(board, mode, clocks, hardware,
                                 descriptor.geometry.corrected_width, processor) if mode else 0,
                    times_for(sensor[0]), processor=processor)
    return replace(design, **more)


def times_for(setup):
    """The :class:`Times` for a sensor's :class:`Setup`: those of its data with a margin.

    The watch is a second, or four frames if those are longer.
    """
    reset, rest = wake_times(setup.sensor.waking, setup.settings.clock_hz)
    return Times(reset, rest, max(1_000_000, round(4e6 / setup.timing.frames_per_second)))


def _check_rows(board, geometry, hardware):
    """:class:`InputError` if a row ends within a word, and the memory cannot write parts of one."""
    word = hardware.data_width // 8
    pixel = output_format(hardware.format).pixel_bytes
    for what, width, size in (("corrected", geometry.corrected_width, pixel),
                              ("distorted", geometry.distorted_width, 1)):
        if not board.byte_masks and width * size % word:
            raise InputError(
                f"a row of the {what} picture has {width * size} bytes, and the memory of "
                f"{board.name} writes {word} at once: {width - width % word} or "
                f"{width + word - width % word} pixels fit")
