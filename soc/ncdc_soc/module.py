"""The corrector as a module for LiteX.

    from ncdc_soc.module import NCDC

    self.ncdc = NCDC(platform, "net.toml", self.sdram.crossbar)
    self.bus.add_slave("ncdc", self.ncdc.bus, self.ncdc.region(0x9000_0000))
    self.irq.add("ncdc", use_loc_if_exists=True)
"""

from dataclasses import replace
from itertools import count
from pathlib import Path

from amaranth.back import verilog
from litex.gen import LiteXModule
from litex.soc.cores.video import video_data_layout
from litex.soc.integration.soc import SoCRegion
from litex.soc.interconnect import stream, wishbone
from litex.soc.interconnect.csr_eventmanager import EventManager, EventSourceLevel
from migen import ClockSignal, Instance, ResetSignal, Signal

from ncdc_hdl.export.verilog.names import check_module_name
from ncdc_soc.module_core import ModuleCore
from ncdc_soc.native import native_port
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import ADDRESS_WORDS_BITS

__all__ = ["NCDC"]


class NCDC(LiteXModule):
    """Corrects raw frames in LiteDRAM's memory, to the same memory or as a video stream.

    Addresses in its registers count bytes from the memory's own beginning. The processor sees the
    memory at ``main_ram``. The registers take the processor's addresses as well, if a memory of 2^n
    bytes lies at a multiple of 2^n: the upper bits are dropped.

    Parameters
    ----------
    platform : GenericPlatform
        Gets the Verilog as a source.
    net : Descriptor or path
        The camera: a ``net.toml``, or what was read from one.
    crossbar : LiteDRAMCrossbar
        ``self.sdram.crossbar``; must not be finalised.
    hardware : Hardware, optional
        How it is built. If absent: ports as wide as the controller's, corrected frames to memory.
    name : str, optional
        Name of the Verilog module. If absent ``ncdc``, ``ncdc1`` and so on, the first one of which
        the platform has no source.
    folder : path
        Where ``name.v`` is written.

    Attributes
    ----------
    bus : wishbone.Interface
        A slave of 32 bits: the registers, as in the register map. For :meth:`region`.
    source : stream.Endpoint(video_data_layout)
        Of hardware with the output "stream", else None. A pixel per beat, ``de`` high with each,
        ``first`` and ``last`` at a frame's ends. ``hsync`` and ``vsync`` stay low, as frames have
        no timing of a screen. It waits for ``ready`` without a limit.
    ev : EventManager
        The event ``frame``: high while STATUS.DONE is, if IRQ_ENABLE lets it. Writing 1 to
        STATUS.DONE ends it.
    core : ModuleCore

    Raises
    ------
    InputError
        If the hardware fits neither the camera nor the controller. If its stream has more than one
        pixel per clock, or packets. If the name is no Verilog name, or taken.
    """

    def __init__(self, platform, net, crossbar, hardware=None, name=None, folder="build"):
        name = _name(platform, name)
        width = crossbar.controller.data_width
        hardware = replace(hardware or Hardware(data_width=width), bus="axi")
        _check(hardware, width)
        descriptor = net if isinstance(net, Descriptor) else Descriptor.load(net)
        self.core = core = ModuleCore(descriptor, hardware)
        self.bus = bus = wishbone.Interface(data_width=32, adr_width=30)
        self.ev = EventManager()
        self.ev.frame = EventSourceLevel(description="A frame is corrected.")
        self.ev.finalize()
        self.source = stream.Endpoint(video_data_layout) if hardware.stream else None

        ports = {}
        for k in range(core.ports):
            ports |= native_port(self, crossbar.get_port(), f"port{k}__")
        if hardware.stream:
            ports |= self._stream()
        self.specials += Instance(
            name, **ports, i_clk=ClockSignal(), i_rst=ResetSignal(),
            i_bus__adr=bus.adr[:ADDRESS_WORDS_BITS], i_bus__dat_w=bus.dat_w, i_bus__sel=bus.sel,
            i_bus__cyc=bus.cyc, i_bus__stb=bus.stb, i_bus__we=bus.we, o_bus__dat_r=bus.dat_r,
            o_bus__ack=bus.ack, o_bus__err=bus.err, o_irq=self.ev.frame.trigger)
        path = Path(folder) / f"{name}.v"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(verilog.convert(core, name=name))
        platform.add_source(str(path))

    @staticmethod
    def region(origin=None):
        """The :class:`SoCRegion` of the registers at a byte address, or where LiteX finds space."""
        return SoCRegion(origin=origin, size=4 << ADDRESS_WORDS_BITS, cached=False)

    def _stream(self):
        """The core's stream, red in the top byte, on :attr:`source`."""
        source, colours = self.source, Signal(24)
        self.comb += [source.de.eq(source.valid), source.b.eq(colours[:8]),
                      source.g.eq(colours[8:16]), source.r.eq(colours[16:])]
        return {"o_stream_valid": source.valid, "i_stream_ready": source.ready,
                "o_stream_data": colours, "o_stream_startofpacket": source.first,
                "o_stream_endofpacket": source.last}


def _name(platform, asked):
    """The name ``asked`` for, or the first that none of the ``platform``'s sources has.

    A source of the same name would replace this one's module.
    """
    taken = {Path(source).stem for source, *_ in platform.sources}
    if asked is None:
        return next(name for k in count() if (name := f"ncdc{k or ''}") not in taken)
    if check_module_name(asked) in taken:
        raise InputError(f"the name is {asked!r}, which another Verilog module of the system has")
    return asked


def _check(hardware, width):
    """Reject hardware that the controller or LiteX's video does not support."""
    if hardware.data_width != width:
        raise InputError(f"the memory's data width is {hardware.data_width}, LiteDRAM's controller "
                         f"has {width}")
    if hardware.stream and hardware.lanes != 1:
        raise InputError(f"pixels per clock is {hardware.lanes}, LiteX's video has 1")
