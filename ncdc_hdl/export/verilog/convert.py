"""An Amaranth component as Verilog-2005 text, every distinct module once."""

import gc
import inspect
import itertools
import re
from contextlib import contextmanager
from dataclasses import dataclass

from amaranth.back import rtlil
from amaranth.hdl import Elaboratable, Fragment
from amaranth.hdl._xfrm import TransformedElaboratable
from amaranth.lib import wiring

from ncdc_hdl.export.verilog.names import rename
from ncdc_hdl.export.verilog.printer import module_lines
from ncdc_hdl.export.verilog.rtlil import parse, part_of

__all__ = ["Netlist", "Part", "convert"]


@dataclass
class Part:
    """A module of the netlist on its way to Verilog.

    Parameters
    ----------
    module : Module
    component : object
        The Amaranth object that it is made from, or None.
    path : tuple of str
        Names of the instances down to it.
    ports, renamed : dict
        New ports and names by the old ones, see :func:`rename`.
    """
    module: object
    component: object
    path: tuple
    ports: dict
    renamed: dict


@contextmanager
def _rare_collection():
    """Let Python look for garbage after 100,000 new objects at the earliest, not after 700.

    A netlist is a million objects, nearly all in use: the searches take a quarter of the time.
    """
    before = gc.get_threshold()
    gc.set_threshold(max(before[0], 100_000), *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


class Netlist:
    """The modules of a component, renamed, with equal ones found.

    Parameters
    ----------
    component : amaranth.lib.wiring.Component
    name : str
        Name of the top module. A module below has this name and that of its class, and its
        instance's too if several modules are of one class.
    platform : object, optional
        As in :func:`convert`.

    Attributes
    ----------
    rtlil : str
        Output of Amaranth's converter.
    parts : dict
        :class:`Part` by the converter's name of the module, submodules before their users.
    same : dict
        For each of these names, the one that represents all equal modules.
    names : dict
        Verilog name of each module that is written, by the converter's.
    """

    def __init__(self, component, name, platform=None):
        with _rare_collection():
            self._convert(component, name, platform)

    def _convert(self, component, name, platform):
        fragment = Fragment.get(component, platform)
        components = _components(fragment, ())
        self.rtlil = rtlil.convert(_Elaborated(component, fragment), name=name, emit_src=False)
        self.parts = {}
        for module in reversed(parse(self.rtlil)):
            path = tuple(_instance(step) for step in module.name.split(".")[1:])
            self.parts[module.name] = Part(module, components.get(path), path, {}, {})
        self.same = _distinct(self.parts)
        self.names = _names({original: self.parts[original] for original in self.same.values()},
                            name)
        for original in self.names:
            for cell in self.parts[original].module.cells:
                if cell.kind in self.same:
                    cell.kind = self.names[self.same[cell.kind]]

    def written(self):
        """The converter's names of the modules that are written, the top first."""
        return [original for original in reversed(self.parts) if original in self.names]

    def lines(self, original, port_lines=None):
        """Verilog of one of :meth:`written`."""
        modules = {self.names[name]: self.parts[name].module for name in self.names}
        return module_lines(self.parts[original].module, modules,
                            lambda ports: (port_lines or _port_lines)(self.names[original], ports))

    def instances(self):
        """Number of uses of each module that is written, by its name."""
        counts = dict.fromkeys(self.names.values(), 0)
        modules = {self.names[name]: self.parts[name].module for name in self.names}

        def count(name):
            counts[name] += 1
            for cell in modules[name].cells:
                if cell.kind in modules:
                    count(cell.kind)
        count(self.names[self.written()[0]])
        return counts


def convert(component, name, header=(), port_lines=None, platform=None):
    """Verilog text of ``component`` as module ``name`` and of the modules below it.

    Equal modules are written once. Identical text for identical input.

    Parameters
    ----------
    component : amaranth.lib.wiring.Component
    name : str
    header : sequence of str
        Lines that open the file, without the slashes of comments.
    port_lines : callable, optional
        Lines of the top's port list, see :func:`ncdc_hdl.export.verilog.printer.module_lines`.
    platform : object, optional
        Amaranth's, whose synchronisers replace plain flip-flops.
    """
    netlist = Netlist(component, name, platform)
    counts, lines = netlist.instances(), [f"// {line}".rstrip() for line in header]
    for k, original in enumerate(netlist.written()):
        part = netlist.parts[original]
        about = [_about(part.component, counts[netlist.names[original]])] if k else []
        lines += ["", *about, *netlist.lines(original, None if k else port_lines)]
    return "\n".join(lines).lstrip("\n") + "\n"


class _Elaborated(Elaboratable):
    """A component that has been elaborated already, with its ports, for Amaranth's converter."""

    def __init__(self, component, fragment):
        self._component, self._fragment = component, fragment

    def __getattr__(self, name):
        return getattr(self._component, name)

    def elaborate(self, platform):
        return self._fragment


def _components(fragment, path):
    """The Amaranth object of each fragment, by the names of the instances down to it."""
    # A renamer of domains is replaced by the component in it.
    origin = next((o for o in fragment.origins or ()
                   if not isinstance(o, (Fragment, TransformedElaboratable))), None)
    found = {path: origin}
    for below, name, *_ in fragment.subfragments:
        if name is not None:
            found |= _components(below, (*path, name))
    return found


def _instance(step):
    """Name of an instance without the number that distinguishes it from a signal."""
    return re.sub(r"\$\d+$", "", step)


def _members(component):
    """Flattened names of a component's members."""
    if not isinstance(component, wiring.Component):
        return []
    return ["__".join(map(str, path)) for path, _, _ in component.signature.flatten(component)]


def _distinct(parts):
    """Rename the modules; for each, the first one that is equal to it."""
    same, first = {}, {}
    for original, part in parts.items():
        for cell in part.module.cells:
            cell.kind = cell.kind.removeprefix("\\")
            if cell.kind in parts:
                _reconnect(cell, parts[cell.kind].ports)
        ports, part.renamed = rename(part.module, _members(part.component))
        part.ports = {port.removeprefix("\\"): found for port, found in ports.items()}
        same[original] = first.setdefault(_key(part.module, same), original)
    return same


def _key(module, same):
    """A key that two modules share only if they are equal."""
    return repr((module.wires, module.memories, module.processes, module.connects,
                 [(same.get(cell.kind, cell.kind), cell.name, cell.parameters, cell.connections)
                  if not cell.kind.startswith("$") else
                  (cell.kind, cell.parameters, cell.connections) for cell in module.cells]))


def _reconnect(cell, ports):
    """Connect an instance to the ports that its module has by now."""
    connections = {}
    for port, parts in cell.connections.items():
        for new, low, width in ports[port]:
            connections[new] = parts if width is None else part_of(parts, low, width)
    cell.connections = connections


def _names(parts, top):
    """A name for each distinct module: its class, with as much of its path as is needed."""
    names = {}
    for original, part in parts.items():
        names[original] = top if not part.path else f"{top}_{_kind(part)}"
    # Numbers in the path come last in names: instances have them too.
    for numbers, length in itertools.product(("0123456789_", ""), range(1, 9)):
        same = {}
        for original, name in names.items():
            same.setdefault(name, []).append(original)
        clashes = [originals for originals in same.values() if len(originals) > 1]
        if not clashes:
            return names
        for original in sum(clashes, []):
            part = parts[original]
            kind = _kind(part)
            path = [step.rstrip(numbers) for step in part.path]
            path = path[:-1] if path[-1] == kind else path
            names[original] = "_".join([top, kind, *path[-length:]])
    raise ValueError(f"the modules {clashes} cannot be distinguished")


def _kind(part):
    """Class of a module's component, in lower case."""
    component = part.component
    kind = type(component).__name__ if component is not None else part.path[-1]
    if kind == "Module":
        kind = part.path[-1]
    kind = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", kind)
    return kind.lower().strip("_")


def _about(component, count):
    """A comment on a module: its source file, purpose, latency, number of instances."""
    if component is None:
        return "// made by Amaranth"
    source = type(component).__module__.replace(".", "/") + ".py"
    text = (inspect.getdoc(type(component)) or "").partition("\n\n")[0].replace("\n", " ")
    text = re.sub(r":\w+:`~?\.?([^`]*)`", r"\1", text).replace("``", "").replace("\\|", "|")
    text = re.split(r"(?<!Fig)(?<!Figs)\. |::", text)[0].rstrip(":.")
    latency = getattr(component, "latency", None)
    line = f"// {source}: {text}"
    line += f"; latency {latency}" if isinstance(latency, int) else ""
    return line + (f"; {count} instances" if count > 1 else "")


def _port_lines(head, ports):
    """A port list, one port per line."""
    lines = [f"module {head} ("]
    for k, (name, wire, kind, initial) in enumerate(ports):
        width = f"[{wire.width - 1}:0] " if wire.width > 1 else ""
        end = "," if k < len(ports) - 1 else ""
        lines.append(f"  {wire.port:<6} {kind:<4} {width}{name}{initial}{end}")
    return [*lines, ");"]
