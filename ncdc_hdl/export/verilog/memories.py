"""Memories of a netlist: their content after configuration, and their ports."""

from itertools import chain, count

from ncdc_hdl.export.verilog.expressions import constant
from ncdc_hdl.export.verilog.rtlil import bits_of, part_of, width_of

__all__ = ["memory_lines"]

_RUN = 3            # fewest equal words for a loop


def memory_lines(module, write):
    """Lines of all memories of a module: initial values, then ports.

    Raises
    ------
    ValueError
        If a port is of a kind that Amaranth does not make.
    """
    taken = {*module.wires, *module.memories, *(cell.name for cell in module.cells)}
    i = next(name for name in chain("ik", (f"i{n}" for n in count(1))) if name not in taken)
    lines = [line for name, memory in module.memories.items()
             for line in _initial(name, memory, i)]
    if lines:
        lines = [f"  integer {i};", *lines]
    for cell in module.cells:
        if cell.kind == "$memwr_v2":
            lines += _write_port(cell, write)
        elif cell.kind == "$memrd_v2":
            lines += _read_port(cell, write)
    return lines


def _initial(name, memory, i):
    """An initial block: equal words in loops of ``i``, a second half that repeats the
    first one together with it.

    No word is read there: synthesis would use registers instead of block RAM.
    """
    if memory.init is None:
        return []
    words = [memory.init[at:at + memory.width]
             for at in range(len(memory.init) - memory.width, -1, -memory.width)]
    words += ["0" * memory.width] * (memory.size - len(words))
    half, offsets = memory.size // 2, [0]
    if memory.size % 2 == 0 and half > _RUN and words[:half] == words[half:] and set(words) != {
            words[0]}:
        words, offsets = words[:half], [0, half]
    lines, line, at = [], "", 0
    while at < len(words):
        end = at
        while end < len(words) and words[end] == words[at]:
            end += 1
        value = constant(words[at])
        if end - at >= _RUN:
            lines += [f"    {line.strip()}"] if line else []
            line = ""
            lines += [f"    for ({i} = {at + offset}; {i} < {end + offset}; {i} = {i} + 1) "
                      f"{name}[{i}] = {value};" for offset in offsets]
        else:
            for index in (k + offset for k in range(at, end) for offset in offsets):
                item = f" {name}[{index}] = {value};"
                if len(line) + len(item) > 96:
                    lines.append(f"    {line.strip()}")
                    line = ""
                line += item
        at = end
    lines += [f"    {line.strip()}"] if line else []
    return ["  initial begin", *lines, "  end"]


def _edge(cell, write):
    return f"posedge {write.signal(cell.connections['CLK'])}"


def _write_port(cell, write):
    name, inputs = cell.parameters["MEMID"], cell.connections
    address = write.condition(inputs["ADDR"])
    if cell.parameters["CLK_POLARITY"] != "1":
        raise ValueError(f"the memory {name} is written at a falling edge")
    lines = []
    enables = bits_of(inputs["EN"])
    low = 0
    while low < len(enables):
        high = low
        while high < len(enables) and enables[high] == enables[low]:
            high += 1
        enable = enables[low]
        if enable == "0":
            low = high
            continue
        part = "" if high - low == len(enables) else f"[{high - 1}:{low}]"
        value = write.whole(part_of(inputs["DATA"], low, high - low), high - low)
        # A net of one bit that only this port reads may be inlined here.
        text = write.condition(part_of(inputs["EN"], low, 1))
        condition = "" if enable == "1" else f"if ({text}) "
        lines.append(f"    {condition}{name}[{address}]{part} <= {value};")
        low = high
    return [f"  always @({_edge(cell, write)}) begin", *lines, "  end"] if len(lines) > 1 else [
        f"  always @({_edge(cell, write)})", *lines]


def _read_port(cell, write):
    name, inputs = cell.parameters["MEMID"], cell.connections
    if cell.parameters["CLK_ENABLE"] != "1":
        return []           # inlined where it is read
    if set(cell.parameters["TRANSPARENCY_MASK"].partition("'")[2]) - {"0"}:
        raise ValueError(f"the memory {name} has a transparent port")
    target, = inputs["DATA"]
    enable = write.condition(inputs["EN"])
    condition = "" if enable == "1'b1" else f"if ({enable}) "
    assert width_of(inputs["DATA"]) == target.width
    return [f"  always @({_edge(cell, write)})",
            f"    {condition}{target.wire} <= {name}[{write.condition(inputs['ADDR'])}];"]
