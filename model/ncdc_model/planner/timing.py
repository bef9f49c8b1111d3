"""Predicts the clocks of the cache for a frame from its misses alone."""

from collections import deque
from dataclasses import dataclass

from ncdc_model.planner.coordinate_stalls import coordinate_stalls
from ncdc_model.planner.delay_steps import DelaySteps
from ncdc_model.planner.ports import memory_port
from ncdc_spec.cache_options import TILE_WIDTH

__all__ = ["Clocks", "predict_clocks"]

# Last user of an empty slot: after a reset all entries have the number 0, that of the first
# look-up. In later frames it is the last look-up of the previous frame, which has read its window:
# claims of empty slots then wait for no look-up.
_RESET_USER = 0
_PIECE = 4096           # misses from one report of the progress to the next


@dataclass(frozen=True)
class Clocks:
    """Clocks of a frame and its stalls.

    Parameters
    ----------
    clocks : int
        From start to last pixel.
    interlock, credit : int
        Clocks that look-ups with misses waited for a slot still in use, and for requests of the
        previous look-up's tiles while as many as allowed were outstanding.
    unhindered : int
        Clocks from start to last pixel if memory never made a look-up wait.
    read : DelaySteps
        Delay of each look-up's read, from the first look-up on.
    """
    clocks: int
    interlock: int
    credit: int
    unhindered: int
    read: DelaySteps


def predict_clocks(missed, boxes, hardware, memory, timing, addresses, writes=None,
                   progress=lambda done, total: None):
    """:class:`Clocks` of the first frame after a reset.

    The prediction steps from miss to miss: between them one look-up enters and one leaves per
    clock. A look-up has two times: it leaves the tag stage (push) and its window is read (retire).
    Both are stored as delays after its number, which never fall::

        push(i)   = i + a(i)        push(i)   >= push(i-1) + 1, retire(i - pending) + 1,
                                                 coordinates(i), see :func:`coordinate_stalls`,
                                                 and if i misses tiles
                                                 retire(last user of a slot) + retire_to_replace,
                                                 load(last but one look-up that missed) + 1
        retire(i) = i + b(i)        retire(i) >= retire(i-1) + 1, push(i) + push_to_retire,
                                                 last word + fill_to_retire

    Of shared tile memory also retire(i) >= retire(i-1) + 1 + the words that i misses: no window is
    read in a clock that writes one. These clocks are before retire(i), here all at its end.

    Parameters
    ----------
    missed : Misses
    boxes : Lookups
    hardware : Hardware
        Its tile cache, of a known size, and its data width.
    memory : LatencyMemory or DramMemory
    timing : CorrectorTiming
    addresses : FrameAddresses
    writes : FrameWrites, optional
        Writes to the same memory; absent for a stream of pixels.
    progress : callable
        Called with (misses done, misses) repeatedly.
    """
    if writes is not None and len(boxes) < boxes.pixels:
        writes = writes.by_lookup(boxes.pixel)
    stalls = coordinate_stalls(boxes, timing)
    run = _Frame(hardware, memory, timing, writes, stalls)
    tile_height = hardware.cache.tile_height
    first = (missed.columns * TILE_WIDTH + addresses.source
             + missed.rows * (tile_height * addresses.pitch))
    rows = [row * addresses.pitch for row in range(tile_height)]
    for begin in range(0, len(missed), _PIECE):
        piece = slice(begin, begin + _PIECE)
        for i, victim, address in zip(*(array[piece].tolist() for array in (
                missed.lookup, missed.victim, first))):
            run.reach(i)
            run.missed.append((victim, [address + row for row in rows]))
        progress(begin, len(missed))
    run.finish(len(boxes) - 1)
    if writes is not None and writes.count:
        clocks = run.port.finish() + timing.start
    else:
        clocks = timing.start + run.read.clock(len(boxes) - 1) + timing.end
    unhindered = (timing.start + len(boxes) - 1 + (stalls[-1][1] if stalls else 0)
                  + timing.push_to_retire + timing.end)
    return Clocks(clocks, run.interlock, run.credit, unhindered, run.read)


