"""Components in Amaranth's simulator, recorded clock by clock, and their Verilog with the same
inputs: one bench for many of them."""

from functools import cached_property

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.ports import forward
from ncdc_sim.runner import build_bench, command_of
from ncdc_sim.tools import SimulationError
from ncdc_sim.transcript import transcribed
from pipelines import watched
from simulations import HDL

__all__ = ["Alone", "Recorded", "Units", "replay", "trace"]


class Units(wiring.Component):
    """Components next to each other, all their ports outside as ``<name>__<port>``.

    Parameters
    ----------
    units : dict
        Components by name.
    """
    def __init__(self, units):
        self.units = units
        super().__init__({name: Out(unit.signature) for name, unit in units.items()})

    def elaborate(self, platform):
        m = Module()
        for name, unit in self.units.items():
            m.submodules[name] = unit
            forward(m, unit.signature, getattr(self, name), unit)
        return m


class Alone(wiring.Component):
    """A component whose clock domain has a reset of its own, as the member ``reset``.

    Parameters
    ----------
    part : wiring.Component
    domain : str
        Name of its clock domain. Equal modules of several components need the same name.
    means : dict
        For names of outputs, a function of ``part``. It returns the condition with which the output
        means something, or a mask of its bits that do; others are 0. Parts of a name are joined
        by ``__``.
    name : str
        Of the part's instance.
    other : str, optional
        Another clock domain of the part.
    reset_less : bool
        Whether that domain has no reset.

    Members
    -------
    Those of ``part``, and ``reset``. With another domain its ``clock``, and ``other_reset``
    unless it has none.
    """
    def __init__(self, part, domain="part", means=None, *, name="part", other=None,
                 reset_less=False):
        self.part, self.domain, self.means = part, domain, means or {}
        self.name, self.other, self.reset_less = name, other, reset_less
        self.latency = getattr(part, "latency", None)
        members = {} if other is None else {"clock": In(1)}
        members |= {} if other is None or reset_less else {"other_reset": In(1)}
        super().__init__({**part.signature.members, **members, "reset": In(1)})

    def elaborate(self, platform):
        m = Module()
        setattr(m.domains, self.domain, ClockDomain(self.domain, local=True))
        m.d.comb += [ClockSignal(self.domain).eq(ClockSignal()),
                     ResetSignal(self.domain).eq(self.reset)]
        if self.other is not None:
            setattr(m.domains, self.other, ClockDomain(self.other, local=True,
                                                       reset_less=self.reset_less))
            m.d.comb += ClockSignal(self.other).eq(self.clock)
            if not self.reset_less:
                m.d.comb += ResetSignal(self.other).eq(self.other_reset)
        m.submodules[self.name] = DomainRenamer(self.domain)(self.part)
        signature, unused = self.part.signature, set(self.means)
        for (path, member, ours), (_, _, theirs) in zip(signature.flatten(self),
                                                        signature.flatten(self.part)):
            name, ours, theirs = "__".join(map(str, path)), Value.cast(ours), Value.cast(theirs)
            if member.flow is In:
                m.d.comb += theirs.eq(ours)
            elif name in self.means:
                unused.discard(name)
                mask = self.means[name](self.part)
                m.d.comb += ours.eq(theirs & (mask.replicate(len(ours)) if len(mask) == 1
                                              else mask))
            else:
                m.d.comb += ours.eq(theirs)
        if unused:
            raise ValueError(f"{type(self.part).__name__} has no output {', '.join(unused)}")
        return m


class _Ports:
    """Ports of a component as one number of its inputs and one of its outputs.

    An output ``payload`` means something only while ``valid`` next to it is high.
    """
    def __init__(self, component, prefix=""):
        self.inputs, self.outputs = [], []      # (name, Value)
        for path, member, port in component.signature.flatten(component):
            ports = self.inputs if member.flow is In else self.outputs
            ports.append(("__".join(map(str, (prefix, *path) if prefix else path)),
                          Value.cast(port)))

    def connections(self):
        """The ports' connections in Verilog, to the vectors ``in`` and ``out``."""
        for vector, ports in (("in", self.inputs), ("out", self.outputs)):
            at = 0
            for name, port in ports:
                yield f".{name}({vector}[{at + len(port) - 1}:{at}])"
                at += len(port)

    @cached_property
    def _guarded(self):
        """(mask of a payload, number of the bit that says whether it is valid)."""
        at, places = 0, {}
        for name, port in self.outputs:
            places[name] = at, len(port)
            at += len(port)
        return [((1 << bits) - 1 << at, places[valid][0])
                for name, (at, bits) in places.items()
                if name.endswith("payload") and (valid := f"{name[:-7]}valid") in places]

    def meaning(self, outputs):
        """Mask of the bits of ``outputs`` that mean something."""
        mask = (1 << sum(len(port) for _, port in self.outputs)) - 1
        for payload, valid in self._guarded:
            if not outputs >> valid & 1:
                mask &= ~payload
        return mask


