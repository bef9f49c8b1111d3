"""The network's layers: hidden neurons that multiply, and the two output neurons."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import bits_for

from ncdc_hdl.lib.pipeline import delay, register
from ncdc_hdl.neural.banks import BANK_WRITES, WeightBanks
from ncdc_hdl.neural.layouts import hidden_layout, output_layout, pixel_layout
from ncdc_hdl.neural.neuron import HiddenNeuron, OutputNeuron

__all__ = ["MultiplyLayer", "OutputLayer", "hidden_layer_ports", "served"]


def served(unit, hidden_neurons, share):
    """Numbers of the hidden neurons that tan-sigmoid ``unit`` serves in turn."""
    return range(unit * share, min((unit + 1) * share, hidden_neurons))


def _of_turn(m, turn, words, name):
    """The one of ``words`` for a ``turn``, ``WeightBanks.latency`` later; zero for turns without
    a neuron."""
    word = Signal.like(words[0], name=name)
    with m.Switch(turn):
        for k, value in enumerate(words):
            with m.Case(k):
                m.d.comb += word.eq(value)
    return delay(m, word, WeightBanks.latency, f"{name}_of_turn")


def hidden_layer_ports(hidden_neurons, formats, share, lanes=1, in_memory=False):
    """Ports of every kind of hidden layer; with ``writes`` if its weights are ``in_memory``, else
    with ``neurons``.

    start : ``In(1)``
        Begins a frame, whose parameters are ready.
    active, pixel : ``In(1)``, ``In(pixel_layout(formats, lanes))``
        The pixel of the scan in the layer's lane. Each is held for at least ``share`` clocks.
    turn : ``In``
        0 in the first of those clocks, then incremented each clock.
    advance : ``In(1)``
        The next pixel follows.
    neurons : ``In(hidden_layout(...))``
        Constant in a frame.
    writes : ``In(BANK_WRITES)``
        Writes to the memories of weights and biases.
    ready : ``Out(1)``
        The pixel of the next clock may be taken then.
    o : ``Out(ArrayLayout(signed(net), units))``
        Nets; in turn t that of neuron ``unit * share + t``. ``latency`` clocks after the pixel.
    """
    units = -(-hidden_neurons // share)
    return {
        "start": In(1), "active": In(1), "pixel": In(pixel_layout(formats, lanes)),
        "turn": In(bits_for(share - 1)), "advance": In(1), "ready": Out(1),
        "o": Out(data.ArrayLayout(signed(formats.net.width), units)),
    } | ({"writes": In(BANK_WRITES)} if in_memory else
         {"neurons": In(hidden_layout(hidden_neurons, formats))})


class MultiplyLayer(wiring.Component):
    """Hidden neurons with two multipliers per tan-sigmoid, for any order of the pixels.

    Parameters
    ----------
    hidden_neurons : int
        HN.
    formats : ncdc_spec.descriptor.Formats
    share : int
        Neurons that one multiply-accumulate pipeline computes in turn, their weights in memories
        if there are several.
    multiplier_bits : int
        Width of the multiplier blocks, 27 or 18.
    lanes : int
        Pixels of the scan's groups, one of which the layer takes.
    fixed : bool
        Whether ``neurons`` are constants, also with several turns: there are no memories.

    Members: :func:`hidden_layer_ports`; always ready.
    """

    def __init__(self, hidden_neurons, formats, share=1, multiplier_bits=27, lanes=1, fixed=False):
        self.hidden_neurons, self.share, self.fixed = hidden_neurons, share, fixed
        self.units = [HiddenNeuron(formats, multiplier_bits)
                      for _ in range(-(-hidden_neurons // share))]
        super().__init__(hidden_layer_ports(hidden_neurons, formats, share, lanes,
                                            share > 1 and not fixed))

    start_latency = 0
    """Clocks that a frame's first pixel waits for the layer."""

    @property
    def latency(self):
        """Clocks from a pixel's first turn to that turn's nets: 1 for routing to all units."""
        return 1 + self.units[0].latency

    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.ready.eq(1)
        inputs = register(m, "inputs", Cat(self.pixel.x, self.pixel.y))
        for k, unit in enumerate(self.units):
            m.submodules[f"unit{k}"] = unit
            m.d.comb += [unit.i.eq(inputs), self.o[k].eq(unit.o)]
            if self.share == 1:
                m.d.comb += [unit.weights.eq(self.neurons[k].weights),
                             unit.bias.eq(self.neurons[k].bias)]
        if self.share > 1:
            self._banks(m)
        return m

    def _banks(self, m):
        """Connect each unit to the words of its neuron, in the clocks in which it uses them."""
        unit = self.units[0]
        # One clock is for the inputs' routing to all units, one for the memory.
        of_weights = delay(m, self.turn, 1 + unit.weights_clock - WeightBanks.latency, "turn_w")
        of_bias = delay(m, of_weights, unit.bias_clock - unit.weights_clock, "turn_b")
        for k, unit in enumerate(self.units):
            words = [(unit.weights[0], of_weights), (unit.weights[1], of_weights),
                     (unit.bias, of_bias)]
            if self.fixed:
                own = [self.neurons[j] for j in served(k, self.hidden_neurons, self.share)]
                constants = ([n.weights[0] for n in own], [n.weights[1] for n in own],
                             [n.bias for n in own])
                for role, (word, turn) in enumerate(words):
                    m.d.comb += word.eq(_of_turn(m, turn, constants[role], f"word{k}_{role}"))
                continue
            for role, (word, turn) in enumerate(words):
                m.submodules[f"bank{k}_{role}"] = bank = WeightBanks(
                    word.shape(), unit=k, share=self.share, output=0, role=role)
                wiring.connect(m, wiring.flipped(self.writes), bank.writes)
                m.d.comb += [bank.turn.eq(turn), word.eq(bank.o)]


