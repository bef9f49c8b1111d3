"""How many clocks the cache takes for a frame, from its misses alone."""

from collections import deque
from dataclasses import dataclass

from ncdc_model.planner.coordinate_waits import coordinate_lags
from ncdc_model.planner.lags import Lags
from ncdc_model.planner.ports import memory_port
from ncdc_spec.cache_options import TILE_WIDTH

__all__ = ["Clocks", "predict_clocks"]

# Whom an empty place names as its last user: after a reset all entries hold the number 0, which is
# the first look-up's. In later frames they name the last look-up of the frame before, which has
# read its window: claims in empty places then wait for nobody.
_RESET_USER = 0
_PIECE = 4096           # misses from one report of the progress to the next


@dataclass(frozen=True)
class Clocks:
    """Where the clocks of a frame go.

    Parameters
    ----------
    clocks : int
        From start to last pixel.
    interlock, credit : int
        Clocks that look-ups which miss tiles waited for a place still in use, and for tiles of the
        one before to be asked for while as many as allowed were under way.
    read : Lags
        When each look-up is read, from the first look-up on.
    """
    clocks: int
    interlock: int
    credit: int
    read: Lags


def predict_clocks(missed, boxes, hardware, memory, timing, places, writes=None,
                   progress=lambda done, total: None):
    """:class:`Clocks` of the first frame after a reset.

    Jumps from miss to miss: between them one look-up enters and one leaves per clock. Of each
    look-up only two times count: when it leaves the tag stage (push) and when its window is read
    (retire). Both are kept as lags behind its number, which never fall::

        push(i)   = i + a(i)        push(i)   >= push(i-1) + 1, retire(i - pending) + 1,
                                                 coordinates(i), see :func:`coordinate_lags`,
                                                 and if i misses tiles
                                                 retire(last user of a place) + retire_to_replace,
                                                 load(second of those that miss before it) + 1
        retire(i) = i + b(i)        retire(i) >= retire(i-1) + 1, push(i) + push_to_retire,
                                                 last word + fill_to_retire

    Parameters
    ----------
    missed : Misses
    boxes : Lookups
    hardware : Hardware
        Its tile cache, of a known size, and its data width.
    memory : LatencyMemory or DramMemory
    timing : CorrectorTiming
    places : FramePlaces
    writes : FrameWrites, optional
        What goes to the same memory; absent if pixels are taken as they come (a stream).
    progress : callable
        Called with (misses done, misses) now and then.
    """
    if writes is not None and len(boxes) < boxes.pixels:
        writes = writes.by_lookup(boxes.pixel)
    run = _Frame(hardware, memory, timing, writes, coordinate_lags(boxes, timing))
    tile_height = hardware.cache.tile_height
    first = (missed.columns * TILE_WIDTH + places.source
             + missed.rows * (tile_height * places.pitch))
    rows = [row * places.pitch for row in range(tile_height)]
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
    return Clocks(clocks, run.interlock, run.credit, run.read)


class _Frame:
    """The state of :func:`predict_clocks` between two misses; clocks count from the first look-up
    in the act stage."""

    def __init__(self, hardware, memory, timing, writes, coordinates):
        cache = hardware.cache
        self.timing, self.writes = timing, writes
        self.pending, self.wrap = cache.pending, 1 << cache.sequence_bits
        self.words = 8 * TILE_WIDTH // hardware.data_width
        self.read = Lags(timing.push_to_retire)         # b
        self.port = memory_port(memory, hardware.data_width, writes, self.read, timing.read_to_bus)
        self.push_lag = 0               # a, of the last look-up that missed
        self.room = 0                   # step of b that holds for the one that makes room
        self.fills = deque([-timing.fill_to_claim] * cache.outstanding, cache.outstanding)
        self.command = 0                # edge at which the bus is free
        self.interlock = self.credit = 0
        self.current = -1               # the last look-up that missed tiles
        # Steps of coordinates that come too slowly, and clocks lost where they could not be ahead.
        self.coordinates, self.lost = deque(coordinates), 0
        self.missed = []                # those: (the place's last user, addresses of its rows)
        self.claimed, self.last_word = -1, 0    # when the last tile was claimed, its last word came
        # Of the look-ups that missed last, the oldest first: when the first claim was a clock off,
        # and the clocks (from, to) in which claims waited for credit.
        self.loads, self.waits = deque([-1, -1], 2), deque([(), (), ()], 3)

    def reach(self, i):
        """Look-up i misses; all look-ups before it are known."""
        if i == self.current:
            return
        self.finish(i)
        self.current = self.port.known = i
        self._write_until(i)
        self._make_room(i - 1)

    def finish(self, i):
        """All tiles that the present look-up misses are known, and none of those up to i misses
        any: these wait for their coordinates."""
        self.close()
        self.current = -1
        while self.coordinates and self.coordinates[0][0] <= i:
            j, lag = self.coordinates.popleft()
            self.port.known = j
            self._write_until(j)
            self._make_room(j - 1)
            self.lost = max(self.lost, self.push_lag - lag - self.timing.lead)
            self.push_lag = max(self.push_lag, lag + self.lost)
            self.read.step(j, self.push_lag + self.timing.push_to_retire)

    def _leave(self, i):
        """Look-up i, which misses tiles, leaves the tag stage."""
        arrived = clock = i + self.push_lag
        for victim, _ in self.missed:
            # The place may be replaced once its last user, or the one in flight of the same number
            # modulo the sequence, has read its window. Of older ones that was so long ago that
            # i waits for nothing: i - pending has read its window before i is pushed.
            if victim < 0:
                victim = _RESET_USER
            user = victim + (i - 1 - victim) // self.wrap * self.wrap
            if user >= i - self.pending - self.timing.retire_to_replace:
                clock = max(clock, self.read.clock(user) + self.timing.retire_to_replace)
        self.interlock += clock - arrived
        # Two may wait for their claims while those of a third are made.
        leaves = max(clock, self.loads[0] + 1)
        self.credit += sum(max(0, min(end, leaves) - max(begin, clock))
                           for begin, end in self.waits[0])
        self.push_lag = leaves - i

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
        """All tiles that the present look-up misses are known."""
        i = self.current
        if i < 0:
            return
        self._leave(i)
        self._make_room(i)
        self._claim(i + self.push_lag + self.timing.push_to_claim)
        self.read.step(i, max(self.last_word + self.timing.fill_to_retire - i,
                              self.push_lag + self.timing.push_to_retire))

    def _make_room(self, i):
        """Look-up i - pending has left before i is pushed."""
        read = self.read
        while True:
            read.settle(i - self.pending)
            while self.room + 1 < len(read.at) and read.at[self.room + 1] <= i - self.pending:
                self.room += 1
            lag = read.lag[self.room] - self.pending + self.timing.retire_to_push
            if self.writes is None or lag <= self.push_lag:
                break
            # Until then the writer may have held up more.
            self.push_lag = lag
            self._write_until(i)
        self.push_lag = max(self.push_lag, lag)

    def _write_until(self, i):
        """Place what is written before look-up i could ask for a tile."""
        if self.writes is not None:
            self.port.advance(i + self.push_lag + self.timing.push_to_claim
                              + self.timing.claim_to_command)