def trace(component, check):
    """[(inputs, outputs)] of each clock of the simulation that ``check(component)`` runs."""
    ports, rows = _Ports(component), []
    inputs, outputs = (Cat(port for _, port in each) for each in (ports.inputs, ports.outputs))

    async def watch(ctx):
        async for _, _, *row in ctx.tick().sample(inputs, outputs):
            rows.append(tuple(row))

    with watched(watch):
        check(component)
    return rows


def _table(units, traces):
    """The bench's file: inputs, outputs and their mask, of all units, as numbers of whole bytes.

    A trace that ends before the others goes on with its last inputs, and nothing is compared.
    """
    ports = [_Ports(unit) for unit in units.values()]
    widths = [[sum(len(port) for _, port in each) for each in (one.inputs, one.outputs)]
              for one in ports]
    sizes = [-(-sum(one) // 8) for one in zip(*widths)]
    for clock in range(max(map(len, traces.values()))):
        vectors, at = [0, 0, 0], [0, 0]
        for one, (into, out), rows in zip(ports, widths, traces.values()):
            inputs, outputs = rows[min(clock, len(rows) - 1)]
            mask = one.meaning(outputs) if clock < len(rows) else 0
            for k, (value, place) in enumerate(((inputs, at[0]), (outputs, at[1]), (mask, at[1]))):
                vectors[k] |= value << place
            at = [at[0] + into, at[1] + out]
        yield b"".join(value.to_bytes(size, "big") for value, size in zip(
            vectors, (sizes[0], sizes[1], sizes[1])))


def replay(units, traces, verilog, transcripts, top="units"):
    """Run the Verilog of :class:`Units` with the inputs of all traces at once.

    Parameters
    ----------
    units : dict
        Components by name.
    traces : dict
        :func:`trace` of each of them.
    verilog : str
    transcripts : list
        The run's transcript is added to it.
    top : str
        Name of their module.

    Raises
    ------
    SimulationError
        If an output that means something is not that of the trace, in its clock.
    """
    ports = _Ports(Units(units))
    files = {"trace.bin": b"".join(_table(units, traces))}
    header = "".join(f"`define NCDC_{name} {value}\n" for name, value in (
        ("INPUTS", sum(len(port) for _, port in ports.inputs)),
        ("OUTPUTS", sum(len(port) for _, port in ports.outputs)),
        ("TOP", top), ("CONNECTIONS", ", ".join(ports.connections()))))
    bench = header + (HDL / "trace_bench.v").read_text()
    program = build_bench("trace", "trace_bench", [("units.v", verilog),
                                                   ("trace_bench.v", bench)])

    def hear(line):
        if line.startswith("FAILED"):
            raise SimulationError(line)

    transcribed(command_of(program), hear, transcripts, files=files)


class Recorded:
    """A design of parts with their checks, recorded once and replayed in Verilog.

    Parameters
    ----------
    units : callable
        Gives new parts, and the check of each: ``{name: (part, check)}``.
    top : str
        Name of their module.
    """
    def __init__(self, units, top):
        self.units, self.top = units, top

    def make(self):
        """All parts next to each other."""
        return Units({name: part for name, (part, _) in self.units().items()})

    @cached_property
    def traces(self):
        """What each check gives its part, and what comes out."""
        return {name: trace(part, check) for name, (part, check) in self.units().items()}

    def parts(self, verilog, transcripts):
        """Run all parts with the inputs of their checks."""
        parts = {name: part for name, (part, _) in self.units().items()}
        replay(parts, self.traces, verilog, transcripts, top=self.top)
