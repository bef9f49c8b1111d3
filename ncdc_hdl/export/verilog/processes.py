"""Processes of a netlist: registers under a clock, and choices as conditional expressions."""

from ncdc_hdl.export.verilog.expressions import constant, slice_text
from ncdc_hdl.export.verilog.rtlil import Bits, Slice, Switch, part_of

__all__ = ["clocked_lines", "comb_expression", "targets_of"]


def targets_of(statements):
    """Wires that a process drives."""
    found = {}
    for item in statements:
        if isinstance(item, Switch):
            for _, inner in item.cases:
                found |= dict.fromkeys(targets_of(inner))
        else:
            found |= dict.fromkeys(part.wire for part in item[0])
    return list(found)


def clocked_lines(module, write, plain, held):
    """Statements of registers that share a clock.

    Parameters
    ----------
    module : Module
    write : Expressions
    plain : list of (str, signal)
        Registers, and their next value in every clock.
    held : list of (str, str, statements)
        Registers, the net of their next value, and the process that drives it.
    """
    lines = [f"    {name} <= {write.whole(parts, module.wires[name].width)};"
             for name, parts in plain]
    groups, resets = {}, {}
    for name, net, process in held:
        own = _of_register(process, name, net)
        if own and isinstance(own[-1], Switch) and _is_reset(own[-1]):
            resets.setdefault(tuple(own[-1].value), []).append(own.pop().cases[0][1])
        groups.setdefault(_skeleton(own), []).append(own)
    for processes in groups.values():
        lines += _statements(module, write, _together(processes), "    ")
    # The last assignment wins, so that the reset can be at the end.
    for value, statements in resets.items():
        lines += _statements(module, write, [Switch(list(value), [("1", sum(statements, []))])],
                             "    ")
    return lines


def _is_reset(switch):
    """Whether a choice is a reset: one case of constants."""
    return [pattern for pattern, _ in switch.cases] == ["1"] and all(
        not isinstance(item, Switch) and all(isinstance(part, Bits) for part in item[1])
        for item in switch.cases[0][1])


def _of_register(statements, name, net, first=True):
    """Statements on the ``net`` of a next value, as statements on the register ``name``.

    The ``first`` assignment, which holds the register's value, is dropped.
    """
    found = []
    for item in statements:
        if isinstance(item, Switch):
            cases = [(pattern, _of_register(inner, name, net, False))
                     for pattern, inner in item.cases]
            if any(inner for _, inner in cases):
                found.append(Switch(item.value, cases))
        else:
            target, source = item
            parts = [Slice(name, part.low, part.width) for part in target if part.wire == net]
            if parts and not (first and not found and list(source) == parts):
                found.append((parts, source))
    return found


def _skeleton(statements):
    """The choices of a process without the assignments."""
    return tuple((tuple(item.value), tuple((pattern, _skeleton(inner))
                                           for pattern, inner in item.cases))
                 for item in statements if isinstance(item, Switch))


def _together(processes):
    """Merge processes with the same choices; assignments before a choice stay before it."""
    found = []
    for slots in zip(*map(_slots, processes)):
        if isinstance(slots[0], Switch):
            found.append(Switch(slots[0].value, [
                (pattern, _together([switch.cases[j][1] for switch in slots]))
                for j, (pattern, _) in enumerate(slots[0].cases)]))
        else:
            found += sum(slots, [])
    return found


def _slots(statements):
    """Assignments before the first choice, that choice, assignments before the second one ..."""
    found = [[]]
    for item in statements:
        if isinstance(item, Switch):
            found += [item, []]
        else:
            found[-1].append(item)
    return found


def _statements(module, write, statements, indent):
    lines = []
    for item in statements:
        if isinstance(item, Switch):
            lines += _choice(module, write, item, indent)
        else:
            lines += _assignments(module, write, item, indent)
    return lines


def _assignments(module, write, item, indent):
    target, source = item
    lines, at = [], 0
    for part in target:
        value = write.whole(part_of(source, at, part.width), part.width)
        lines.append(f"{indent}{slice_text(module, part)} <= {value};")
        at += part.width
    return lines


def _choice(module, write, switch, indent):
    """A chain of conditions, or a case statement where all patterns are numbers."""
    cases = switch.cases
    while cases and not cases[-1][1]:
        cases = cases[:-1]
    if not cases:
        return []
    if cases[0][0] is None:
        return _statements(module, write, cases[0][1], indent)
    if len(cases) > 2 and len(cases[0][0]) > 1 and not any("-" in (pattern or "")
                                                            for pattern, _ in cases):
        return _case(module, write, switch.value, cases, indent)
    lines = []
    for k, (pattern, inner) in enumerate(cases):
        head = "else" if pattern is None else \
            f"{'else ' if k else ''}if ({_condition(write, switch.value, pattern)})"
        lines += _block(head, _statements(module, write, inner, indent + "  "), indent)
    return lines