class _Frame:
    """The state of :func:`predict_clocks` between two misses; clocks count from the first look-up
    in the act stage."""

    def __init__(self, hardware, memory, timing, writes, coordinates):
        cache = hardware.cache
        self.timing, self.writes = timing, writes
        self.pending, self.wrap = cache.pending, 1 << cache.sequence_bits
        self.words = 8 * TILE_WIDTH // hardware.data_width
        # Clocks of each tile's words in which no window is read.
        self.tile_writes = (cache.tile_height * self.words if hardware.tile_memory == "shared"
                            else 0)
        self.read = DelaySteps(timing.push_to_retire)         # b
        self.port = memory_port(memory, hardware.data_width, writes, self.read, timing.read_to_bus)
        self.push_delay = 0               # a, of the last look-up that missed
        self.slot_step = 0              # step of b for the look-up that frees a slot
        self.fills = deque([-timing.fill_to_claim] * cache.outstanding, cache.outstanding)
        self.command = 0                # edge from which the bus is free
        self.interlock = self.credit = 0
        self.current = -1               # the last look-up that missed tiles
        # Steps of coordinates that are too slow, and clocks lost beyond their lead.
        self.coordinates, self.lost = deque(coordinates), 0
        self.missed = []                # its tiles: (the slot's last user, addresses of the rows)
        self.claimed, self.last_word = -1, 0    # clocks of the last claim and of its last word
        # Of the last look-ups that missed, the oldest first: the clock before the first claim, and
        # the clocks (from, to) in which claims waited for credit.
        self.loads, self.waits = deque([-1, -1], 2), deque([(), (), ()], 3)

    def reach(self, i):
        """Look-up i misses; all look-ups before it are known."""
        if i == self.current:
            return
        self.finish(i)
        self.current = self.port.known = i
        self._write_until(i)
        self._wait_for_slot(i - 1)

    def finish(self, i):
        """All missing tiles of the present look-up are known, and the others up to i have none:
        these wait for their coordinates."""
        self.close()
        self.current = -1
        while self.coordinates and self.coordinates[0][0] <= i:
            j, delay = self.coordinates.popleft()
            self.port.known = j
            self._write_until(j)
            self._wait_for_slot(j - 1)
            self.lost = max(self.lost, self.push_delay - delay - self.timing.lead)
            self.push_delay = max(self.push_delay, delay + self.lost)
            self.read.step(j, self.push_delay + self.timing.push_to_retire)

    def _leave(self, i):
        """Look-up i, which misses tiles, leaves the tag stage."""
        arrived = clock = i + self.push_delay
        for victim, _ in self.missed:
            # The slot may be replaced once its last user, or a look-up in flight with the same
            # number modulo the sequence, has read its window. Look-ups before i - pending have
            # read theirs before i is pushed, so i does not wait for them.
            if victim < 0:
                victim = _RESET_USER
            user = victim + (i - 1 - victim) // self.wrap * self.wrap
            if user >= i - self.pending - self.timing.retire_to_replace:
                clock = max(clock, self.read.clock(user) + self.timing.retire_to_replace)
        self.interlock += clock - arrived
        # Two look-ups may wait for their claims during those of a third.
        leaves = max(clock, self.loads[0] + 1)
        self.credit += sum(max(0, min(end, leaves) - max(begin, clock))
                           for begin, end in self.waits[0])
        self.push_delay = leaves - i

    def _claim(self, clock):
        """The present look-up's tiles are claimed, from ``clock`` on at the earliest, and read."""
        clock = max(clock, self.claimed + 1)
        self.loads.append(clock - 1)
        self.waits.append([])
        for _, addresses in self.missed:
            self.claimed = max(clock, self.fills[0] + self.timing.fill_to_claim)
            self.waits[-1].append((clock, self.claimed))
            clock = self.claimed + 1
            self._fill(addresses)
        self.missed = []

    def _fill(self, addresses):
        """The tile claimed last is read, a command for each of its rows at ``addresses``."""
        clock = max(self.command, self.claimed + self.timing.claim_to_command)
        for address in addresses:
            accepted, self.last_word = self.port.read(clock, address, self.words)
            clock = accepted + 1
        self.command = clock
        self.fills.append(self.last_word)

    def close(self):
        """All missing tiles of the present look-up are known."""
        i = self.current
        if i < 0:
            return
        writes = self.tile_writes * len(self.missed)
        self._leave(i)
        self._wait_for_slot(i)
        self._claim(i + self.push_delay + self.timing.push_to_claim)
        self.read.step(i, max(self.last_word + self.timing.fill_to_retire - i,
                              self.push_delay + self.timing.push_to_retire,
                              self.read.delay[-1] + writes))

    def _wait_for_slot(self, i):
        """Delay look-up i until look-up i - pending has left."""
        read = self.read
        while True:
            read.apply_postponed(i - self.pending)
            last = i - self.pending
            while self.slot_step + 1 < len(read.at) and read.at[self.slot_step + 1] <= last:
                self.slot_step += 1
            delay = read.delay[self.slot_step] - self.pending + self.timing.retire_to_push
            if self.writes is None or delay <= self.push_delay:
                break
            # Until then the writer may have stalled more.
            self.push_delay = delay
            self._write_until(i)
        self.push_delay = max(self.push_delay, delay)

    def _write_until(self, i):
        """Schedule the writes before look-up i could request a tile."""
        if self.writes is not None:
            self.port.advance(i + self.push_delay + self.timing.push_to_claim
                              + self.timing.claim_to_command)
