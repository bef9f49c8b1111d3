"""A component's Verilog with inputs from a file, and a consumer of its stream that stalls."""

from amaranth import Shape, Value
from amaranth.lib.wiring import In

from ncdc_sim.runner import build_bench, command_of
from ncdc_sim.tools import SimulationError
from ncdc_sim.transcript import transcribed
from simulations import HDL

__all__ = ["Player"]


class Player:
    """Inputs of a component with a stream ``o`` and a flag ``quiet``, clock by clock.

    Parameters
    ----------
    component : wiring.Component
        Its Verilog has the module ``dut``. Inputs of layouts are set by their constants.
    void : (str, int, sequence of str)
        Name of a field of the items, and a value of it with which the named other fields mean
        nothing; they are shown as 0.
    """
    def __init__(self, component, void):
        self._shapes, self._flags, self._lines = {}, [], []
        for path, member, port in component.signature.flatten(component):
            name = "__".join(map(str, path))
            if name == "o__payload":
                self._item = member.shape
            elif member.flow is In and name != "o__ready":
                self._shapes[name] = member.shape
            elif not name.startswith("o__"):
                self._flags.append((name, len(Value.cast(port))))
        self._values = dict.fromkeys(self._shapes, 0)
        name, value, fields = void
        mask = sum((1 << Shape.cast(self._item[one].shape).width) - 1 << self._item[one].offset
                   for one in fields)
        self._shown = (f"payload[{self._item[name].offset}] == {value} ? "
                       f"payload & ~{self._item.size}'h{mask:x} : payload")

    def _bits(self, name):
        return Shape.cast(self._shapes[name]).width

    def put(self, clocks=1, until_quiet=False, **values):
        """Set inputs for so many clocks, and longer until ``quiet`` if ``until_quiet``."""
        for name, value in values.items():
            shape = self._shapes[name]
            self._values[name] = (shape.const(value).as_bits() if hasattr(shape, "members")
                                  else value & (1 << self._bits(name)) - 1)
        word, at = 0, 0
        for name, value in self._values.items():
            word |= value << at
            at += self._bits(name)
        self._lines.append(f"{word:x} {clocks:x} {int(until_quiet):x}")

    def play(self, verilog, transcripts=None, **plusargs):
        """Run the component's ``verilog``; the items of ``o``, as constants of its layout.

        ``transcripts``: a list to which the run's transcript is added.

        Raises
        ------
        SimulationError
            If it does not compile, or the run does not end.
        """
        at, connections = 0, []
        for name in self._shapes:
            connections.append(f".{name}(in[{at + self._bits(name) - 1}:{at}])")
            at += self._bits(name)
        inputs, at = at, 0
        for name, bits in self._flags:
            if name == "quiet":
                quiet = at
            connections.append(f".{name}(flags[{at + bits - 1}:{at}])")
            at += bits
        bench = (HDL / "player_bench.v").read_text()
        header = "".join(f"`define NCDC_{name} {value}\n" for name, value in (
            ("INPUTS", inputs), ("PAYLOAD", self._item.size), ("FLAGS", at), ("QUIET", quiet),
            ("SHOWN", self._shown), ("CONNECTIONS", ", ".join(connections))))
        program = build_bench("player", "player_bench", [("dut.v", verilog),
                                                         ("player_bench.v", header + bench)])
        files = {"inputs.txt": "\n".join([*self._lines, "0 0 0", ""]).encode()}
        items = []

        def hear(line):
            kind, *words = line.split() or [""]
            if kind == "OUT":
                items.append(self._item.from_bits(int(words[1], 16)))
            elif kind == "FAILED":
                raise SimulationError(f"simulation failed: {line}")

        command = [*command_of(program), *(f"+{name}={value}" for name, value in plusargs.items())]
        transcribed(command, hear, transcripts, files=files)
        return items

