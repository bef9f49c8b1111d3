"""The interlock: marks entries whose last user still has to read its samples."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.forwarding import EARLIER, between_layout

__all__ = ["Interlock"]


class Interlock(wiring.Component):
    """Finds the busy entries of a look-up, whose tiles must not be replaced yet.

    An entry is busy while its last user is among the pending look-ups, as its
    number shows, see ``Pending``. Numbers repeat, so that an old entry may seem busy; it is freed
    by the next look-ups read. If an earlier look-up touches an entry, the memory does not
    have its last user. It counts as busy until the look-up is in stage A. Then all look-ups before
    it have been passed on: that user is pending if more look-ups are than those between.

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
    number, retired, wrapped, more : ``In``
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
            "more": In(EARLIER),
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
        # A: the same while the look-up stays.
        a_new = Signal()                        # the look-up is in its first clock in stage A
        a_touched = Signal(banks)
        a_between = Signal(between)
        a_last_use = Signal(data.ArrayLayout(bits, banks), reset_less=True)
        m.d.sync += a_new.eq(self.shift)
        with m.If(self.shift):
            m.d.sync += [
                d_touched.eq(self.touched), d_between.eq(self.between),
                d_last_use.eq(self.last_use),
                a_touched.eq(d_touched), a_between.eq(d_between), a_last_use.eq(d_last_use),
            ]
            for bank in range(banks):
                m.d.sync += self.d_busy[bank].eq(
                    self.touched[bank] | self._in_use(self._pending(self.last_use[bank])))
        for bank in range(banks):
            # After an earlier look-up, as many are pending as are between, and that one.
            pending = Mux(a_touched[bank], self.more.bit_select(a_between[bank], 1),
                          self._pending(a_last_use[bank]))
            m.d.comb += self.a_busy[bank].eq((a_new & a_touched[bank]) | self._in_use(pending))
        return m

    def _pending(self, last_use):
        """Whether the look-up of a number is pending, from ``retired`` to before ``number``."""
        since, before = last_use >= self.retired, last_use < self.number
        return (since & before) | (self.wrapped & (since | before))

    @staticmethod
    def _in_use(pending):
        """Whether an entry is in use: its last user is ``pending``.

        A method of its own only so that proofs and tests can break the interlock.
        """
        return pending
