"""The front end: back-map coordinates of every corrected pixel from the network."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.frontend.layouts import SPANS, SIZE, coordinate_layout, network_layout, scan_layout
from ncdc_hdl.frontend.scan import Scan
from ncdc_hdl.neural.neuron import HiddenNeuron, OutputNeuron
from ncdc_hdl.neural.tansig import Tansig
from ncdc_hdl.streams import CreditQueue, delay
from ncdc_model.network import tansig_design

__all__ = ["BackMap"]


class BackMap(wiring.Component):
    """Scan, HN hidden neurons with their tan-sigmoids, two output neurons, queue (Figs. 8, 29).

    Equal bit for bit to ``ncdc_model.network.coordinates`` in raster order. Timing: the network
    runs free, one coordinate per clock; ``latency`` clocks from a scanned pixel to the queue.
    Instead of gating the front end's clock while the back end is full, the scan issues a pixel
    only if the queue has room for all that is under way (see :class:`CreditQueue`).

    Parameters
    ----------
    hidden_neurons : int
        HN.
    formats : ncdc_model.descriptor.Formats
    queue : int
        Coordinates under way and queued together, more than twice ``latency``.

    Members
    -------
    start : ``In(1)``
        Begins a frame; to be given only when the last one has left ``o``.
    scan, network : ``In(scan_layout())``, ``In(network_layout(...))``
        Constant during a frame.
    row, spans, fresh : ``Out``, ``In(SPANS)``, ``In(1)``
        To the table of valid rows.
    o : ``Out(stream.Signature(coordinate_layout(formats)))``
    idle : ``Out(1)``
        Nothing is under way in the network and nothing may enter: a board may gate its clock.
    stalled : ``Out(1)``
        A pixel waits for room in the queue.

    Raises
    ------
    ValueError
        If the queue is too short for one coordinate per clock.
    """

    def __init__(self, hidden_neurons, formats, *, queue=128):
        self.hidden_neurons, self.formats, self.queue = hidden_neurons, formats, queue
        self.hidden = [HiddenNeuron(formats) for _ in range(hidden_neurons)]
        self.tansig = [Tansig(tansig_design(formats)) for _ in range(hidden_neurons)]
        self.output = [OutputNeuron(hidden_neurons, formats) for _ in range(2)]
        if queue <= 2 * self.latency:
            raise ValueError(f"queue is {queue}, it must exceed twice the latency {self.latency}")
        super().__init__({
            "start": In(1), "scan": In(scan_layout()),
            "network": In(network_layout(hidden_neurons, formats)),
            "row": Out(SIZE), "spans": In(SPANS), "fresh": In(1),
            "o": Out(stream.Signature(coordinate_layout(formats))), "idle": Out(1), "stalled": Out(1),
        })

    @property
    def latency(self):
        """Clocks from a scanned pixel to its arrival in the queue."""
        return self.hidden[0].latency + self.tansig[0].latency + self.output[0].latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.scan = scan = Scan(self.formats)
        # Restarting at the latency keeps the queue from running dry while the network refills.
        m.submodules.queue = queue = CreditQueue(
            coordinate_layout(self.formats), depth=self.queue, restart=self.queue - self.latency)
        m.d.comb += [
            scan.start.eq(self.start), scan.parameters.eq(self.scan),
            self.row.eq(scan.row), scan.spans.eq(self.spans), scan.fresh.eq(self.fresh),
        ]

        issue = Signal()
        m.d.comb += [issue.eq(scan.active & queue.room), scan.advance.eq(issue),
                     queue.issue.eq(issue)]

        activations = []
        for j, (hidden, tansig) in enumerate(zip(self.hidden, self.tansig)):
            m.submodules[f"hidden{j}"], m.submodules[f"tansig{j}"] = hidden, tansig
            m.d.comb += [
                hidden.i.eq(Cat(scan.x, scan.y)),
                hidden.weights.eq(self.network.hidden[j].weights),
                hidden.bias.eq(self.network.hidden[j].bias),
                tansig.i.eq(hidden.o),
            ]
            activations.append(tansig.o)
        for k, output in enumerate(self.output):
            m.submodules[f"output{k}"] = output
            m.d.comb += [
                output.i.eq(Cat(activations)),
                output.weights.eq(self.network.output[k].weights),
                output.bias.eq(self.network.output[k].bias),
            ]

        flags = delay(m, Cat(scan.blank, scan.first, scan.last), self.latency, "flags")
        m.d.comb += [
            queue.arrive.eq(delay(m, issue, self.latency, "issue", reset_less=False)),
            Value.cast(queue.i).eq(Cat(self.output[0].o, self.output[1].o, flags)),
            self.idle.eq(queue.idle), self.stalled.eq(scan.active & ~queue.room),
        ]
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        return m
