"""A board with a hard processor: its description, and its design."""

from collections.abc import Callable
from dataclasses import dataclass

from ncdc_boards.camera_board.design import requested_sensor
from ncdc_boards.hps_board.core import HpsDesign
from ncdc_boards.hps_board.ports import DATA_WIDTH
from ncdc_boards.hps_board.project import project_files
from ncdc_boards.quartus.project import USER_FILE
from ncdc_boards.quartus.sdc import check_sensor
from ncdc_hdl.system import System
from ncdc_hdl.video.modes import mode_holding
from ncdc_spec.errors import InputError
from ncdc_spec.frames import BGR8, output_format
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.system_values import memory_bytes
from ncdc_spec.sensors.framing import grid_row
from ncdc_spec.sensors.waking import wake_times

__all__ = ["HpsBoard"]

_READERS = 2            # by registers: programs on the processor


@dataclass(frozen=True)
class HpsBoard:
    """A board with a project by ``ncdc build``, whose frames are in the processor's memory.

    Parameters
    ----------
    name, title : str
        As given on the command line; the name for people.
    family, device : str
        As Quartus names them.
    platform : type
        Subclass of amaranth-boards' platform, with resources ``camera``, ``hdmi``, ``hps_ddr3``.
    core_mhz : float
        Clock of the core and of the ports to the memory.
    clock_plan : callable
        As in :class:`~ncdc_boards.camera_board.board.CameraBoard`.
    memory : dict
        Parameters of the processor in Platform Designer: its DDR3.
    frames : (int, int)
        Address and bytes of the memory that Linux leaves to the frames.
    multiplier_bits : int
        18 or 27: what a multiplier block of the device multiplies.
    sources : tuple of str
        Where pins and memory are published.
    """
    name: str
    title: str
    family: str
    device: str
    platform: type
    core_mhz: float
    clock_plan: Callable
    memory: dict
    frames: tuple
    multiplier_bits: int
    sources: tuple

    commands = "build",
    tools = "quartus"
    user_files = USER_FILE,

    @property
    def elsewhere(self):
        return (f"has its processor's memory: ncdc plan --memory hps --data-width {DATA_WIDTH} "
                f"plans for it, ncdc build --board {self.name} makes its project")

    def design(self, named, request, plan):
        """The :class:`~ncdc_boards.hps_board.core.HpsDesign` of a request, as in
        :meth:`~ncdc_boards.board.WholeBoard.design`."""
        if request.processor:
            raise InputError(f"the {self.name} has a processor of its own, --system is not for it")
        if request.colour:
            raise InputError(f"--colour is not supported on the {self.name}")
        check_sensor(request.settings)
        descriptor = named[0][1]
        mode = mode_holding(descriptor.geometry, request.mode)
        clocks = self.clock_plan(mode, self.core_mhz)
        sensor = requested_sensor(request, descriptor.geometry, self)
        hardware = plan(Hardware(data_width=DATA_WIDTH, format=BGR8.name,
                                 multiplier_bits=self.multiplier_bits), descriptor)
        system = System(descriptor, hardware, readers=_READERS, screens=1, grid=grid_row(*sensor))
        needed, there = memory_bytes(descriptor, system.hardware, system.stores), self.frames[1]
        if needed > there:
            raise InputError(f"the frames take {needed / 1e6:.1f} MB, {there / 1e6:.1f} MB of the "
                             f"{self.name} are reserved for them: a smaller picture fits")
        settings = sensor[0].settings
        reset_us, _ = wake_times(sensor[0].sensor.waking, settings.clock_hz)
        return HpsDesign(self, system, mode, output_format(system.hardware.format).pixel_bytes,
                         clocks, sensor, reset_us)

    def files(self, design, sources=()):
        """:func:`~ncdc_boards.hps_board.project.project_files`; ``sources``: none."""
        return project_files(design)

    def rates(self, design):
        """Frames of the sensor per second: the memory's rates depend on Linux."""
        return {"sensor_frames_per_second": design.sensor[0].timing.frames_per_second}
