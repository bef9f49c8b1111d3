"""The registers as a page of the documentation: ``python -m ncdc_hdl.export.registers.page``."""

from ncdc_model.descriptor import Formats
from ncdc_model.geometry import MAX_SIZE
from ncdc_model.interface.register_map import ADDRESS_WORDS_BITS, SKIP, TABLE, registers

__all__ = ["register_doc"]

_HEAD = """\
# Registers

Generated from `model/ncdc_model/interface/register_map.py` by `python -m ncdc_hdl.export.registers.page`;
a test compares this page with that table.

The corrector's `csr` port is an Avalon-MM agent with {words} words of 32 bits. Offsets are in
bytes from the agent's base; the port itself counts words. An access is accepted after
five clocks of waiting, when all that it changes has changed; the data of a read follow a clock later. A
signed value is sign-extended on reading. An unused offset reads zero and ignores writes. After configuration every shadow register has the value of the descriptor
that the Verilog was generated from, with the raw frame at address 0 and the corrected frame on the
next multiple of 4096 bytes behind it.

Access:

- `ro`: read only;
- `rw`: takes effect at once;
- `shadow`: read and written at any time, but only a commit makes it active, see below;
- `action`: flags. `w1`: writing 1 acts, it reads 0; `w1c`: writing 1 clears it.

Where the descriptor has a skip path ([numbers](numbers.md#the-skip-path)), the four registers from
0x{skip:04X} on are `SKIP_X_WEIGHT_X`, the weight of x in x', `SKIP_X_WEIGHT_Y`, `SKIP_Y_WEIGHT_X` and
`SKIP_Y_WEIGHT_Y`.

The sizes of the network's registers are those of {neurons} hidden neurons (j = 0 .. {last}) in the
default formats.

| offset | name | access | bits | meaning |
|---|---|---|---|---|
"""

_TAIL = """
The table of valid rows has two banks. `VALID_WINDOW` chooses the bank that the host sees at
`VALID_ROWS`, `VALID_BANK` the one that the next frame uses. Each row r of the corrected image has
two words, one per span of pixels with a source: start in bits {bits}:0, stop in bits {high}:16. A
pixel u has a source if start <= u < stop of either span; an empty span is 0. A bank has as many
rows as the corrected image of the descriptor, rounded up to a power of two; a host that sets a
taller image than that gets the spans of other rows; writes beyond the bank are ignored. Of start and
stop as many bits are kept as the corrected width of the descriptor takes; a wider image needs a
descriptor as wide. Sizes outside their limits are not checked; a frame whose width or height is 0 has one blank pixel, and `ABORTED`.

`ABORT` ends the frame that runs early: the pixel after the one that enters the network is blank and
the last. What is under way drains in order, the writer completes its burst, and the frame ends as any
other does, with `DONE` and with `ABORTED`, which the next frame's end clears. A memory keeps what it
had where the missing pixels belong; a stream's packet is short. Without a frame that runs it does
nothing; `ABORT` and `START` together (5) end that frame and begin another. A frame whose stream is
never taken cannot end: reset the module.

## A frame, another lens

To correct a frame: write what differs from the reset values, write `COMMIT` and `START` (3) to
`CTRL`, wait for `DONE` in `STATUS` (or for `irq`, if `IRQ_ENABLE` is 1), write `DONE` (2) to `STATUS`.
[The drivers](drivers.md) do this in C and Python.

What is written to shadow registers goes to a set of its own. `COMMIT` marks that set complete; at the
next frame boundary, or at once if no frame runs, all of it becomes active in one clock. From then on
a host may write the next set, while the frame runs. `START` without `COMMIT` corrects another
frame with the set in use. A commit costs no clock: a waiting frame begins in the clock after the
last one ends.

No frame sees half a set, whatever the host does. A write is ignored, and sets `REFUSED`, if it goes to

- a shadow register while a commit waits (`COMMITTED`);
- the bank of valid rows that a running or waiting frame uses (`BANK` tells which), or that a waiting
  commit names.

A host that wants another lens writes the network, the geometry and the bank of valid rows that is
not in use, names that bank in `VALID_BANK`, and writes `COMMIT` and `START`.
"""


def register_doc(hidden_neurons, formats):
    """Markdown page of the registers of an instance; the neurons' registers have one row each.

    Raises
    ------
    ValueError
        If the registers of one kind are not at equal distances.
    """
    rows = {}
    for register in registers(hidden_neurons, formats):
        rows.setdefault(register.family, []).append(register)
    lines = [_row(_offset(name, same), name, same[0].access, same[0].shape, _text(same[0], text))
             for (name, text), same in rows.items()]
    lines.append(f"| 0x{4 * TABLE:04X} + 8 r | `VALID_ROWS` | rw | 2 x 32 | "
                 "Spans of pixels with a source in row r, see below. |\n")
    bits = MAX_SIZE.bit_length() - 1
    return (_HEAD.format(words=1 << ADDRESS_WORDS_BITS, neurons=hidden_neurons,
                         last=hidden_neurons - 1, skip=4 * SKIP)
            + "".join(lines) + _TAIL.format(bits=bits, high=16 + bits))


def _offset(name, same):
    first = 4 * same[0].address
    steps = {4 * (b.address - a.address) for a, b in zip(same, same[1:])}
    if len(steps) > 1:
        raise ValueError(f"the registers {name} are at unequal distances {sorted(steps)}")
    return f"0x{first:04X} + {steps.pop()} j" if steps else f"0x{first:04X}"


def _text(register, text):
    flags = "; bit ".join(f"{flag.bit} `{flag.name}` ({flag.access}): {flag.text}"
                      for flag in register.flags)
    return " ".join(part for part in (flags and f"Bit {flags}.", text) if part)


def _row(offset, name, access, shape, text):
    bits = f"{shape.width}, signed" if shape.signed else f"{shape.width}"
    return f"| {offset} | `{name}` | {access} | {bits} | {text} |\n"


if __name__ == "__main__":
    print(register_doc(8, Formats()), end="")
