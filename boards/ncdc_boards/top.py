"""The top of a board's design: Platform Designer system, clocks, video output."""

from amaranth import *
from amaranth.lib import io
from amaranth.lib.cdc import ResetSynchronizer

from ncdc_boards.system import SYSTEM
from ncdc_hdl.video.output import VideoOut

__all__ = ["BoardTop", "system_ports"]

# Port of the SDRAM controller's conduit, and the board's signal.
_SDRAM = {"addr": "a", "ba": "ba", "cas_n": "cas_n", "cke": "cke", "cs_n": "cs_n", "dqm": "dqm",
          "ras_n": "ras_n", "we_n": "we_n"}
_STREAM = ("valid", "data", "startofpacket", "endofpacket")


def system_ports():
    """Names of the ports of the Platform Designer system that :class:`BoardTop` connects."""
    return {"clk_clk", "reset_reset_n", "sdram_dq", "video_ready", "irq_irq",
            "front_end_idle_export", "camera_rows_export", *(f"sdram_{name}" for name in _SDRAM),
            *(f"video_{name}" for name in _STREAM)}


class BoardTop(Elaboratable):
    """Connects the Platform Designer system with the pins of a board.

    Parameters
    ----------
    board : Board
    mode : VideoMode
    width, height : int
        Corrected picture.
    """

    def __init__(self, board, mode, width, height):
        self.board, self.mode, self.width, self.height = board, mode, width, height

    def elaborate(self, platform):
        m = Module()
        clk50, reset = (self._buffer(m, platform.request(name, dir="-")).i
                        for name in ("clk50", "rst"))
        sdram = platform.request("sdram", dir="-")
        self._clocks(m, clk50, reset, self._buffer(m, sdram.clk))
        m.submodules.video = video = VideoOut(self.mode, self.width, self.height)

        stream = {name: Signal(24 if name == "data" else 1, name=f"stream_{name}")
                  for name in _STREAM}
        reset_n = Signal()
        m.d.comb += reset_n.eq(~ResetSignal())
        m.submodules.system = Instance(
            SYSTEM, i_clk_clk=ClockSignal(), i_reset_reset_n=reset_n,
            i_camera_rows_export=Const(0, 13), io_sdram_dq=sdram.dq.io, i_video_ready=video.ready,
            o_irq_irq=Signal(name="irq"), o_front_end_idle_export=Signal(name="front_end_idle"),
            **{f"o_sdram_{name}": getattr(sdram, pin).io for name, pin in _SDRAM.items()},
            **{f"o_video_{name}": signal for name, signal in stream.items()})
        m.d.comb += [
            video.valid.eq(stream["valid"]), video.data.eq(stream["data"]),
            video.startofpacket.eq(stream["startofpacket"]),
        ]
        vga = platform.request("vga", dir="-")
        # The converter takes colours on the rising edge, in the middle of a pixel.
        for name, value in (("clk", ~ClockSignal("pixel")), ("sync_n", 0),
                            *((name, getattr(video, name)) for name in
                              ("hsync", "vsync", "blank_n", "r", "g", "b"))):
            m.d.comb += self._buffer(m, getattr(vga, name)).o.eq(value)
        # The camera is in reset until somebody captures its pictures.
        camera = platform.request("d5m", dir="-")
        for name in ("pixclk", "d", "strobe", "lval", "fval", "sdata"):
            self._buffer(m, getattr(camera, name))
        for name, value in (("xclkin", 0), ("reset_n", 0), ("trigger", 0), ("sclk", 1)):
            m.d.comb += self._buffer(m, getattr(camera, name)).o.eq(value)
        return m

    @staticmethod
    def _buffer(m, port):
        """The buffer of a port."""
        m.submodules[f"{port.io.name}_buffer"] = buffer = io.Buffer(port.direction, port)
        return buffer

    def _clocks(self, m, clk50, reset, sdram_clk):
        """Core, SDRAM and pixel clock from two phase-locked loops."""
        pll = self.board.pll
        reference_ps = round(1e6 / pll.reference_mhz)
        outputs = Signal(5, name="core_clocks")
        core_locked, pixel_locked = Signal(), Signal()
        m.submodules.pll_core = Instance(
            "altpll", p_OPERATION_MODE="NORMAL", p_INCLK0_INPUT_FREQUENCY=reference_ps,
            p_CLK0_MULTIPLY_BY=round(pll.core_mhz), p_CLK0_DIVIDE_BY=round(pll.reference_mhz),
            p_CLK1_MULTIPLY_BY=round(pll.core_mhz), p_CLK1_DIVIDE_BY=round(pll.reference_mhz),
            p_CLK1_PHASE_SHIFT=str(pll.sdram_phase_ps), p_PORT_CLK0="PORT_USED",
            p_PORT_CLK1="PORT_USED", p_PORT_LOCKED="PORT_USED", p_WIDTH_CLOCK=5,
            i_inclk=Cat(clk50, Const(0, 1)), i_areset=reset, o_clk=outputs, o_locked=core_locked)
        pixels = Signal(5, name="pixel_clocks")
        m.submodules.pll_pixel = Instance(
            "altpll", p_OPERATION_MODE="NORMAL", p_INCLK0_INPUT_FREQUENCY=reference_ps,
            p_CLK0_MULTIPLY_BY=self.mode.ratio[0], p_CLK0_DIVIDE_BY=self.mode.ratio[1],
            p_PORT_CLK0="PORT_USED", p_PORT_LOCKED="PORT_USED", p_WIDTH_CLOCK=5,
            i_inclk=Cat(clk50, Const(0, 1)), i_areset=reset, o_clk=pixels, o_locked=pixel_locked)
        m.domains.sync = ClockDomain()
        m.domains.pixel = ClockDomain()
        m.d.comb += [ClockSignal("sync").eq(outputs[0]), ClockSignal("pixel").eq(pixels[0]),
                     sdram_clk.o.eq(outputs[1])]
        m.submodules.sync_reset = ResetSynchronizer(~core_locked, domain="sync")
        m.submodules.pixel_reset = ResetSynchronizer(~pixel_locked, domain="pixel")
