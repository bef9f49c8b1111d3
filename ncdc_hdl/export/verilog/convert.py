"""An Amaranth component as Verilog-2005 text, every distinct module once."""

import inspect
import re
from dataclasses import dataclass

from amaranth.back import rtlil
from amaranth.hdl import Elaboratable, Fragment
from amaranth.lib import wiring

from ncdc_hdl.export.verilog.names import rename
from ncdc_hdl.export.verilog.printer import module_lines
from ncdc_hdl.export.verilog.rtlil import parse, part_of

__all__ = ["convert"]


@dataclass
class _Part:
    """A module of the netlist on its way to Verilog.

    ``component``: the Amaranth object that it is made from, or None; ``path``: names of the
    instances down to it; ``ports``: what became of each port, see :func:`rename`.
    """
    module: object
    component: object
    path: tuple
    ports: dict


def convert(component, name, header=(), port_lines=None):
    """Verilog text of ``component`` as module ``name`` and of the modules below it.

    Equal modules are written once. A module below is called by ``name`` and the class it is made
    from, and by its instance too where several modules are of one class. Identical text for identical
    input.

    Parameters
    ----------
    component : amaranth.lib.wiring.Component
    name : str
    header : sequence of str
        Lines that open the file, without the slashes of comments.
    port_lines : callable, optional
        Lines of the top's port list, see :func:`ncdc_hdl.export.verilog.printer.module_lines`.
    """
    fragment = Fragment.get(component, None)
    components = _components(fragment, ())
    text = rtlil.convert(_Elaborated(component, fragment), name=name, emit_src=False)
    parts = {}
    for module in reversed(parse(text)):            # what is below comes first
        path = tuple(_instance(step) for step in module.name.split(".")[1:])
        parts[module.name] = _Part(module, components.get(path), path, {})
    texts, users = _distinct(parts)
    names = _names({original: parts[original] for original in texts.values()}, name)
    order = [original for original in reversed(parts) if original in texts.values()]
    lines = [f"// {line}".rstrip() for line in header]
    for original in order:
        part = parts[original]
        children = {names[texts[kind]]: parts[texts[kind]].module
                    for kind in _children(part.module, texts)}
        for cell in part.module.cells:
            if cell.kind in texts:
                cell.kind = names[texts[cell.kind]]
        top = original == order[0]
        writer = port_lines if top and port_lines else _port_lines
        lines += ["", *_about(part.component, users[original], top)]
        lines += module_lines(part.module, children, lambda ports, head=names[original],
                              write=writer: write(head, ports))
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
    origin = next((o for o in fragment.origins or () if not isinstance(o, Fragment)), None)
    found = {path: origin}
    for below, name, *_ in fragment.subfragments:
        if name is not None:
            found |= _components(below, (*path, name))
    return found


def _instance(step):
    """Name of an instance without the number by which the converter tells it from a signal."""
    return re.sub(r"\$\d+$", "", step)


def _members(component):
    """Flattened names of a component's members."""
    if not isinstance(component, wiring.Component):
        return []
    return ["__".join(map(str, path)) for path, _, _ in component.signature.flatten(component)]


def _children(module, kinds):
    return [cell.kind for cell in module.cells if cell.kind in kinds]


def _distinct(parts):
    """Of each module the first one, from the top, that is equal to it; how often each is used."""
    texts, first = {}, {}
    for original, part in parts.items():
        for cell in part.module.cells:
            cell.kind = cell.kind.removeprefix("\\")
            if cell.kind in parts:
                _reconnect(cell, parts[cell.kind].ports)
        part.ports = {port.removeprefix("\\"): found
                      for port, found in rename(part.module, _members(part.component)).items()}
        key = _key(part.module, texts)
        # What is read later is nearer to the top of the file.
        texts[original] = first.setdefault(key, original)
    users = dict.fromkeys(texts.values(), 0)
    top = list(parts)[-1]

    def count(original, times):
        users[original] += times
        for kind in _children(parts[original].module, texts):
            count(texts[kind], times)
    count(top, 1)
    return texts, users


def _key(module, texts):
    """What is the same of two modules only if they are equal."""
    return repr((module.wires, module.memories, module.processes, module.connects,
                 [(texts.get(cell.kind, cell.kind), cell.name, cell.parameters, cell.connections)
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
    """A name for each distinct module: of its class, with as much of its path as tells it apart."""
    names = {}
    for original, part in parts.items():
        names[original] = top if not part.path else f"{top}_{_kind(part)}"
    for length in range(1, 9):
        same = {}
        for original, name in names.items():
            same.setdefault(name, []).append(original)
        clashes = [originals for originals in same.values() if len(originals) > 1]
        if not clashes:
            return names
        for original in sum(clashes, []):
            part = parts[original]
            kind = _kind(part)
            path = [step.rstrip("0123456789_") for step in part.path]
            path = path[:-1] if path[-1] == kind else path
            names[original] = "_".join([top, kind, *path[-length:]])
    raise ValueError(f"the modules {clashes} cannot be told apart")


def _kind(part):
    """The class of what a module is made from, in small letters."""
    component = part.component
    kind = type(component).__name__ if component is not None else part.path[-1]
    if kind == "Module":
        kind = part.path[-1]
    kind = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", kind)
    return kind.lower().strip("_")


def _about(component, count, top):
    """One comment line on a module: its source file, what it is, its latency, how many there are."""
    if component is None or top:
        return []
    place = type(component).__module__.replace(".", "/") + ".py"
    text = (inspect.getdoc(type(component)) or "").partition("\n\n")[0].replace("\n", " ")
    text = re.sub(r":\w+:`~?\.?([^`]*)`", r"\1", text).replace("``", "").replace("\\|", "|")
    text = text.rstrip(":.")
    latency = getattr(component, "latency", None)
    line = f"// {place}: {text}"
    line += f"; latency {latency}" if isinstance(latency, int) else ""
    line += f"; {count} instances" if count > 1 else ""
    return [line]


def _port_lines(head, ports):
    """A port list, one port per line."""
    lines = [f"module {head} ("]
    for k, (name, wire, kind, initial) in enumerate(ports):
        width = f"[{wire.width - 1}:0] " if wire.width > 1 else ""
        end = "," if k < len(ports) - 1 else ""
        lines.append(f"  {wire.port:<6} {kind:<4} {width}{name}{initial}{end}")
    return [*lines, ");"]
