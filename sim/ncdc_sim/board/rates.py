"""Frame rates of a board's network: from the sensor's pins, and from memory alone.

Every picture on the line is compared with the golden model's of its own raw frame.
"""

from dataclasses import dataclass

from ncdc_model.correction import correct
from ncdc_sim.board.network import LINE_HZ, NetworkRun
from ncdc_sim.board.pictures import Steady, line_frames, pictures_of, steady
from ncdc_sim.board.sender import PictureSender
from ncdc_sim.tools import SimulationError
from ncdc_spec.frames import output_format, stored_bytes
from ncdc_spec.pixel_formats import raw_format

__all__ = ["SETTLE", "Rates", "corrected_rates", "replayed_rates"]

SETTLE = 5
"""Pictures until the corrector, which the packetiser's reads slow down, is as late as it gets."""

_END = 10_000       # clocks after a SEND's end until its last packet has gone
_LOST = ("OVERFLOWS", "FRAMES_MISSED", "RAW_ENDED_BAD", "RAW_TAKEN", "CORRECTED_ENDED_BAD",
         "CORRECTED_TAKEN")


@dataclass(frozen=True)
class Rates:
    """Measurements of a run.

    Parameters
    ----------
    steady : Steady
        Figures of the pictures after those that settle.
    format : str
        Format of the pixels.
    underruns : int
        Packets that broke on the line, of all.
    dropped : int
        Raw frames between those pictures that no picture was sent of; of no meaning while raw
        frames are sent again and again.
    lost : int
        Frames that the camera or the corrector lost, or a reader, by the counters.
    corrector_clocks : int
        Clocks of the last corrected frame.
    memory_share : float
        Share of the clocks of the steady pictures in which the SDRAM moved data.
    refresh_most : int
        Clocks between two refreshes, at most.
    screen_underruns : int
    """
    steady: Steady
    format: str
    underruns: int
    dropped: int
    lost: int
    corrector_clocks: int
    memory_share: float
    refresh_most: int
    screen_underruns: int


def corrected_rates(model, count, *, settle=SETTLE, screen=False, sender=PictureSender):
    """:class:`Rates` of so many corrected pictures, while the sensor sends.

    Parameters
    ----------
    model : NetworkModel
    count, settle : int
        Pictures that are sent; those of them from whose last byte on time is taken.
    screen : bool
        Whether the screen reads the memory too.
    sender : type
        Class that emulates the processor.
    """
    descriptor, strip = model.descriptor, model.design.system.hardware.strip
    form = output_format(model.design.system.hardware.format)
    golden = [stored_bytes(correct(descriptor, raw, strip=strip).picture, form)
              for raw in model.raw]
    return _rates(model, golden, form.name, settle, lambda run: sender(run).corrected(count),
                  screen=screen)


def replayed_rates(model, count, *, settle=1, sender=PictureSender):
    """:class:`Rates` of so many raw pictures, two frames in turn, the camera being off."""
    golden = [raw[..., None] for raw in model.raw]
    return _rates(model, golden, raw_format(model.descriptor.geometry).name, settle,
                  lambda run: sender(run).replayed(count))


def _rates(model, golden, format_name, settle, send, screen=False):
    """:class:`Rates` of what ``send`` sends on a run of the model."""
    with NetworkRun(model, screen) as run:
        sent = send(run)
        run.wait(_END)
        lost = sum(run.read(name) for name in _LOST)
        clocks, screen_underruns = run.read("CLOCKS"), run.read("SCREEN_UNDERRUNS")
        run.end()
    frames = line_frames(run.record)
    pictures, broken = pictures_of(frames), sum(not frame.whole for frame in frames)
    if [picture.block for picture in pictures] != [one.block for one in sent]:
        raise SimulationError(f"{len(sent)} pictures were sent, {len(pictures)} are on the line, "
                              f"where {broken} packets broke")
    # The initialisation starts the sensor last: raw frame 1 is the first one that it sends.
    expected = [golden[(one.number - 1) % len(golden)] for one in sent]
    (begin, *before), (end, *after) = sent[settle - 1].counts, sent[-1].counts
    numbers = [one.number for one in sent[settle - 1:]]
    return Rates(
        steady(pictures, expected, LINE_HZ, settle), format_name, broken,
        numbers[-1] - numbers[0] - (len(numbers) - 1), lost, clocks,
        (sum(after) - sum(before)) / (end - begin), run.results["refresh_most"], screen_underruns)
