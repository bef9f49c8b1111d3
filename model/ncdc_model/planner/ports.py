"""Times at which a memory answers: the rules of ``memory_timing``, from event to event.

The clock edge of a time is the one at which the host sees it: a command accepted, a word on the
port. Edges ascend from call to call.
"""

from collections import deque
from dataclasses import dataclass

from ncdc_model.planner.memory_timing import DramMemory

__all__ = ["memory_port"]

_NEVER = 1 << 62


def memory_port(memory, data_width, writes=None, delays=None, read_to_bus=0):
    """A port on ``memory`` (``LatencyMemory`` or ``DramMemory``) with words of ``data_width`` bits.

    Its ``read(clock, address, words)`` presents a command at edge ``clock`` and returns two edges:
    the one that accepts it and the one at which its last word is on the port. If the same memory
    takes the corrected frame, ``writes`` are its :class:`FrameWrites`, with the accesses of other
    hosts, whose reads come through a port of their own. ``delays`` gives the clock
    at which a pixel is ready, and the port postpones it while the writer is full. ``known`` is the
    first look-up without a known delay; ``advance(clock)`` schedules the writes before a clock.
    ``read_to_bus``: clocks from a window read to the first word of the burst it completes.
    """
    kind = _DramPort if isinstance(memory, DramMemory) else _LatencyPort
    return kind(memory, data_width // 8, writes, delays, read_to_bus)


@dataclass(slots=True)
class _PendingAccess:
    """A write access at the port that is not scheduled yet.

    ``edge``: the one that could accept its last word; ``of_frame``: it is of the corrected frame,
    not of another host.
    """
    edge: int
    address: int
    words: int
    of_frame: bool


class _Port:
    """The limit of outstanding read commands, and the arrival of writes and of others' reads."""

    def __init__(self, memory, word, writes, delays, read_to_bus):
        self.memory, self.word, self.read_to_bus = memory, word, read_to_bus
        self.ends = deque([0] * memory.max_pending, memory.max_pending)
        self.last = 0               # edge of the last word on the port
        self.delays, self.known = delays, 0
        self.total = writes.count if writes else 0
        self.frame_accesses = iter(writes.accesses() if writes else ())
        self.frame_next = next(self.frame_accesses, None)   # as :meth:`FrameWrites.accesses`
        self.other_accesses = iter(writes.others() if writes and writes.others else ())
        self.other_next = next(self.other_accesses, None)   # (edge, address, words)
        self.other_reads = iter(writes.reads() if writes and writes.reads else ())
        self.read_next = next(self.other_reads, None)       # (edge, address, words)
        self.arrived = 0            # write accesses that have arrived
        self.last_edge = self.frame_edge = 0    # of the last one, and of the frame's last one
        self.waiting = deque()      # of :class:`_PendingAccess`
        self.done_at = deque([], self.queue)    # edges at which the last ones were scheduled

    def read(self, clock, address, words):
        accepted = max(clock, self.ends[0])
        self._serve(accepted, address, words)
        self.ends.append(self.last)
        return accepted, self.last

    def _arrive(self):
        """Queue the writes whose arrival is known; return whether any waits."""
        while len(self.waiting) < self.queue:
            frame_edge = self._frame_arrival()
            if self._other_is_first(frame_edge):
                access = _PendingAccess(*self.other_next, False)
                self.other_next = next(self.other_accesses, None)
            elif frame_edge is not None:
                address, words, _, stalled = self.frame_next
                access = _PendingAccess(frame_edge, address, words, True)
            else:
                break
            if self.arrived:
                access.edge = max(access.edge, self.last_edge + access.words)
            if self.arrived >= self.queue:
                freed = self.done_at[len(self.waiting) - self.queue]
                access.edge = max(access.edge, freed + access.words)
            self.arrived += 1
            self.last_edge = access.edge
            self.waiting.append(access)
            if access.of_frame:
                self.frame_edge = access.edge
                self.delays.postpone(stalled, access.edge - access.words + 1)
                self.frame_next = next(self.frame_accesses, None)
        return bool(self.waiting)

    def _frame_arrival(self):
        """Edge at which the frame's next access is complete at the earliest; None if not known."""
        if self.frame_next is None:
            return None
        _, words, last, _ = self.frame_next
        if last >= self.known:
            return None
        self.delays.apply_postponed(last)
        return self.delays.clock(last) + self.read_to_bus + words - 1

    def _other_is_first(self, frame_edge):
        """Whether another host's access comes before the frame's next one at ``frame_edge``.

        If ``frame_edge`` is not known, only its lower bound counts. After the frame's last access
        other hosts do not matter.
        """
        if self.other_next is None or (self.total and self.frame_next is None):
            return False
        if frame_edge is None:
            frame_edge = (self.delays.clock(self.known) + self.read_to_bus if self.total
                          else _NEVER)
        return self.other_next[0] <= frame_edge

    @property
    def _frame_written(self):
        """Whether the frame's last write is scheduled: then other hosts do not matter."""
        return (self.total > 0 and self.frame_next is None
                and not any(access.of_frame for access in self.waiting))

    def finish(self):
        """All pixels are known: the edge at which the last write is accepted."""
        self.known = _NEVER
        self.advance(_NEVER)
        return self.frame_edge


class _LatencyPort(_Port):
    """A latency and a rate; the mean of a random latency. Reads and writes consume credit in order
    of time."""

    queue = 1

    def __init__(self, memory, word, writes, delays, read_to_bus):
        super().__init__(memory, word, writes, delays, read_to_bus)
        self.latency = round(sum(memory.latency) / 2)
        # A word costs 256.
        self.rate = (1024 if memory.bytes_per_clock is None
                     else max(1, round(256 * memory.bytes_per_clock / word)))
        self.granule = -(-memory.granule // word)
        self.cap = self.rate + 256 * self.granule
        self.credit, self.paid_at = 0, 0

    def _pay(self, edge, cost):
        """The first edge from ``edge`` on at which the credit covers ``cost``."""
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
        while True:
            written = self.waiting[0].edge if self._arrive() else _NEVER
            read = self.read_next[0] if self.read_next and not self._frame_written else _NEVER
            if min(written, read) >= clock:
                return
            if read < written:
                for _ in range(max(self.read_next[2], self.granule)):
                    read = self._pay(read + 1, 256)
                self.read_next = next(self.other_reads, None)
                continue
            access = self.waiting.popleft()
            edge = access.edge - access.words
            for _ in range(access.words):
                edge = self._pay(edge + 1, 256)
            self.last_edge = edge           # no other one has arrived: the queue has one entry
            if access.of_frame:
                self.frame_edge = edge
            self.done_at.append(edge)


@dataclass(slots=True)
class _Bank:
    """Open row of a bank, and the first memory clocks of its next commands."""
    row: int | None = None
    precharge_from: int = 0
    activate_from: int = 0
    column_from: int = 0


class _DramPort(_Port):
    """Rows, banks, refresh; times in memory clocks except for edges."""

    def __init__(self, memory, word, writes, delays, read_to_bus):
        self.queue = 2 * memory.write_batch
        super().__init__(memory, word, writes, delays, read_to_bus)
        self.multiply, self.divide = memory.ratio.numerator, memory.ratio.denominator
        self.scheduled = 0              # edge of the last scheduled access
        self.writing, self.batch = False, 0
        self.columns = deque([0] * memory.look_ahead, memory.look_ahead)
        self.banks = [_Bank() for _ in range(memory.banks)]
        self.any_activate_from, self.read_from, self.write_from = 0, 0, 0
        self.fours = deque([0] * 4, 4)
        self.taken, self.last_command = set(), 0
        self.refresh_due = memory.refresh_interval
        self.other_was_last = False     # the last read command scheduled was another reader's

    def _time(self, edge):
        return edge * self.multiply // self.divide

    def _edge(self, time):
        """The first edge not before the memory clock ``time``."""
        return -(-time * self.divide // self.multiply)

    def _serve(self, accepted, address, words):
        memory, word = self.memory, self.word
        end, from_edge = address + words * word, accepted + memory.controller_clocks
        turn = self._turn           # of the command: its other accesses follow
        while address < end:
            upto = min(end, (address // memory.access_bytes + 1) * memory.access_bytes)
            edge, turn = turn(from_edge, accepted), self._write_until
            length = self._length(address, upto)
            data = self._schedule(edge, address, length, False) + memory.cas_latency
            beats = (upto - address) // word
            self.last = max(self.last + beats, self._edge(data + length),
                            self._edge(data + memory.word_clocks) + beats - 1)
            address = upto

    def advance(self, clock):
        if self._arrive() or self.read_next:
            self._turn(_NEVER, _NEVER, clock)

    def _turn(self, read_from, held_from, clock=_NEVER):
        """As :meth:`_write_until`, after the commands of other readers that come first: earlier
        ones, and every other one of those that could go at once."""
        while self.read_next and not self._frame_written:
            ready = max(self.scheduled + 1, self._edge(self.columns[0]))
            own = max(ready, read_from)
            other = max(ready, self.read_next[0] + self.memory.controller_clocks)
            if other >= clock or own < other or own == other and self.other_was_last:
                break
            if not self._serve_other(clock):
                return clock
        self.other_was_last = False
        return self._write_until(read_from, held_from, clock)

    def _serve_other(self, clock):
        """Schedule the next command of another reader, unless that is at ``clock`` or later; return
        whether it is."""
        arrived = self.read_next[0]
        while self.read_next and self.read_next[0] == arrived:
            _, address, words = self.read_next
            edge = self._write_until(arrived + self.memory.controller_clocks, arrived, clock)
            if edge >= clock:
                return False
            self._schedule(edge, address, self._length(address, address + words * self.word), False)
            self.read_next = next(self.other_reads, None)
        self.other_was_last = True
        return True

    def _write_until(self, read_from, held_from, clock=_NEVER):
        """Schedule writes until ``clock``, or until the turn of a read that may be scheduled from
        edge ``read_from`` on; return its edge. ``held_from``: the port holds the read's command.
        """
        memory = self.memory
        while True:
            edge = max(self.scheduled + 1, self._edge(self.columns[0]))
            if not self._arrive():
                self.batch = 1 if self.writing else self.batch + 1
                self.writing = False
                return max(edge, read_from)
            write_from = self.waiting[0].edge + memory.controller_clocks
            edge = max(edge, min(read_from, write_from))
            if edge >= clock:
                return edge
            if self._writes_at(edge, read_from, write_from, held_from):
                self._write(edge)
            elif read_from <= edge and not self.writing:
                self.batch += 1
                return edge
            else:
                # Nothing is ready: wait for a read, a batch of writes, or until no read is held.
                turn = min(read_from, self.last if edge < self.last < held_from else _NEVER,
                           self._batch_edge())
                if turn >= clock:
                    return clock
                self.scheduled = turn - 1

    def _writes_at(self, edge, read_from, write_from, held_from):
        """Whether a write has its turn at ``edge``; changes direction if necessary."""
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
        """Edge at which a whole batch of writes waits; never, if that is not known."""
        batch = self.memory.write_batch
        return self.waiting[batch - 1].edge if batch <= len(self.waiting) else _NEVER

    def _write(self, edge):
        access = self.waiting.popleft()
        end = access.address + access.words * self.word
        self._schedule(edge, access.address, self._length(access.address, end), True)
        self.batch += 1
        self.done_at.append(edge)

    def _length(self, address, upto):
        """Memory clocks of data for the bytes address..upto."""
        size = self.memory.word_bytes
        return ((upto - 1) // size - address // size + 1) * self.memory.word_clocks

    def _issue(self, at):
        while at in self.taken:
            at += 1
        self.taken.add(at)
        self.last_command = max(self.last_command, at)
        return at

    def _schedule(self, edge, address, length, write):
        """Schedule an access at ``edge`` with ``length`` clocks of data; return the time of its
        column command."""
        memory = self.memory
        now = self._time(edge)
        while now >= self.refresh_due:
            self._refresh(max(self._time(self._edge(self.refresh_due)), self.refresh_due))
            self.refresh_due += memory.refresh_interval
        line = address // memory.row_bytes
        bank, row = self.banks[line % memory.banks], line // memory.banks
        if bank.row != row:
            if bank.row is not None:
                at = self._issue(max(now + 1, bank.precharge_from))
                bank.activate_from = max(bank.activate_from, at + memory.rp)
            at = self._issue(max(now + 1, bank.activate_from, self.any_activate_from,
                                 self.fours[0]))
            bank.row = row
            self.any_activate_from = at + memory.rrd
            self.fours.append(at + memory.faw)
            bank.activate_from = at + memory.rc
            bank.precharge_from = at + memory.ras
            bank.column_from = at + memory.rcd
        at = self._issue(max(now + 1, bank.column_from,
                             self.write_from if write else self.read_from))
        end = at + length
        self.read_from = end + (memory.write_to_read if write else 0)
        self.write_from = end + (0 if write else memory.read_to_write)
        bank.precharge_from = max(bank.precharge_from,
                                  end + (memory.write_to_precharge if write else 0))
        self.columns.append(at)
        self.scheduled = edge
        return at

    def _refresh(self, now):
        memory = self.memory
        self.taken.clear()              # later commands are after all issued ones
        at = max(now, self.last_command) + 1
        if any(bank.row is not None for bank in self.banks):
            at = self._issue(max(at, *(bank.precharge_from for bank in self.banks))) + memory.rp
        at = self._issue(at)
        for bank in self.banks:
            bank.row, bank.activate_from = None, at + memory.refresh
