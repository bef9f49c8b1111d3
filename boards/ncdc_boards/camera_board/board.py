"""A board with a camera and an SDRAM of its own: its description, and its design."""

from collections.abc import Callable
from dataclasses import dataclass

from ncdc_boards.camera_board.budget import budget_of, check_lanes, check_memory
from ncdc_boards.camera_board.design import (
    SENSOR_CLOCK_HZ,
    design_of,
    hardware_for,
    requested_sensor,
)
from ncdc_boards.camera_board.pattern import (
    PATTERN,
    PatternSensor,
    check_pattern,
    pattern_sensor,
)
from ncdc_boards.sdram.chips import SdramChip
from ncdc_hdl.video.modes import mode_holding
from ncdc_model.example.card import card_codes
from ncdc_spec.cache_options import TILE_MEMORIES
from ncdc_spec.errors import InputError
from ncdc_spec.interpolation import INTERPOLATIONS

__all__ = ["CameraBoard", "EthernetChip"]


@dataclass(frozen=True)
class EthernetChip:
    """An Ethernet chip with RGMII at the device's pins.

    Parameters
    ----------
    addresses : range
        Addresses of its management registers (MDIO) at which the firmware looks for it.
    delays : bool
        The chip delays the clock that the device sends with the data; else the device does.
    """
    addresses: range
    delays: bool


@dataclass(frozen=True)
class CameraBoard:
    """What :class:`~ncdc_boards.board.PlannedBoard` needs but files, which depend on tools.

    Parameters
    ----------
    name, title : str
        As given on the command line; the name for people.
    device : str
        As its tools name it.
    platform : type
        Subclass of amaranth-boards' platform, with a resource ``camera``.
    chip : SdramChip
    memory_bytes : int
        Bytes of the SDRAM that the device reaches.
    core_mhz : float
        Clock of the core and of the SDRAM.
    clock_plan : callable
        From a video mode and ``core_mhz`` to the board's clocks, with ``core_mhz`` and
        ``pixel_mhz``; raises InputError if it has no such pixel clock.
    top : callable
        From a :class:`~ncdc_boards.camera_board.core.Design` to the Elaboratable.
    baud : int
        Bits per second of the serial port.
    multiplier_bits : int
        18 or 27: what a multiplier block of the device multiplies.
    sources : tuple of str
        Where the pins are published.
    jtag : bool
        The registers are also reached through the JTAG chain that configures the device.
    ethernet : EthernetChip or None
        What ``ncdc build --system`` uses; None: there is none.
    screen : bool
        It has a connector for a monitor; else it always has a processor, and needs ``ethernet``.
    byte_masks : bool
        The device reaches the SDRAM's DQM; else whole words are written.
    interpolations : tuple of str
        Those for which it has space.
    tile_memory : str
        Of designs of one pixel per clock, as in :class:`~ncdc_spec.hardware.Hardware`.
    pattern_bits : int
        Bits of block RAM for a test pattern instead of a sensor; 0: it is not supported.
    csi_lane_hz : int
        Most bits per second of a lane of a sensor with CSI-2; 0: it is not supported.
    """
    name: str
    title: str
    device: str
    platform: type
    chip: SdramChip
    memory_bytes: int
    core_mhz: float
    clock_plan: Callable
    top: Callable
    baud: int
    multiplier_bits: int
    sources: tuple
    jtag: bool = False
    ethernet: EthernetChip | None = None
    screen: bool = True
    byte_masks: bool = True
    interpolations: tuple = tuple(INTERPOLATIONS)
    tile_memory: str = TILE_MEMORIES[0]
    pattern_bits: int = 0
    csi_lane_hz: int = 0

    commands = "build", "plan"
    user_files = ()

    @property
    def elsewhere(self):
        return ("has a whole design, with camera and screen: ncdc build --board "
                f"{self.name} makes it")

    def design(self, named, request, plan):
        """The :class:`~ncdc_boards.camera_board.core.Design` of a request, as in
        :meth:`~ncdc_boards.board.WholeBoard.design`."""
        descriptor = named[0][1]
        mode = self._mode(descriptor.geometry, request.mode)
        # The clocks first: they are checked at once, and planning takes seconds.
        self.clock_plan(mode, self.core_mhz)
        sensor, pattern = self._sensor(descriptor, request)
        check_lanes(self, hardware_for(self), request.lanes)
        hardware = plan(hardware_for(self, request.lanes, request.colour), descriptor)
        design = design_of(self, named, sensor, mode, hardware=hardware, pattern=pattern,
                           processor=request.processor or not self.screen)
        check_memory(design, sensor[0])
        return design

    def _mode(self, geometry, name):
        """The video mode of a design; None if the board has no screen."""
        if self.screen:
            return mode_holding(geometry, name)
        if name:
            raise InputError(f"the mode {name} is asked for, the board {self.name} has no screen")
        return None

    def _sensor(self, descriptor, request):
        """The sensor's setup and crop; the pattern that stands for it, or None."""
        if request.sensor != PATTERN:
            return requested_sensor(request, descriptor.geometry, self), None
        check_pattern(self, descriptor.geometry)
        if request.settings:
            raise InputError(f"{' and '.join(request.settings)} of the sensor {PATTERN} cannot be "
                             "set: it has no registers")
        sensor = pattern_sensor(descriptor.geometry, SENSOR_CLOCK_HZ)
        return sensor, PatternSensor(card_codes(descriptor), sensor[0].timing)

    def budget(self, design):
        """The :class:`~ncdc_boards.camera_board.budget.Budget` of a design."""
        return budget_of(design, design.sensor[0])

    def rates(self, design):
        """Rates per second: bytes of memory and screen, frames of the sensor, corrected ones."""
        budget = self.budget(design)
        return {"memory_mb_per_second": budget.carried / 1e6,
                "screen_mb_per_second": budget.screen / 1e6,
                "sensor_frames_per_second": budget.frames_per_second,
                "corrected_frames_per_second": budget.corrected_per_second}
