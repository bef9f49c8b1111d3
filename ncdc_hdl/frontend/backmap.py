"""The front end: back-map coordinates of every corrected pixel from the network."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.frontend.layouts import (
    coordinate_layout,
    join_network,
    network_ports,
    scan_layout,
)
from ncdc_hdl.frontend.scan import Scan
from ncdc_hdl.frontend.signatures import SpansRequest
from ncdc_hdl.lib.credits import CreditQueue
from ncdc_hdl.lib.pipeline import DelayMemory, delay
from ncdc_hdl.neural.layers import MultiplyLayer, OutputLayer
from ncdc_hdl.neural.raster import RasterLayer
from ncdc_hdl.neural.tansig import Tansig
from ncdc_spec.hardware import Hardware

__all__ = ["BackMap", "pace"]

_SLACK = 16     # queue entries above those under way: for the credits, and a margin


class BackMap(wiring.Component):
    """Scan, HN hidden neurons with their tan-sigmoids, two output neurons, queue (Figs. 8, 29).

    Equal bit for bit to ``ncdc_model.golden.network.coordinates`` in the order of :class:`Strips`,
    for any hardware. Each of ``hardware.lanes`` neighbouring pixels has a network of its own;
    all have the same weights. Timing: the networks run free, one group of pixels every
    ``hardware.share`` clocks; ``latency`` clocks from a scanned group to the queue. Instead of
    gating the front end's clock while the back end is full, the scan issues a group only if the
    queue has space for all groups under way (see :class:`CreditQueue`).

    Parameters
    ----------
    hidden_neurons : int
        HN.
    formats : ncdc_spec.descriptor.Formats
    Variant of the tan-sigmoid.
        Variant of the tan-sigmoid.
    hardware : ncdc_spec.hardware.Hardware
        Its hidden, share, multiplier_bits and lanes are used.
    queue : int, optional
        Groups under way and queued together, at least 16 more than ``under_way``; by default
        the next power of two, at least 128.

    Members
    -------
    start : ``In(1)``
        Begins a frame; allowed only when the last one has left ``o``.
    abort : ``In(1)``
        Ends the frame early, see :class:`Scan`.
    scan : ``In(scan_layout())``
        Constant during a frame.
    network, writes : see :func:`network_ports`
    table : ``Out(SpansRequest())``
        To the table of valid rows.
    o : ``Out(stream.Signature(coordinate_layout(formats, lanes)))``
    idle : ``Out(1)``
        The network is empty and no pixel enters it in this clock.
    stalled : ``Out(1)``
        A pixel waits for space in the queue.
    cut : ``Out(1)``
        The frame was ended early.

    Raises
    ------
    InputError
        If a tan-sigmoid is to serve more neurons than there are, or there is no such variant.
    ValueError
        If the queue is too short for the coordinate rate.
    """

    def __init__(self, hidden_neurons, formats, *, variant="mmhbc",
                 hardware=Hardware(), queue=None):
        self.hidden_neurons, self.formats, self.lanes = hidden_neurons, formats, hardware.lanes
        self.nodes = 1
        lanes = self.lanes
        self.share = hardware.share or 1
        units = hardware.units(hidden_neurons)
        self.hidden = [RasterLayer(hidden_neurons, formats, self.share, lanes)
                       if hardware.hidden == "raster" else
                       MultiplyLayer(hidden_neurons, formats, self.share,
                                    hardware.multiplier_bits, lanes, hardware.fixed_lens)
                       for _ in range(lanes)]
        self.tansig = [[Tansig(formats.tansig_design(variant)) for _ in range(units)]
                       for _ in range(lanes)]
        self.output = [OutputLayer(hidden_neurons, formats, self.share,
                                   hardware.multiplier_bits, hardware.fixed_lens)
                       for _ in range(lanes)]
        # Groups that can be issued between the clock in which the queue outputs one and
        # the arrival of the first one in its slot.
        self.under_way = -(-(self.latency + CreditQueue.loop) // self.share)
        needed = self.under_way + _SLACK
        self.queue = queue or max(128, 1 << (needed - 1).bit_length())
        if self.queue < needed:
            raise ValueError(f"queue is {queue}, the limit is {needed}: the {self.under_way} "
                             f"groups under way and {_SLACK}")
        super().__init__({
            "start": In(1), "abort": In(1), "scan": In(scan_layout()),
            "table": Out(SpansRequest()),
            "o": Out(stream.Signature(coordinate_layout(formats, lanes))),
            "idle": Out(1), "stalled": Out(1), "cut": Out(1),
        } | network_ports(hidden_neurons, formats, hardware))

    @property
    def latency(self):
        """Clocks from a scanned pixel to its arrival in the queue."""
        return self.hidden[0].latency + self.tansig[0][0].latency + self.output[0].latency

    @property
    def interval(self):
        """Clocks from one group of coordinates to the next."""
        return self.share

    @property
    def lead(self):
        """Most clocks that coordinates are computed before use while others wait."""
        return self.share * self.queue - self.latency - CreditQueue.loop

    @property
    def start_latency(self):
        """Clocks from ``start`` to the first coordinate at ``o``: scan, first sums, networks,
        queue."""
        return (Scan.latency + self.hidden[0].start_latency + self.latency + CreditQueue.latency)

    def elaborate(self, platform):
        m = Module()
        m.submodules.scan = scan = Scan(self.formats, self.lanes)
        # At the restart level the queue holds the groups for the consumer until the network is full
        # again, so that it does not run dry.
        m.submodules.queue = queue = CreditQueue(
            coordinate_layout(self.formats, self.lanes), depth=self.queue,
            restart=max(self.under_way, self.queue // 2))
        m.d.comb += [
            scan.start.eq(self.start), scan.abort.eq(self.abort), scan.parameters.eq(self.scan),
            self.cut.eq(scan.cut),
        ]
        wiring.connect(m, scan.table, wiring.flipped(self.table))

        # All lanes are ready in the same clock.
        issue, turn = pace(m, scan, self.share, queue.space & self.hidden[0].ready)
        latency = self.output[0].latency
        activated = delay(m, issue, self.latency - latency, "issue", reset_less=False)
        arrived = delay(m, activated, latency, "output", reset_less=False)
        blank = delay(m, scan.blank, self.latency - scan.blank_latency, "blank")
        coordinates = []
        for k, (hidden, output) in enumerate(zip(self.hidden, self.output)):
            m.submodules[f"hidden{k}"], m.submodules[f"output{k}"] = hidden, output
            if output.skip:
                m.submodules[f"inputs{k}"] = inputs = DelayMemory(
                    2 * self.formats.input.width, self.latency - latency + output.inputs_clock)
                m.d.comb += [inputs.i.eq(Cat(scan.pixels[k].x, scan.pixels[k].y)),
                             Value.cast(output.inputs).eq(inputs.o)]
            m.d.comb += [
                hidden.start.eq(self.start), hidden.active.eq(scan.active),
                hidden.pixel.eq(scan.pixels[k]), hidden.turn.eq(turn),
                hidden.advance.eq(scan.advance), output.first.eq(activated),
            ]
            join_network(m, self, hidden, output)
            for j, tansig in enumerate(self.tansig[k]):
                m.submodules[f"tansig{k}_{j}"] = tansig
                m.d.comb += [tansig.i.eq(hidden.o[j]), output.i[j].eq(tansig.o)]
            coordinates += [output.o, blank[k]]
        flags = delay(m, Cat(scan.first, scan.last), self.latency, "flags")
        m.d.comb += [
            queue.issue.eq(issue), queue.arrive.eq(arrived),
            Value.cast(queue.i).eq(Cat(*coordinates, flags)),
            self.idle.eq(queue.drained & ~issue),
            self.stalled.eq(scan.active & ~queue.space),
        ]
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        return m


def pace(m, scan, share, may_issue):
    """Take a pixel in the clock after ``may_issue``, and hold it for ``share`` turns.

    Returns (a pixel enters the network in its turn 0, the turn).
    """
    if share == 1:
        m.d.comb += scan.go.eq(may_issue)
        return scan.advance, Const(0, 1)
    issue = Signal()                # a pixel enters the network, in its turn 0
    may = Signal()                  # ``may_issue``, a clock ago
    turn = Signal(range(share))     # turn of the pixel that is held
    m.d.sync += may.eq(may_issue)
    m.d.comb += [issue.eq(scan.active & may & (turn == 0)),
                 scan.go.eq(issue if share == 2 else turn == share - 2)]
    with m.If(issue | (turn != 0)):
        m.d.sync += turn.eq(Mux(turn == share - 1, 0, turn + 1))
    return issue, turn
