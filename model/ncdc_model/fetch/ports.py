"""When a memory answers read commands: the rules of ``memory_timing``, command by command.

Each port takes commands in order of time and jumps from event to event. The clock edge of a time
is the one at which the host sees it: a command accepted, a word on the port.
"""

from collections import deque

from ncdc_model.memory_timing import DramMemory

__all__ = ["read_port"]


def read_port(memory, data_width):
    """A port on ``memory`` (``LatencyMemory`` or ``DramMemory``) with words of ``data_width`` bits.

    Its ``read(clock, address, words)`` presents a command at edge ``clock`` and returns two edges:
    the one that accepts it and the one at which its last word is on the port. Commands are to be
    presented in order, each behind the acceptance of the one before.
    """
    kind = _DramPort if isinstance(memory, DramMemory) else _LatencyPort
    return kind(memory, data_width // 8)


class _Port:
    """What all ports share: the limit of commands under way."""

    def __init__(self, memory, word):
        self.memory, self.word = memory, word
        self.ends = deque([0] * memory.max_pending, memory.max_pending)
        self.last = 0               # edge of the last word on the port

    def read(self, clock, address, words):
        accepted = max(clock, self.ends[0])
        self._serve(accepted, address, words)
        self.ends.append(self.last)
        return accepted, self.last


class _LatencyPort(_Port):
    """A latency and a rate; of a random latency the mean."""

    def __init__(self, memory, word):
        super().__init__(memory, word)
        self.latency = round(sum(memory.latency) / 2)
        # 256 pay for a word.
        self.rate = (512 if memory.bytes_per_clock is None
                     else max(1, round(256 * memory.bytes_per_clock / word)))
        self.granule = -(-memory.granule // word)
        self.cap = self.rate + 256 * self.granule
        self.credit, self.paid_at = 0, 0

    def _serve(self, accepted, address, words):
        cost = 256 * max(1, self.granule - words + 1)
        for _ in range(words):
            edge = max(self.last + 1, accepted + self.latency)
            credit = min(self.cap, self.credit + self.rate * (edge - self.paid_at))
            if credit < cost:
                wait = -((credit - cost) // self.rate)
                edge, credit = edge + wait, credit + self.rate * wait
            self.credit, self.paid_at, self.last = credit - cost, edge, edge
            cost = 256


class _DramPort(_Port):
    """Rows, banks, refresh; times in memory clocks but for edges."""

    def __init__(self, memory, word):
        super().__init__(memory, word)
        self.multiply, self.divide = memory.ratio.numerator, memory.ratio.denominator
        self.placed = 0                 # edge of the last access placed
        self.columns = deque([0] * memory.look_ahead, memory.look_ahead)
        self.row = [None] * memory.banks
        self.precharge_from = [0] * memory.banks
        self.activate_from = [0] * memory.banks
        self.column_from = [0] * memory.banks
        self.any_activate_from, self.read_from = 0, 0
        self.fours = deque([0] * 4, 4)
        self.taken, self.last_command = set(), 0
        self.refresh_due = memory.refresh_interval

    def _time(self, edge):
        return edge * self.multiply // self.divide

    def _edge(self, time):
        """The first edge that is not before the memory clock ``time``."""
        return -(-time * self.divide // self.multiply)

    def _issue(self, at):
        while at in self.taken:
            at += 1
        self.taken.add(at)
        self.last_command = max(self.last_command, at)
        return at

    def _serve(self, accepted, address, words):
        memory, word = self.memory, self.word
        end = address + words * word
        while address < end:
            upto = min(end, (address // memory.access_bytes + 1) * memory.access_bytes)
            edge = max(self.placed + 1, accepted + memory.controller_clocks,
                       self._edge(self.columns[0]))
            first, end_word = address // memory.word_bytes, (upto - 1) // memory.word_bytes
            length = (end_word - first + 1) * memory.word_clocks
            data = self._place(edge, address, length) + memory.cas_latency
            self.placed = edge
            beats = (upto - address) // word
            self.last = max(self.last + beats, self._edge(data + length),
                            self._edge(data + memory.word_clocks) + beats - 1)
            address = upto

    def _place(self, edge, address, length):
        """Plan the access placed at ``edge``, of ``length`` clocks of data; its column command's
        time."""
        memory = self.memory
        now = self._time(edge)
        while now >= self.refresh_due:
            self._refresh(max(self._time(self._edge(self.refresh_due)), self.refresh_due))
            self.refresh_due += memory.refresh_interval
        line = address // memory.row_bytes
        bank, row = line % memory.banks, line // memory.banks
        if self.row[bank] != row:
            if self.row[bank] is not None:
                at = self._issue(max(now + 1, self.precharge_from[bank]))
                self.activate_from[bank] = max(self.activate_from[bank], at + memory.rp)
            at = self._issue(max(now + 1, self.activate_from[bank], self.any_activate_from,
                                 self.fours[0]))
            self.row[bank] = row
            self.any_activate_from = at + memory.rrd
            self.fours.append(at + memory.faw)
            self.activate_from[bank] = at + memory.rc
            self.precharge_from[bank] = at + memory.ras
            self.column_from[bank] = at + memory.rcd
        at = self._issue(max(now + 1, self.column_from[bank], self.read_from))
        self.read_from = at + length
        self.precharge_from[bank] = max(self.precharge_from[bank], at + length)
        self.columns.append(at)
        return at

    def _refresh(self, now):
        memory = self.memory
        self.taken.clear()              # what follows is behind all that was issued
        at = max(now, self.last_command) + 1
        if any(row is not None for row in self.row):
            at = self._issue(max(at, *self.precharge_from)) + memory.rp
        at = self._issue(at)
        self.row = [None] * memory.banks
        self.activate_from = [at + memory.refresh] * memory.banks
