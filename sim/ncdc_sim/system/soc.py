"""The system on a chip under Verilator, on a network interface of its own."""

import tempfile
import time
from dataclasses import replace
from pathlib import Path

from ncdc_model.correction import correct
from ncdc_sim.link.namespaces import TAP, TapNetwork
from ncdc_sim.runner import HDL, build, command_of, hdl_text
from ncdc_sim.sensor.photo import still_raw
from ncdc_sim.sensor.reference import raw_frames
from ncdc_sim.sensor.verilog import sensor_sources
from ncdc_sim.tools import SimulationError
from ncdc_soc.core import SocCore, core_verilog
from ncdc_soc.firmware import Identity, config, firmware_image
from ncdc_soc.soc import soc_verilog
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from ncdc_spec.raw_gains import NO_RAW_GAINS, frame_gains
from ncdc_spec.sensors.catalogue import controlled_sensor
from ncdc_spec.sensors.framing import camera_of, grid_row, setup_around
from ncdc_spec.sensors.level import levelled

__all__ = ["ADDRESS", "HARDWARE", "SocModel", "SocRun", "check_eeprom"]

ADDRESS = Identity().ip
HARDWARE = Hardware(bus="axi", format="BGR8")
# The sensor's times are so many times shorter, and its bus faster.
_TIME_SCALE = 1000
_QUEUE_BYTES = 18 * 1024        # of the packetiser: two packets of an MTU of 9000
_STARTED = "eeprom: "           # what the firmware says when nothing keeps it from answering
_TIMEOUT_S = 120
_EEPROM_BYTES = 8192            # as soc_bench.v has it
_EEPROM_FILE = "eeprom.bin"


def check_eeprom(content):
    """Reject a ``content`` that the EEPROM of the simulation is too small for.

    Raises
    ------
    InputError
        If it is larger.
    """
    if len(content) > _EEPROM_BYTES:
        raise InputError(f"the image has {len(content)} bytes, the EEPROM of the simulation has "
                         f"{_EEPROM_BYTES}")


class SocModel:
    """A system for one camera, compiled: its program, its firmware, what its sensor sees.

    Parameters
    ----------
    descriptor : Descriptor
    raw : ndarray of uint8, shape (distorted height, distorted width)
        Frame of the sensor with the exposure that the firmware sets first.
    exposure_us : float
        That exposure.
    hardware : Hardware, optional
    identity : Identity
        Identity of the device on its network.
    field : str, optional
        As of :func:`~ncdc_spec.sensors.framing.setup_around`.
    sensor : str
        Its name.

    Attributes
    ----------
    program : Path
    code_bytes, ram_bytes : int
        Sizes of the firmware.
    setup : Setup
        Configuration of the sensor.
    """

    def __init__(self, descriptor, raw, exposure_us=100.0, hardware=HARDWARE, identity=Identity(),
                 field=None, sensor="mt9p031"):
        self.descriptor, self.identity = descriptor, identity
        self._field, self._sensor = field, controlled_sensor(sensor).name
        self.setup, self._crop = self._set_up(exposure_us)
        core = SocCore(descriptor, hardware, capacity=_QUEUE_BYTES,
                       grid=grid_row(self.setup, self._crop),
                       camera=camera_of(self.setup, self._crop))
        soc = soc_verilog(core)
        self._light = replace(still_raw(self.setup, self._crop, raw),
                              nominal=self.setup.exposure_clocks)
        with tempfile.TemporaryDirectory(prefix="ncdc-") as folder:
            self._rom, self.code_bytes, self.ram_bytes = firmware_image(
                config(core.system, core.packetiser.capacity, soc, self.setup, self._crop,
                       self.identity, sets_up=_TIME_SCALE), soc, folder)
        self.program = _build(core_verilog(core), soc, self.setup)

    def fill(self, folder, eeprom=None):
        """Write what the program reads when it starts, with the content of the EEPROM on the
        sensor's bus; None: there is no EEPROM."""
        folder = Path(folder)
        if eeprom is not None:
            (folder / _EEPROM_FILE).write_bytes(eeprom)
        (folder / "ncdc_soc_rom.init").write_text("".join(f"{word:08x}\n" for word in self._rom))
        (folder / "ncdc_soc_sram.init").write_text("0\n")
        (folder / "sensor.bin").write_bytes(self._light.data())

    def command(self, *plusargs):
        """The program with its arguments, to be run in a folder that was filled."""
        return [*command_of(self.program), *self._light.plusargs("sensor.bin"),
                f"+eeprom_file={_EEPROM_FILE}", *plusargs]

    def golden(self, exposure_us=None, gains=NO_RAW_GAINS, lens=None):
        """The golden model's :class:`Corrected` of the frame that the sensor sends with that
        exposure, None: the first one, with these gains at capture, and another ``lens``, a
        :class:`Descriptor`, if the device has loaded one."""
        found = self.setup if exposure_us is None else self._set_up(exposure_us)[0]
        return correct(lens or self.descriptor, self.raw(found, gains))

    def raw_at(self, exposure_us):
        """The raw frame that the sensor sends with that exposure."""
        return self.raw(self._set_up(exposure_us)[0])

    def _set_up(self, exposure_us):
        return setup_around(self._sensor, self.descriptor.geometry, field=self._field,
                            exposure_us=exposure_us)

    def raw(self, setup, gains=NO_RAW_GAINS):
        """The raw frame that the sensor sends with that :class:`Setup`, with gains at capture."""
        geometry = self.descriptor.geometry
        frame, = self._crop.raw(raw_frames(setup, self._light), geometry.distorted)
        return levelled(frame, setup.sensor.black, gains=frame_gains(geometry, gains))


