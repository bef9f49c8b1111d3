"""Names of a netlist for readers: plain identifiers, ports by signature."""

import re

from ncdc_hdl.export.verilog.rtlil import Slice, Switch, Wire
from ncdc_spec.errors import InputError

__all__ = ["check_module_name", "identifier", "rename"]

# Reserved by Verilog-2005, and those of SystemVerilog that could be signals, as tools may read
# a file as such; a signal of such a name gets an underscore.
_RESERVED = frozenset("""
    always and assign automatic begin buf bufif0 bufif1 case casex casez cell cmos config deassign
    default defparam design disable edge else end endcase endconfig endfunction endgenerate
    endmodule endprimitive endspecify endtable endtask event for force forever fork function
    generate genvar highz0 highz1 if ifnone incdir include initial inout input instance integer join
    large liblist library localparam macromodule medium module nand negedge nmos nor
    noshowcancelled not notif0 notif1 or output parameter pmos posedge primitive pull0 pull1
    pulldown pullup pulsestyle_ondetect pulsestyle_onevent rcmos real realtime reg release repeat
    rnmos rpmos rtran rtranif0 rtranif1 scalared showcancelled signed small specify specparam
    strong0 strong1 supply0 supply1 table task time tran tranif0 tranif1 tri tri0 tri1 triand trior
    trireg unsigned use uwire vectored wait wand weak0 weak1 while wire wor xnor xor
    accept_on alias assert assume before bind bins bit break byte chandle checker class clocking
    const constraint context continue cover cross dist do endclass enum eventually expect export
    extends extern final first_match foreach forkjoin global iff implies import inside int
    interface intersect join_any let local logic longint matches modport new nexttime null package
    packed priority program property protected pure rand randc ref reject_on restrict return
    sequence shortint shortreal soft solve static string strong struct super tagged this
    throughout timeprecision timeunit type typedef union unique until untyped var virtual void
    wait_order weak wildcard with within""".split())
_LONGEST = 64           # most characters of a module's name, a prefix of those below it
_CLOCKS = {"\\clk": 0, "\\rst": 1}


def identifier(name):
    """``name``, an RTLIL identifier, as a plain Verilog one, without its distinguishing number.
    """
    name = re.sub(r"\$\d+", "", name.lstrip("\\"))
    name = re.sub(r"\W+", "_", name.replace("$", "_")).strip("_") or "t"
    if name[0].isdigit():
        name = "t" + name
    return name + "_" if name in _RESERVED else name


def check_module_name(name):
    """Return ``name``, or raise :class:`InputError` unless it can name a Verilog module and its
    file."""
    if not re.fullmatch("[A-Za-z][A-Za-z0-9_]*", name):
        raise InputError(f"the name is {name!r}, a letter is needed and then letters, digits and "
                         f"underscores")
    if len(name) > _LONGEST:
        raise InputError(f"the name has {len(name)} characters, the limit is {_LONGEST}")
    if name.lower() in _RESERVED:
        raise InputError(f"the name is {name!r}, a word of Verilog")
    return name


def rename(module, members):
    """Give the wires of a ``module`` their names in Verilog, in place.

    Wires that are the same net become one. Its name is that in the component's signature,
    if it is a port; else a name in the source rather than one made by the converter. A
    port that carries several of the component's inputs becomes one port for each.

    Parameters
    ----------
    module : Module
    members : list of str
        Flattened members of the component's signature, as in ``i__payload``; empty if unknown.

    Returns
    -------
    dict
        For each old port, its parts as (port, low, width), the lowest first; a width of None
        means the whole port.
    dict
        New names of wires, memories and instances by their old ones.
    """
    before = [name for name, wire in module.wires.items() if wire.port]
    joined, drivers = _join_same(module, members)
    cut = _split_ports(module, members)
    names, instances, ordered = _plain_names(module, members)
    for name in ordered:
        module.wires[name].made = name.startswith("$")
    memories = {name: names[name] for name in module.memories}
    for cell in module.cells:
        if "MEMID" in cell.parameters:
            memory = cell.parameters["MEMID"].strip('"').lstrip("\\")
            cell.parameters["MEMID"] = names[f"\\{memory}"]
        cell.name = instances.get(cell.name, cell.name)
    module.memories = {names[name]: memory for name, memory in module.memories.items()}
    module.wires = {names[name]: module.wires[name] for name in ordered}
    _substitute(module, {old: (new, 0) for old, new in names.items()})
    ports = {old: [(names[part], low, width) for part, low, width in cut.get(
        joined[old], [(joined[old], 0, None)])] for old in before}
    return ports, instances | memories | {old: names[best] for old, best in drivers.items()
                                          if best in names}


def _plain_names(module, members):
    """New names of wires and memories, and of instances, by their old ones; the wires in order:
    ports first, clock and reset before the members of the signature."""
    taken, counts, names, instances = set(), {}, {}, {}

    def free(base, separator="_"):
        count = counts.get((base, separator), 1)     # names with a lower number are taken
        new = base if separator and count == 1 else f"{base}{separator}{count}"
        while new in taken:
            count += 1
            new = f"{base}{separator}{count}"
        taken.add(new)
        counts[base, separator] = count
        return new

    def order(name):
        plain = identifier(name)
        return (not module.wires[name].port, _CLOCKS.get(name, len(_CLOCKS)),
                members.index(plain) if plain in members else len(members))

    ordered = sorted(module.wires, key=order)
    for name in ordered:
        names[name] = free("t", "") if name.startswith("$") else free(identifier(name))
    for name in module.memories:
        names[name] = free(identifier(name))
    for cell in module.cells:
        if not cell.kind.startswith("$"):
            instances[cell.name] = free(identifier(cell.name))
    return names, instances, ordered


