"""The processor of a board: a module of its own, between the board's core and an Ethernet chip."""

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from litex.build.altera import AlteraPlatform
from litex.build.generic_platform import Pins, Subsignal
from litex.build.lattice import LatticeECP5Platform
from litex.gen import LiteXModule
from migen import ClockDomain, Signal

from ncdc_boards.camera_board.core import CAPACITY
from ncdc_boards.camera_board.design import READER_OF_HOST
from ncdc_boards.camera_board.ethernet import MODULE
from ncdc_soc.firmware import Identity, config, firmware_image
from ncdc_soc.mdio import Mdio
from ncdc_soc.phy import RgmiiPhy
from ncdc_soc.processor import Processor, described
from ncdc_soc.verilog import litex_verilog
from ncdc_spec.sensors.catalogue import controlled_sensor

__all__ = ["MEMORY_BYTES", "ProcessorFiles", "board_processor", "processor_files"]

MEMORY_BYTES = {False: (0x12000, 0x10000), True: (0xe000, 0xe000)}
"""Of ROM and SRAM, without and with compressed instructions: 0xe000 are seven block RAMs of an ECP5
for each byte of a word."""
_RESET_MS = 10              # of the chip's pin, at least: Marvell, 88E1111; Broadcom, B50612D
_DEVICES = {"quartus": (AlteraPlatform, "quartus", False),
            "open": (LatticeECP5Platform, "trellis", True)}
"""By a board's tools: LiteX's platform, what LiteX calls them, whether it is an ECP5: its input
cells are ``paired``, its ``Mac`` works ``in_words``, its Sender is ``buffered``, and its processor
has ``compressed`` instructions, as its block RAM is scarce."""
_CLOCKS = {"sys": 1, "reset": 1, "transmit": 1, "rx": 1, "tx": 1}
_PINS = {"rx_data": 4, "rx_ctl": 1, "tx_data": 4, "tx_ctl": 1, "rst_n": 1}
_MDIO = {"mdc": 1, "data": 1, "enable": 1, "pin": 1}


def _signals(name, members):
    return name, 0, *(Subsignal(member, Pins(" ".join(f"{name}{member}{k}" for k in range(bits))))
                      for member, bits in members.items())


class _Clocks(LiteXModule):
    """The core's clock and reset, and the watchdog's."""

    def __init__(self, pads):
        self.cd_sys = ClockDomain()
        self.rst = Signal()
        self.comb += [self.cd_sys.clk.eq(pads.sys), self.cd_sys.rst.eq(pads.reset | self.rst)]


class _BoardProcessor(Processor):
    """A :class:`Processor` whose port and wires are the module's."""

    def __init__(self, platform, clock_hz, ecp5):
        clocks, pins = platform.request("clock"), platform.request("eth")
        phy = RgmiiPhy(clocks, pins, clocks.transmit, getattr(clocks, "late", None), paired=ecp5,
                       reset_clocks=clock_hz * _RESET_MS // 1000, buffered=ecp5)
        super().__init__(platform, clock_hz, phy, memory_bytes=MEMORY_BYTES[ecp5],
                         uart="stub", clocks=_Clocks(clocks), in_words=ecp5, compressed=ecp5)
        self.mdio, wires = Mdio(), platform.request("mdio")
        self.comb += [wires.mdc.eq(self.mdio.mdc), wires.data.eq(self.mdio.data),
                      wires.enable.eq(self.mdio.enable), self.mdio.pin.eq(wires.pin)]
        platform.add_extension([(name, 0, Pins(" ".join(f"{name}{k}" for k in range(len(signal)))))
                                for name, (signal, _) in self.port.items()])
        for name, (signal, driven) in self.port.items():
            pad = platform.request(name)
            self.comb += pad.eq(signal) if driven else signal.eq(pad)


def board_processor(board, clock_hz):
    """:class:`~ncdc_soc.processor.ProcessorVerilog` of the module
    :data:`~ncdc_boards.camera_board.ethernet.MODULE` for a board with RGMII.

    Its ROM has its program, ``<module>_rom.init``, when the device is configured.
    """
    make, tools, ecp5 = _DEVICES[board.tools]
    clocks = _CLOCKS | ({} if board.ethernet.delays else {"late": 1})
    platform = make(board.device, [_signals("clock", clocks), _signals("eth", _PINS),
                                   _signals("mdio", _MDIO)], toolchain=tools)
    soc, text = litex_verilog(platform, lambda: _BoardProcessor(platform, clock_hz, ecp5), MODULE)
    return described(soc, platform, text, board.ethernet)


@dataclass(frozen=True)
class ProcessorFiles:
    """Files of a design with a processor, as well as its top.

    Parameters
    ----------
    verilog : dict
        Text of the processor's Verilog, by the files' names.
    memories : dict
        Text of the initial contents of its memories, which its Verilog reads, by the files' names.
    code_bytes, ram_bytes : int
        Sizes of the firmware.
    """
    verilog: dict
    memories: dict
    code_bytes: int
    ram_bytes: int


def processor_files(design, sensor, identity=Identity()):
    """The :class:`ProcessorFiles` of a design with a processor.

    Parameters
    ----------
    design : ncdc_boards.camera_board.core.Design
    sensor : (Setup, Crop)
        As of :func:`~ncdc_boards.camera_board.design.sensor_for`.
    identity : Identity

    Raises
    ------
    InputError
        If the firmware does not know the sensor, or cannot be compiled.
    """
    controlled_sensor(sensor[0].sensor.name)
    processor = board_processor(design.board, design.core_hz)
    text = config(design.system, CAPACITY, processor, *sensor, identity, sets_up=False,
                  first_reader=READER_OF_HOST + 1)
    with TemporaryDirectory(prefix="ncdc-") as folder:
        words, code, ram = firmware_image(text, processor, folder)
    return ProcessorFiles(
        {f"{MODULE}.v": processor.text, "VexRiscv.v": Path(processor.core).read_text()},
        {f"{MODULE}_rom.init": "".join(f"{word:08x}\n" for word in words),
         f"{MODULE}_sram.init": "0\n"}, code, ram)
