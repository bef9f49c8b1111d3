"""The processor around the camera system: VexRiscv, its memories, a MAC."""

from dataclasses import dataclass

from litex.gen import LiteXModule
from litex.soc.integration.soc import SoCRegion
from litex.soc.integration.soc_core import SoCCore
from litex.soc.interconnect import wishbone
from litex.soc.interconnect.csr_eventmanager import EventManager, EventSourceLevel
from migen import Mux, Signal

from ncdc_boards.camera_board.board import EthernetChip
from ncdc_hdl.link.processor import ADDRESS_BITS, FRAMES_BITS
from ncdc_soc.mac import SLOT_BYTES, Mac

__all__ = ["MAP", "Processor", "ProcessorVerilog", "described"]

MAP = {"rom": 0x0000_0000, "sram": 0x1000_0000, "ncdc": 0x9000_0000, "ethmac_rx": 0x9010_0000,
       "ethmac_tx": 0x9011_0000, "frames": 0xA000_0000, "csr": 0xF000_0000}
"""Byte addresses of what the processor sees."""

_RX_SLOTS, _TX_SLOTS = 4, 2
_WATCHDOG_DELAY = 1             # clocks from its end to the reset; its timer does not support 0


@dataclass(frozen=True)
class ProcessorVerilog:
    """A processor, and its properties that the firmware depends on.

    Parameters
    ----------
    text : str
        Its module; it instantiates ``VexRiscv``.
    core : str
        Path of VexRiscv's Verilog.
    registers : dict
        Byte address of each of LiteX's registers, by name.
    memories : dict
        First byte and size of each region, by name.
    interrupt : int
        Bit of the system's line in the mask of VexRiscv's interrupts.
    clock_hz : int
    chip : EthernetChip or None
        At its pins; None: there are none.
    compressed : bool
        It has compressed instructions.
    """
    text: str
    core: str
    registers: dict
    memories: dict
    interrupt: int
    clock_hz: int
    chip: EthernetChip | None = None
    compressed: bool = False


class _Interrupt(LiteXModule):
    """The system's interrupt as an event, which lasts as long as it does."""

    def __init__(self):
        self.ev = EventManager()
        self.ev.system = EventSourceLevel(description="An event of camera or packetiser.")
        self.ev.finalize()


class Processor(SoCCore):
    """VexRiscv, its ROM and memory, a watchdog, a MAC, and the bus to the camera system.

    Parameters
    ----------
    platform : LiteX platform
    clock_hz : int
    phy : LiteX PHY
        PHY of the MAC.
    memory_bytes : (int, int)
        Of the ROM, of the SRAM.
    uart : str
        As LiteX names it; "stub": none.
    clocks : LiteXModule
        With the domain ``sys`` and a signal ``rst``, of the watchdog.
    in_words : bool
        Parameter of :class:`Mac`.
    compressed : bool
        With compressed instructions, for a smaller ROM; a larger processor.

    Attributes
    ----------
    port : dict
        Migen signals of :class:`~ncdc_hdl.link.processor.ProcessorPort`, by their names in the
        Verilog of a component's member ``processor``; and which of them the processor drives.
    """

    mem_map = {**SoCCore.mem_map, **MAP}

    def __init__(self, platform, clock_hz, phy, *, memory_bytes, uart, clocks,
                 in_words=False, compressed=False):
        rom_bytes, sram_bytes = memory_bytes
        SoCCore.__init__(
            self, platform, clock_hz, cpu_type="vexriscv",
            cpu_variant="imac" if compressed else "standard",
            integrated_rom_size=rom_bytes, integrated_rom_init=[0],
            integrated_sram_size=sram_bytes, uart_name=uart, ident="",
            with_timer=True,
            # The caches read eight words at a time: of ROM and SRAM one in a clock that way.
            bus_bursting=True)
        self.crg = clocks
        self.add_watchdog("watchdog", reset_delay=_WATCHDOG_DELAY)
        self.ethphy = phy
        self.ethmac = Mac(phy, _RX_SLOTS, in_words)
        self.irq.add("ethmac", use_loc_if_exists=True)
        for name, bus, slots in (("rx", self.ethmac.bus_rx, _RX_SLOTS),
                                 ("tx", self.ethmac.bus_tx, _TX_SLOTS)):
            self.bus.add_slave(f"ethmac_{name}", bus, SoCRegion(
                origin=MAP[f"ethmac_{name}"], size=slots * SLOT_BYTES, cached=False))
        self.system = _Interrupt()
        self.irq.add("system", use_loc_if_exists=True)
        self.port = {**self._bus("ncdc", "registers", ADDRESS_BITS),
                     **self._bus("frames", "frames", FRAMES_BITS), **self._packets()}

    def _bus(self, region, name, address_bits):
        """A bus to the system: its signals, and whether the processor drives them."""
        bus = wishbone.Interface(data_width=32, adr_width=30)
        self.bus.add_slave(region, bus, SoCRegion(origin=MAP[region], size=4 << address_bits,
                                                  cached=False))
        driven = {"adr": bus.adr[:address_bits], "dat_w": bus.dat_w, "sel": bus.sel,
                  "cyc": bus.cyc, "stb": bus.stb, "we": bus.we}
        read = {"dat_r": bus.dat_r, "ack": bus.ack, "err": bus.err}
        return {f"processor__{name}__{member}": (signal, members is driven)
                for members in (driven, read) for member, signal in members.items()}

    def _packets(self):
        """Ethernet frames to the MAC, and the interrupt, likewise."""
        frames, empty = self.ethmac.frames, Signal(2)
        self.comb += frames.last_be.eq(Mux(frames.last, 0b1000 >> empty, 0))
        return {"processor__packet_valid": (frames.valid, False),
                "processor__packet_ready": (frames.ready, True),
                "processor__packet_data": (frames.data, False),
                "processor__packet_empty": (empty, False),
                "processor__packet_last": (frames.last, False),
                "processor__irq": (self.system.ev.system.trigger, False)}


def described(soc, platform, text, chip=None):
    """The :class:`ProcessorVerilog` of a :class:`Processor`, of its Verilog and of the Ethernet
    chip at its pins."""
    core = next(source[0] for source in platform.sources if "VexRiscv" in source[0])
    registers = {f"{bank}_{csr.name}".upper(): region.origin + 4 * offset
                 for bank, region in soc.csr_regions.items()
                 for offset, csr in _located(region.obj)}
    memories = {name: (region.origin, region.size) for name, region in soc.bus.regions.items()}
    return ProcessorVerilog(text, core, registers, memories, soc.irq.locs["system"],
                            int(soc.sys_clk_freq), chip, soc.cpu.variant == "imac")


def _located(csrs):
    """(word, register) of a bank's registers; one of more than 32 bits takes several."""
    offset = 0
    for csr in csrs if isinstance(csrs, list) else []:
        yield offset, csr
        offset += -(-csr.size // 32)