def _substitute(module, targets):
    """Replace wires by bits of others: {old: (new, lowest bit)}."""
    def signal(parts):
        return [Slice(targets[part.wire][0], targets[part.wire][1] + part.low, part.width)
                if isinstance(part, Slice) and part.wire in targets else part for part in parts]
    _map_signals(module, signal)


def _map_signals(module, signal):
    """Apply ``signal`` to every signal of a module."""
    def statements(found):
        return [Switch(signal(item.value), [(pattern, statements(inner))
                                            for pattern, inner in item.cases])
                if isinstance(item, Switch) else (signal(item[0]), signal(item[1]))
                for item in found]
    for cell in module.cells:
        cell.connections = {port: signal(parts) for port, parts in cell.connections.items()}
    module.processes = [statements(process) for process in module.processes]
    module.connects = [(signal(target), signal(source)) for target, source in module.connects]


def _whole(module, parts):
    """The wire that ``parts`` cover completely; None if there is none."""
    if len(parts) == 1 and isinstance(parts[0], Slice) and parts[0].low == 0:
        name = parts[0].wire
        return name if parts[0].width == module.wires[name].width else None
    return None


def _join_same(module, members):
    """Merge wires that a ``connect`` makes the same net; return new names by old ones, and
    the same for driven ones only."""
    same = {}

    def root(name):
        while name in same:
            name = same[name]
        return name

    remaining = []
    for target, source in module.connects:
        a, b = _whole(module, target), _whole(module, source)
        if a and b and not module.wires[a].port and root(a) != root(b):
            same[root(a)] = root(b)
        else:
            remaining.append((target, source))
    module.connects = remaining
    groups = {}
    for name in module.wires:
        groups.setdefault(root(name), []).append(name)
    targets, wires, drivers = {}, {}, {}
    for driver, names in groups.items():
        wire = module.wires[driver]
        best = min(names, key=lambda name: _rank(name, wire.port, members))
        drivers[driver] = best
        for name in names:
            targets[name] = (best, 0)
        # The order is that of the driver, not of the best name.
        wires[best] = wire
        for name in names:
            wire.attributes |= module.wires[name].attributes
    module.wires = wires
    _substitute(module, targets)
    return {name: best for name, (best, _) in targets.items()}, drivers


def _rank(name, port, members):
    """Rank of a name, the lowest for the best."""
    plain = identifier(name)
    # The converter distinguishes equal names by a number; the member has none.
    return (name.startswith("$"), "$signature" in name or name.startswith("\\port$"),
            bool(port) and name.lstrip("\\") not in members,
            bool(port) and plain not in members, len(plain), name)


def _split_ports(module, members):
    """Cut an input that the converter combined into the members that are its bits."""
    aliases = {}
    for target, source in module.connects:
        name = _whole(module, target)
        if (name and len(source) == 1 and isinstance(source[0], Slice)
                and not module.wires[name].port):
            aliases.setdefault(source[0].wire, []).append((source[0].low, source[0].width, name))
    found = {}
    for name, wire in list(module.wires.items()):
        if wire.port != "input" or not name.startswith("\\port$"):
            continue
        parts = _cover(wire.width, [alias for alias in aliases.get(name, [])
                                    if not members or identifier(alias[2]) in members])
        if parts is None:
            parts = _cover(wire.width, aliases.get(name, []))
        if parts is None:
            continue
        found[name] = [(part, low, width) for low, width, part in parts]
        _cut(module, name, parts)
    return found


def _cover(width, aliases):
    """The longest of ``aliases`` (low, width, name) that are adjacent and cover all bits; None if
    there are none."""
    parts, at = [], 0
    while at < width:
        here = [alias for alias in aliases if alias[0] == at]
        if not here:
            return None
        parts.append(max(here, key=lambda alias: (alias[1], -len(alias[2]))))
        at += parts[-1][1]
    return parts


def _cut(module, name, parts):
    """Replace the input ``name`` by inputs for its ``parts``."""
    own = {part for _, _, part in parts}
    module.connects = [(target, source) for target, source in module.connects
                       if _whole(module, target) not in own]
    wires = {}
    for old, wire in module.wires.items():
        if old == name:
            wires |= {part: Wire(width, "input") for _, width, part in parts}
        elif old not in own:
            wires[old] = wire
    module.wires = wires

    def signal(signal_parts):
        found = []
        for part in signal_parts:
            if not isinstance(part, Slice) or part.wire != name:
                found.append(part)
                continue
            end = part.low + part.width
            found += [Slice(new, max(part.low, low) - low,
                            min(end, low + width) - max(part.low, low))
                      for low, width, new in parts if low < end and part.low < low + width]
        return found
    _map_signals(module, signal)