def _build(core_text, soc, setup):
    """The program. It reads the firmware when it starts: new firmware needs no new program."""
    sources = [*((name, hdl_text(name)) for name in ("soc_bench.v", "eeprom_24c.v")),
               *sensor_sources(),
               ("ncdc_core.v", core_text), ("ncdc_soc.v", soc.text),
               ("VexRiscv.v", Path(soc.core).read_text())]
    # LiteX's Verilog and the processor's are others': their warnings are not ours to mend.
    lanes = {"NCDC_CSI2": setup.link.lanes} if setup.link else {}
    return build("soc", "soc_bench", sources,
                 defines={"NCDC_SENSOR": f'"{setup.sensor.name}"', **lanes},
                 main=HDL / "soc_main.cpp",
                 options=("-Wno-fatal", "-CFLAGS", "-fno-tree-slp-vectorize"))


class SocRun:
    """A :class:`SocModel` that runs on a network of its own, as a context.

    Parameters
    ----------
    model : SocModel
    loss : int
        Frames of a thousand that are lost on their way out.
    mtu : int
        MTU of the clients' network interface.
    eeprom : bytes, optional
        Content of the EEPROM on the sensor's bus; without it there is none.

    Attributes
    ----------
    network : TapNetwork
        The clients' side; the device is at ``ADDRESS``.

    Raises
    ------
    SimulationError
        If there can be no such network, or the firmware does not start.
    """

    def __init__(self, model, loss=0, mtu=1500, eeprom=None):
        self._model, self._loss, self._eeprom = model, loss, eeprom
        self.network = TapNetwork(mtu)

    def __enter__(self):
        self.network.__enter__()
        try:
            self._folder = tempfile.TemporaryDirectory(prefix="ncdc-")
            folder = Path(self._folder.name)
            self._model.fill(folder, self._eeprom)
            self._screen, self._said = folder / "screen.txt", folder / "said.txt"
            with open(self._screen, "w") as screen, open(self._said, "w") as said:
                self._process = self.network.start(
                    self._model.command(f"+tap={TAP}", f"+loss={self._loss}", "+answers"),
                    cwd=folder, stdout=screen, stderr=said)
            self._wait()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *failure):
        self.network.__exit__(*failure)
        self._folder.cleanup()

    def _wait(self):
        self.wait_for(lambda: _STARTED in self._screen.read_text())

    def wait_for(self, there):
        """Wait until ``there()``; :class:`SimulationError` if the program ends or it takes long."""
        end = time.monotonic() + _TIMEOUT_S
        while not there():
            if self._process.poll() is not None or time.monotonic() > end:
                raise SimulationError("what was waited for has not come:\n"
                                      + self._screen.read_text() + self._said.read_text())
            time.sleep(0.05)

    @property
    def screen(self):
        """Output of the firmware on the serial line, and of the sensor's model."""
        return self._screen.read_text()

    @property
    def said(self):
        """What the simulation has said of itself: among that a line ``ANSWER gvcp`` or ``ANSWER
        table`` for each command, with its clocks at the wire."""
        return self._said.read_text()

    @property
    def broken(self):
        """Frames that broke on their way out so far: a wrong check sequence, or a pause."""
        return self.said.count("FRAME-ERROR")

    def end(self):
        """End the run; what the simulation says of itself, as text."""
        self._process.terminate()
        self._process.wait(_TIMEOUT_S)
        return self._said.read_text()
