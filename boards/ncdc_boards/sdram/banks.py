"""The state of the memory's banks: open rows, and which commands are allowed now."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_boards.sdram.layouts import command_layout

__all__ = ["Banks"]


class Banks(wiring.Component):
    """Tracks the commands given, and outputs which ones the data sheet allows now.

    Each rule is a shift register with a one for each clock still to wait.

    Timing: a command counts from the next clock; outputs are valid in this clock.

    Parameters
    ----------
    mapping : AddressMapping
    clocks : SdramTiming

    Members
    -------
    command : ``In(command_layout(mapping))``
        The command given in this clock.
    column_bank, column_write : ``In(2)``, ``In(1)``
        For a READ or WRITE of this bank, which has its row open or opening:
    column_allowed : ``Out(1)``
    bank, row : ``In``
        For a row to be opened:
    is_open, is_other : ``Out(1)``
        The bank has a row open; another than this one.
    active_allowed, precharge_allowed : ``Out(1)``
        ACTIVE if the bank has none open; PRECHARGE of the bank.
    precharge_all_allowed, idle : ``Out(1)``
        PRECHARGE of all banks; no bank is busy with its last command: if none is open, AUTO
        REFRESH and LOAD MODE REGISTER are allowed.
    """

    def __init__(self, mapping, clocks):
        self.mapping, self.clocks = mapping, clocks
        chip = mapping.chip
        super().__init__({
            "command": In(command_layout(mapping)),
            "column_bank": In(chip.bank_bits), "column_write": In(1), "column_allowed": Out(1),
            "bank": In(chip.bank_bits), "row": In(chip.row_bits),
            "is_open": Out(1), "is_other": Out(1),
            "active_allowed": Out(1), "precharge_allowed": Out(1),
            "precharge_all_allowed": Out(1), "idle": Out(1),
        })

    @property
    def times(self):
        """{rule: clocks from one command to the next}.

        ``ras`` includes tRC: PRECHARGE waits until tRP after it ends no earlier than tRC.
        A write's last data come ``beats`` - 1 clocks after it. Between read data and write data
        DQ is undriven for a clock.
        """
        clocks, beats = self.clocks, self.mapping.beats
        return {
            "rcd": clocks.rcd, "rp": clocks.rp, "rfc": clocks.rfc, "mrd": clocks.mrd,
            "rrd": clocks.rrd, "ras": max(clocks.ras, clocks.rc - clocks.rp),
            "read_precharge": beats, "write_precharge": beats - 1 + clocks.wr,
            "column": beats, "read_write": clocks.cas + beats + 1,
        }

    def elaborate(self, platform):
        m = Module()
        chip, command, times = self.mapping.chip, self.command, self.times
        count = 1 << chip.bank_bits
        opened = Signal(count)                                  # banks with an open row
        rows = [Signal(chip.row_bits, name=f"row{k}") for k in range(count)]
        busy, held = [], []         # ACTIVE, READ and WRITE must wait; PRECHARGE must wait
        for k in range(count):
            here = Signal(name=f"here{k}")
            m.d.comb += here.eq(command.bank == k)
            precharge = command.precharge & here | command.precharge_all
            with m.If(precharge):
                m.d.sync += opened[k].eq(0)
            with m.If(command.active & here):
                m.d.sync += [opened[k].eq(1), rows[k].eq(command.row)]
            busy.append(_waiting(m, f"busy{k}", (command.active & here, times["rcd"]),
                                 (precharge, times["rp"]), (command.refresh, times["rfc"]),
                                 (command.mode, times["mrd"])))
            held.append(_waiting(m, f"held{k}", (command.active & here, times["ras"]),
                                 (command.read & here, times["read_precharge"]),
                                 (command.write & here, times["write_precharge"])))
        another = _waiting(m, "another", (command.active, times["rrd"]))
        read_waits = _waiting(m, "read_waits", (command.read | command.write, times["column"]))
        write_waits = _waiting(m, "write_waits", (command.read, times["read_write"]),
                               (command.write, times["column"]))
        m.d.comb += [
            self.column_allowed.eq(~Array(busy)[self.column_bank]
                                   & ~Mux(self.column_write, write_waits, read_waits)),
            self.is_open.eq(opened.bit_select(self.bank, 1)),
            self.is_other.eq(self._other(Array(rows)[self.bank], self.row)),
            self.active_allowed.eq(~Array(busy)[self.bank] & ~another),
            self.precharge_allowed.eq(~Array(held)[self.bank]),
            self.precharge_all_allowed.eq(~Cat(held).any()),
            self.idle.eq(~Cat(busy).any()),
        ]
        return m

    def _other(self, opened, row):
        """Whether the row that is open is another one.

        A method of its own only so that proofs and tests can break it.
        """
        return opened != row


def _waiting(m, name, *rules):
    """Whether one of the rules, pairs (command, clocks after it), requires to wait."""
    length = max(clocks for _, clocks in rules) - 1
    if length < 1:
        return Const(0, 1)
    wait = Signal(length, name=name)
    following = wait >> 1
    for command, clocks in rules:
        following = following | Mux(command, (1 << clocks - 1) - 1, 0)
    m.d.sync += wait.eq(following)
    return wait[0]