def _case(module, write, value, cases, indent):
    """A case statement; an empty case is left out if there is no default."""
    lines = [f"{indent}case ({write.condition(value)})"]
    rest = any(pattern is None for pattern, _ in cases)
    for pattern, inner in cases:
        if inner or rest:
            head = "default:" if pattern is None else f"{constant(pattern)}:"
            body = _statements(module, write, inner, indent + "    ")
            lines += _block(head, body, indent + "  ") if body else [f"{indent}  {head} ;"]
    return [*lines, f"{indent}endcase"]


def _block(head, body, indent):
    """Statements of a condition: one assignment in its line, else a block."""
    line = f"{indent}{head} {body[0].strip()}" if len(body) == 1 else ""
    if line and len(line) <= 98 and not body[0].lstrip().startswith("if "):
        return [line]
    return [f"{indent}{head} begin", *body, f"{indent}end"]


def _condition(write, value, pattern):
    """Whether a signal has a pattern, whose digit - matches any."""
    digits = pattern[::-1]
    if "-" not in pattern and len(pattern) > 1:
        return f"{write.signal(value, exact=False)} == {len(pattern)}'h{int(pattern, 2):x}"
    terms = []
    for k, digit in enumerate(digits):
        if digit != "-":
            bit = part_of(value, k, 1)
            text = write.condition(bit) if len(digits) == digits.count("-") + 1 else \
                write.signal(bit)
            if digit == "1":
                terms.append(text)
            else:
                text = write.signal(bit)
                terms.append(f"!{text}")
    return " && ".join(terms) if terms else "1'b1"


def comb_expression(module, write, name, process):
    """The net ``name`` that a ``process`` drives, as one expression.

    Raises
    ------
    ValueError
        If a bit of it gets no value.
    """
    edges = {0, module.wires[name].width}
    _edges(process, name, edges)
    edges = sorted(edges)
    parts = []
    for low, high in zip(edges, edges[1:]):
        value = _fold(process, name, low, high - low, None)
        if value is None:
            raise ValueError(f"{module.name}: bits {low} to {high - 1} of {name} have no value")
        parts.append(value)
    if all(isinstance(value, list) for value in parts):
        return write.whole([part for value in parts for part in value], edges[-1])
    if len(parts) == 1:
        return _text(write, parts[0])
    return "{" + ", ".join(_text(write, value) for value in reversed(parts)) + "}"


def _edges(statements, name, edges):
    for item in statements:
        if isinstance(item, Switch):
            for _, inner in item.cases:
                _edges(inner, name, edges)
        else:
            for part in item[0]:
                if part.wire == name:
                    edges |= {part.low, part.low + part.width}


def _fold(statements, name, low, width, value):
    """Value of bits of a net after the statements: a signal, or (condition, then, else)."""
    for item in statements:
        if isinstance(item, Switch):
            value = _fold_switch(item, name, low, width, value)
            continue
        at = 0
        for part in item[0]:
            if part.wire == name and part.low <= low < part.low + part.width:
                value = part_of(item[1], at + low - part.low, width)
            at += part.width
    return value


def _fold_switch(switch, name, low, width, value):
    chosen = [(pattern, _fold(inner, name, low, width, value))
              for pattern, inner in switch.cases]
    rest = next((found for pattern, found in chosen if pattern is None), value)
    patterns = [pattern for pattern, _ in chosen if pattern is not None]
    if not any("-" in pattern for pattern in patterns) and len(set(patterns)) == len(patterns):
        # The cases exclude each other: their order is free.
        groups = []
        for pattern, found in chosen:
            if pattern is None or found == rest:
                continue
            same = next((group for group in groups if group[1] == found), None)
            if same:
                same[0].append(pattern)
            else:
                groups.append(([pattern], found))
        chosen = [*groups, (None, rest)]
    found = value
    for pattern, then in reversed(chosen):
        if pattern is None:
            found = then
        elif then != found:
            found = ((switch.value, pattern), then, found)
    return found


def _text(write, value):
    if value is None:
        raise ValueError("a choice leaves a net without a value")
    if isinstance(value, list):
        return write.signal(value)
    (signal, pattern), chosen, other = value
    patterns = [pattern] if isinstance(pattern, str) else pattern
    condition = " || ".join(_condition(write, signal, pattern) for pattern in patterns)
    if " " in condition:
        condition = f"({condition})"
    texts = [_text(write, part) for part in (chosen, other)]
    return f"{condition} ? " + " : ".join(
        f"({text})" if isinstance(part, tuple) and part is chosen else text
        for part, text in zip((chosen, other), texts))