class OutputLayer(wiring.Component):
    """The two output neurons, over activations that arrive in ``share`` turns.

    Parameters
    ----------
    hidden_neurons : int
        HN.
    formats : ncdc_spec.descriptor.Formats
    share : int
        Turns; 2 ceil(HN / share) products. The weights are in memories if there are several.
    multiplier_bits : int
        Width of the multiplier blocks, 27 or 18.
    fixed : bool
        As of :class:`MultiplyLayer`.

    Members
    -------
    first : ``In(1)``
        High with the activations of turn 0; the others follow clock by clock.
    i : ``In(ArrayLayout(signed(tansig), units))``
        In turn t the activation of neuron ``unit * share + t``; any value if there is none.
    inputs : ``In(ArrayLayout(signed(input), 2))``
        x, y of the pixel, ``inputs_clock`` clocks after ``first`` (only with a skip path).
    neurons : ``In(output_layout(...))``
        Constant in a frame.
    writes : ``In(BANK_WRITES)``
        Writes to the memories of weights (only with several turns).
    o : ``Out(ArrayLayout(signed(coordinate), 2))``
        x', y'; ``latency`` clocks after ``first``.
    """

    def __init__(self, hidden_neurons, formats, share=1, multiplier_bits=27, fixed=False):
        self.hidden_neurons, self.share, self.fixed = hidden_neurons, share, fixed
        in_memory = share > 1 and not fixed
        self.units = -(-hidden_neurons // share)
        self.skip = formats.skip_weight is not None
        self.outputs = [OutputNeuron(self.units, formats, share, multiplier_bits) for _ in range(2)]
        super().__init__({
            "first": In(1),
            "i": In(data.ArrayLayout(signed(formats.tansig.width), self.units)),
            "neurons": In(output_layout(hidden_neurons, formats, in_memory)),
            "o": Out(data.ArrayLayout(signed(formats.coordinate.width), 2)),
        } | ({"writes": In(BANK_WRITES)} if in_memory else {}) | (
            {"inputs": In(data.ArrayLayout(signed(formats.input.width), 2))} if self.skip else {}))

    @property
    def inputs_clock(self):
        """Clocks from ``first`` to ``inputs``; may be negative."""
        return self.outputs[0].inputs_clock

    @property
    def latency(self):
        """Clocks from the first turn's activations to the coordinate."""
        return self.outputs[0].latency

    def elaborate(self, platform):
        m = Module()
        for k, output in enumerate(self.outputs):
            m.submodules[f"output{k}"] = output
            neuron = self.neurons[k]
            m.d.comb += [output.i.eq(self.i), output.bias.eq(neuron.bias),
                         self.o[k].eq(output.o)]
            if self.share == 1:
                m.d.comb += output.weights.eq(neuron.weights)
            if self.skip:
                m.d.comb += [output.inputs.eq(self.inputs), output.skip.eq(neuron.skip)]
        if self.share > 1:
            self._banks(m)
        return m

    def _banks(self, m):
        """Connect both neurons to the weights of each turn, a clock after its activations."""
        turn = Signal(range(self.share))                # turn of the activations
        before = register(m, "before", turn)
        m.d.comb += turn.eq(Mux(self.first, 0, before + 1))
        for k, output in enumerate(self.outputs):
            m.d.comb += output.first.eq(self.first)
            for unit in range(self.units):
                early = delay(m, turn, output.weights_clock - WeightBanks.latency,
                              f"turn{k}_{unit}")
                if self.fixed:
                    own = served(unit, self.hidden_neurons, self.share)
                    m.d.comb += output.weights[unit].eq(_of_turn(
                        m, early, [self.neurons[k].weights[j] for j in own], f"word{k}_{unit}"))
                    continue
                m.submodules[f"bank{k}_{unit}"] = bank = WeightBanks(
                    output.weights[unit].shape(), unit=unit, share=self.share, output=1, role=k)
                wiring.connect(m, wiring.flipped(self.writes), bank.writes)
                m.d.comb += [bank.turn.eq(early), output.weights[unit].eq(bank.o)]
