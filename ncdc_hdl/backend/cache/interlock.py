"""The interlock: marks entries whose last user still has to read its samples."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.forwarding import between_layout

__all__ = ["Interlock"]


class Interlock(wiring.Component):
    """Finds the busy entries of a look-up, whose tiles must not be replaced yet.

    An entry is busy while its last user is among the pending look-ups, as its
    number shows, see ``Pending``. Numbers repeat, so that an old entry may seem busy; it is freed
    by the next look-ups read. If an earlier look-up touches an entry, the memory does not
    have its last user. It counts as busy until the look-up is in stage A, where the last
    user's number is that look-up's own, less the look-ups between, less one.

    Timing: ``d_busy`` follows ``last_use``, ``touched`` and ``between`` after one shift;
    ``a_busy`` follows ``d_busy`` with the next shift, and ``retired`` at once.

    Parameters
    ----------
    options : CacheOptions
        ``sequence_bits`` is used.

    Members
    -------
    shift : ``In(1)``
        All look-ups move on by one stage in this clock.
    touched, between : ``In(tag_banks)``, ``In(between_layout(options))``
        For the look-up in stage C, as in ``Forwarding``.
    last_use : ``In(ArrayLayout(sequence_bits, tag_banks))``
        For the look-up in stage C, as in ``TagMemory``.
    number, retired, wrapped : ``In``
        Numbers of the pending look-ups, as in ``Pending``.
    d_busy : ``Out(tag_banks)``
        Whether each entry of the look-up in stage D is busy.
    a_busy : ``Out(tag_banks)``
        Whether each entry of the look-up in stage A is busy.
    """

    def __init__(self, options):
        self.options = options
        number = options.sequence_bits
        super().__init__({
            "shift": In(1),
            "touched": In(options.tag_banks),
            "between": In(between_layout(options)),
            "last_use": In(data.ArrayLayout(number, options.tag_banks)),
            "number": In(number),
            "retired": In(number),
            "wrapped": In(1),
            "d_busy": Out(options.tag_banks),
            "a_busy": Out(options.tag_banks),
        })

    def elaborate(self, platform):
        m = Module()
        bits, banks = self.options.sequence_bits, self.options.tag_banks
        between = between_layout(self.options)

        # D: the comparisons with the numbers of pending look-ups, made between stages C and D.
        d_touched = Signal(banks)               # an earlier look-up touches the entry
        d_between = Signal(between)             # look-ups between that one and this one
        d_last_use = Signal(data.ArrayLayout(bits, banks), reset_less=True)  # by the memory
        with m.If(self.shift):
            m.d.sync += [
                d_touched.eq(self.touched),
                d_between.eq(self.between),
                d_last_use.eq(self.last_use),
            ]
            for bank, last_use in enumerate(self.last_use):
                m.d.sync += self.d_busy[bank].eq(self.touched[bank] | self._in_flight(
                    last_use >= self.retired, last_use < self.number, self.wrapped))

        # A: the same while the look-up stays.
        a_new = Signal()                        # the look-up is in its first clock in stage A
        a_touched = Signal(banks)               # an earlier look-up touched the entry
        a_between = Signal(between)             # look-ups between that one and this one
        # The last user: in the first clock that of the memory, later also that of earlier look-ups.
        a_last_use = Signal(data.ArrayLayout(bits, banks), reset_less=True)
        m.d.sync += a_new.eq(self.shift)
        with m.If(self.shift):
            m.d.sync += [a_touched.eq(d_touched), a_between.eq(d_between),
                         a_last_use.eq(d_last_use)]
        for bank, last_use in enumerate(a_last_use):
            unknown = a_new & a_touched[bank]
            with m.If(~self.shift & unknown):
                # One addition makes `number - 1 - between`: that of the inverted bits.
                m.d.sync += last_use.eq(
                    self.number + ~Cat(a_between[bank], Const(0, bits - len(a_between[bank]))))
            m.d.comb += self.a_busy[bank].eq(unknown | self._in_flight(
                last_use >= self.retired, last_use < self.number, self.wrapped))
        return m

    @staticmethod
    def _in_flight(since, before, wrapped):
        """Whether a last user is one of the pending look-ups.

        ``since``: its number is not below ``retired``. ``before``: it is below ``number``.
        ``wrapped``: ``number`` has wrapped to 0 and ``retired`` has not. A method of its own only
        so that proofs and tests can break the interlock.
        """
        return (since & before) | (wrapped & (since | before))
