"""When a memory answers: the rules of ``memory_timing``, from event to event.

The clock edge of a time is the one at which the host sees it: a command accepted, a word on the
port. Edges ascend from call to call.
"""

from collections import deque

from ncdc_model.planner.memory_timing import DramMemory

__all__ = ["memory_port"]

_NEVER = 1 << 62


def memory_port(memory, data_width, writes=None, lags=None, read_to_bus=0):
    """A port on ``memory`` (``LatencyMemory`` or ``DramMemory``) with words of ``data_width`` bits.

    Its ``read(clock, address, words)`` presents a command at edge ``clock`` and returns two edges:
    the one that accepts it and the one at which its last word is on the port. If the same memory
    takes the corrected frame, ``writes`` are its :class:`FrameWrites` and ``lags`` tells when a
    pixel is there to be written, and is told when the writer is full. ``known`` is the first
    look-up of which that is not known; ``advance(clock)`` writes what is written before a clock.
    ``read_to_bus``: clocks from a window read to the first word of the burst it completes.
    """
    kind = _DramPort if isinstance(memory, DramMemory) else _LatencyPort
    return kind(memory, data_width // 8, writes, lags, read_to_bus)


class _Port:
    """The limit of read commands under way, and the arrival of writes."""

    def __init__(self, memory, word, writes, lags, read_to_bus):
        self.memory, self.word, self.read_to_bus = memory, word, read_to_bus
        self.ends = deque([0] * memory.max_pending, memory.max_pending)
        self.last = 0               # edge of the last word on the port
        self.writes, self.lags, self.known = writes, lags, 0
        self.total = writes.count if writes else 0
        self.mine = iter(writes.accesses() if writes else ())
        self.own = next(self.mine, None)        # the frame's next access, as ``accesses`` has it
        self.others = iter(writes.others() if writes and writes.others else ())
        self.other = next(self.others, None)    # the next access of somebody else
        self.arrived = 0            # write accesses that have arrived
        self.last_edge = self.own_edge = 0      # of the last one, and of the frame's own last one
        # Those that are not placed yet: (edge that accepts its last word, address, words, whether
        # it is the frame's own).
        self.waiting = deque()
        self.done_at = deque([], self.queue)    # edges at which the last ones were placed

    def read(self, clock, address, words):
        accepted = max(clock, self.ends[0])
        self._serve(accepted, address, words)
        self.ends.append(self.last)
        return accepted, self.last

    def _arrive(self):
        """Arrivals of writes, as far as they are known; whether one waits to be placed."""
        while len(self.waiting) < self.queue:
            own = self._own_edge()
            theirs = self._other_is_first(own)
            if theirs:
                edge, address, words = self.other
                self.other = next(self.others, None)
            elif own is not None:
                edge, (address, words, _, held) = own, self.own
            else:
                break
            if self.arrived:
                edge = max(edge, self.last_edge + words)
            if self.arrived >= self.queue:
                edge = max(edge, self.done_at[len(self.waiting) - self.queue] + words)
            self.arrived += 1
            self.last_edge = edge
            self.waiting.append((edge, address, words, not theirs))
            if not theirs:
                self.own_edge = edge
                self.lags.hold(held, edge - words + 1)
                self.own = next(self.mine, None)
        return bool(self.waiting)

    def _own_edge(self):
        """Edge at which the frame's next access would be complete; None if that is not known."""
        if self.own is None:
            return None
        _, words, last, _ = self.own
        if last >= self.known:
            return None
        self.lags.settle(last)
        return self.lags.clock(last) + self.read_to_bus + words - 1

    def _other_is_first(self, own):
        """Whether somebody else's access comes before the frame's next one, which comes at ``own``.

        Of one that is not known all that is known is what comes before it. Behind the frame's last
        one nobody else counts.
        """
        if self.other is None or (self.total and self.own is None):
            return False
        if own is None:
            own = self.lags.clock(self.known) + self.read_to_bus if self.total else _NEVER
        return self.other[0] <= own

    def finish(self):
        """All pixels are known: the edge at which the last write is accepted."""
        self.known = _NEVER
        self.advance(_NEVER)
        return self.own_edge


class _LatencyPort(_Port):
    """A latency and a rate; of a random latency the mean. Reads and writes are paid for in order
    of time."""

    queue = 1

    def __init__(self, memory, word, writes, lags, read_to_bus):
        super().__init__(memory, word, writes, lags, read_to_bus)
        self.latency = round(sum(memory.latency) / 2)
        # 256 pay for a word.
        self.rate = (1024 if memory.bytes_per_clock is None
                     else max(1, round(256 * memory.bytes_per_clock / word)))
        self.granule = -(-memory.granule // word)
        self.cap = self.rate + 256 * self.granule
        self.credit, self.paid_at = 0, 0

    def _pay(self, edge, cost):
        """The first edge from ``edge`` on at which ``cost`` is paid."""
        edge = max(edge, self.paid_at)
        credit = min(self.cap, self.credit + self.rate * (edge - self.paid_at))
        if credit < cost:
            wait = -((credit - cost) // self.rate)
            edge, credit = edge + wait, credit + self.rate * wait
        self.credit, self.paid_at = credit - cost, edge
        return edge

    def _serve(self, accepted, address, words):
        cost = 256 * max(1, self.granule - words + 1)
        for _ in range(words):
            edge = max(self.last + 1, accepted + self.latency)
            self.advance(edge)
            self.last, cost = self._pay(edge, cost), 256

    def advance(self, clock):
        while self._arrive() and self.waiting[0][0] < clock:
            edge, _, words, own = self.waiting.popleft()
            edge -= words
            for _ in range(words):
                edge = self._pay(edge + 1, 256)
            self.last_edge = edge           # no other one has arrived: the queue is of one
            if own:
                self.own_edge = edge
            self.done_at.append(edge)


class _DramPort(_Port):
    """Rows, banks, refresh; times in memory clocks but for edges."""

    def __init__(self, memory, word, writes, lags, read_to_bus):
        self.queue = 2 * memory.write_batch
        super().__init__(memory, word, writes, lags, read_to_bus)
        self.multiply, self.divide = memory.ratio.numerator, memory.ratio.denominator
        self.placed = 0                 # edge of the last access placed
        self.writing, self.batch = False, 0
        self.columns = deque([0] * memory.look_ahead, memory.look_ahead)
        self.row = [None] * memory.banks
        self.precharge_from = [0] * memory.banks
        self.activate_from = [0] * memory.banks
        self.column_from = [0] * memory.banks
        self.any_activate_from, self.read_from, self.write_from = 0, 0, 0
        self.fours = deque([0] * 4, 4)
        self.taken, self.last_command = set(), 0
        self.refresh_due = memory.refresh_interval

    def _time(self, edge):
        return edge * self.multiply // self.divide

    def _edge(self, time):
        """The first edge that is not before the memory clock ``time``."""
        return -(-time * self.divide // self.multiply)

    def _serve(self, accepted, address, words):
        memory, word = self.memory, self.word
        end, from_edge = address + words * word, accepted + memory.controller_clocks
        while address < end:
            upto = min(end, (address // memory.access_bytes + 1) * memory.access_bytes)
            edge = self._write_until(from_edge, accepted)
            length = self._length(address, upto)
            data = self._place(edge, address, length, False) + memory.cas_latency
            beats = (upto - address) // word
            self.last = max(self.last + beats, self._edge(data + length),
                            self._edge(data + memory.word_clocks) + beats - 1)
            address = upto

    def advance(self, clock):
        if self._arrive():
            self._write_until(_NEVER, _NEVER, clock)

    def _write_until(self, read_from, held_from, clock=_NEVER):
        """Place writes until a read that may be placed from edge ``read_from`` on has its turn, and
        return its edge, or until ``clock``. ``held_from``: the port holds the read's command.
        """
        memory = self.memory
        while True:
            edge = max(self.placed + 1, self._edge(self.columns[0]))
            if not self._arrive():
                self.batch = 1 if self.writing else self.batch + 1
                self.writing = False
                return max(edge, read_from)
            write_from = self.waiting[0][0] + memory.controller_clocks
            edge = max(edge, min(read_from, write_from))
            if edge >= clock:
                return edge
            if self._writes_at(edge, read_from, write_from, held_from):
                self._write(edge)
            elif read_from <= edge and not self.writing:
                self.batch += 1
                return edge
            else:
                # Nothing may go: wait for a read, a batch of writes, or until no read is held.
                turn = min(read_from, self.last if edge < self.last < held_from else _NEVER,
                           self._batch_edge())
                if turn >= clock:
                    return clock
                self.placed = turn - 1

    def _writes_at(self, edge, read_from, write_from, held_from):
        """Whether a write has its turn at ``edge``; changes direction if it must."""
        may_read, may_write = read_from <= edge, write_from <= edge
        batch = self.memory.write_batch
        if self.writing:
            change = may_read and (not may_write or self.batch >= batch)
        else:
            idle = self.last <= edge < held_from
            change = may_write and (idle or (
                self._batch_edge() <= edge and (not may_read or self.batch >= batch)))
        if change:
            self.writing, self.batch = not self.writing, 0
        return self.writing and may_write

    def _batch_edge(self):
        """Edge at which a whole batch of writes waits; never, as far as that is known."""
        batch = self.memory.write_batch
        return self.waiting[batch - 1][0] if batch <= len(self.waiting) else _NEVER

    def _write(self, edge):
        _, address, words, _ = self.waiting.popleft()
        self._place(edge, address, self._length(address, address + words * self.word), True)
        self.batch += 1
        self.done_at.append(edge)

    def _length(self, address, upto):
        """Memory clocks of data of the bytes address..upto."""
        size = self.memory.word_bytes
        return ((upto - 1) // size - address // size + 1) * self.memory.word_clocks

    def _issue(self, at):
        while at in self.taken:
            at += 1
        self.taken.add(at)
        self.last_command = max(self.last_command, at)
        return at

    def _place(self, edge, address, length, write):
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
        at = self._issue(max(now + 1, self.column_from[bank],
                             self.write_from if write else self.read_from))
        end = at + length
        self.read_from = end + (memory.write_to_read if write else 0)
        self.write_from = end + (0 if write else memory.read_to_write)
        self.precharge_from[bank] = max(self.precharge_from[bank],
                                        end + (memory.write_to_precharge if write else 0))
        self.columns.append(at)
        self.placed = edge
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
