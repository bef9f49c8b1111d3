"""Video at both ends of a system, each part alone: streams of a camera, and the words of DVI."""

from amaranth import Cat

from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.camera.avalon_st_source import AvalonStSource
from ncdc_hdl.camera.axis_source import AxisSource
from ncdc_hdl.video.tmds import TmdsEncoder
from pipelines import run_bench
from simulations.traces import Alone, Recorded
from units.tmds import check_tmds
from units.videos import check_avalon_st_video, check_axis_video, check_control_packets

__all__ = ["DESIGN"]

_TOP = "video"
_PACKET = "valid", "startofpacket"


def _resets(check, valid, start, **form):
    """A check, and then resets, one of them in a frame."""
    def run(dut):
        check(dut, **form)

        async def bench(ctx):
            for reset, value in ((1, 0), (1, 0), (0, 0), (0, 1), (0, 1), (1, 1), (0, 0), (0, 0)):
                ctx.set(dut.reset, reset)
                ctx.set(getattr(dut, valid), value)
                ctx.set(getattr(dut, start), value)
                await ctx.tick()

        run_bench(dut, bench)
    return run


def _source(part, check, *names):
    """A source of samples: what it gives means something in the clocks of samples, or of an end."""
    means = {"o__sample": lambda part: Cat(valid.replicate(len(sample)) for valid, sample in zip(
        part.o.valid, part.o.sample)), "o__bad": lambda part: part.o.end}
    return Alone(part, means=means), _resets(check, *names, count=part.count, bits=part.bits)


def units():
    """Each part with its check, by name."""
    return {"axis": _source(AxisSource(2, 12), check_axis_video, "tvalid", "tuser"),
            "avalon_st": _source(AvalonStSource(4, 12), check_avalon_st_video, *_PACKET),
            "packets": _source(AvalonStSource(2, 12, control=True), check_control_packets,
                               *_PACKET),
            "tmds": (Alone(TmdsEncoder(), "pixel"), check_tmds)}


_RECORDED = Recorded(units, _TOP)
DESIGN = Design(_TOP, _TOP, _RECORDED.make, (PlayedBench("parts", _RECORDED.parts),), bare=2)
