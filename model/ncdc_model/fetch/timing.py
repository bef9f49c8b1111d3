"""How many clocks the cache takes for a frame, from its misses alone."""

from collections import deque
from dataclasses import dataclass

from ncdc_model.fetch.cache_options import TILE_HEIGHT, TILE_WIDTH
from ncdc_model.fetch.lags import Lags
from ncdc_model.fetch.ports import memory_port

__all__ = ["Clocks", "FRAME_LATENCY", "START_LATENCY", "predict_clocks"]

# Clocks of ``ncdc_hdl.backend.cache``, from one event to the earliest next one.
_CLAIM_TO_COMMAND = 10      # a tile is claimed, its first read command is on the bus
_FILL_TO_CLAIM = 2          # its last word is on the port, another tile may be claimed
_FILL_TO_RETIRE = 4         # its last word is on the port, the window that waits is read
_PUSH_TO_RETIRE = 6         # a look-up leaves the tag stage, its window is read
_RETIRE_TO_PUSH = 1         # a window is read, there is room for another look-up
_RETIRE_TO_CLAIM = 3        # a window is read, its tiles may be replaced

# From the start of a frame to its first look-up, and from its last window read to its last pixel:
# most of it the network, whose latency differs by some clocks from one to the next; to the first
# look-up alone.
FRAME_LATENCY = 107
START_LATENCY = 69


@dataclass(frozen=True)
class Clocks:
    """Where the clocks of a frame go.

    Parameters
    ----------
    clocks : int
        From start to last pixel.
    interlock, credit : int
        Clocks that claims waited for a place still in use, for a tile to arrive before more may
        be asked for.
    read : Lags
        When each look-up is read, from the first look-up on.
    """
    clocks: int
    interlock: int
    credit: int
    read: Lags


def predict_clocks(missed, boxes, options, memory, data_width, *, base=0, pitch, writes=None,
                   progress=lambda done, total: None):
    """:class:`Clocks` of a frame.

    Jumps from miss to miss: between them one look-up enters and one leaves per clock. Of each
    look-up only two times count: when it leaves the tag stage (push) and when its window is read
    (retire). Both are kept as lags behind its number, which never fall::

        push(i)   = i + a(i)        push(i)   >= push(i-1) + 1, retire(i - pending) + 1
        retire(i) = i + b(i)        retire(i) >= retire(i-1) + 1, push(i) + 6, last word + 4

    Parameters
    ----------
    missed : Misses
    boxes : Lookups
    options : CacheOptions
    memory : LatencyMemory or DramMemory
    data_width : int
        Bits of a memory word.
    base, pitch : int
        Of the raw frame in bytes.
    writes : FrameWrites, optional
        What goes to the same memory; absent if pixels are taken as they come (a stream).
    progress : callable
        Called with (misses done, misses) now and then.
    """
    if writes is not None and len(boxes) < boxes.pixels:
        writes = writes.by_lookup(boxes.pixel)
    read = Lags(_PUSH_TO_RETIRE)            # b
    port = memory_port(memory, data_width, writes, read)
    words = 8 * TILE_WIDTH // data_width
    pending, wrap = options.pending, 1 << options.sequence_bits
    push_lag = 0                            # a, of the last look-up that missed
    room = 0                                # step of b that holds for the one that makes room
    fills = deque([-_FILL_TO_CLAIM] * options.outstanding, options.outstanding)
    command = 0                             # edge at which the bus is free
    interlock = credit = 0
    current, claimed, last_word = -1, 0, 0
    total = len(missed)

    def make_room(i):
        """Look-up i - pending has left before i is pushed."""
        nonlocal push_lag, room
        while True:
            read.settle(i - pending)
            while room + 1 < len(read.at) and read.at[room + 1] <= i - pending:
                room += 1
            lag = read.lag[room] - pending + _RETIRE_TO_PUSH
            if writes is None or lag <= push_lag:
                break
            # Until then the writer may have held up more.
            push_lag = lag
            port.advance(i + push_lag + _CLAIM_TO_COMMAND)
        push_lag = max(push_lag, lag)

    def close(i):
        """Look-up i has claimed all its tiles."""
        nonlocal push_lag
        make_room(i)
        push_lag = max(push_lag, claimed - i)
        read.step(i, max(last_word + _FILL_TO_RETIRE - i, push_lag + _PUSH_TO_RETIRE))

    def reach(i):
        """All look-ups before i are known."""
        port.known = i
        if writes is not None:
            port.advance(i + push_lag + _CLAIM_TO_COMMAND)

    columns = (missed.columns * TILE_WIDTH + base).tolist()
    lines = (missed.rows * (TILE_HEIGHT * pitch)).tolist()
    rows = [row * pitch for row in range(TILE_HEIGHT)]
    for k, (i, victim, column, line) in enumerate(zip(
            missed.lookup.tolist(), missed.victim.tolist(), columns, lines)):
        if i != current:
            if current >= 0:
                close(current)
            current = i
            reach(i)
            make_room(i - 1)
            claimed = i + push_lag - 1
        claim = claimed + 1
        # The place may be replaced once its last user, or the one in flight of the same number
        # modulo the sequence, has read its window.
        user = victim + (i - 1 - victim) // wrap * wrap
        if user >= i - pending:
            free = read.clock(user) + _RETIRE_TO_CLAIM
            if free > claim:
                interlock += free - claim
                claim = free
        free = fills[0] + _FILL_TO_CLAIM
        if free > claim:
            credit += free - claim
            claim = free
        claimed = claim
        clock = max(command, claim + _CLAIM_TO_COMMAND)
        for row in rows:
            accepted, last_word = port.read(clock, column + line + row, words)
            clock = accepted + 1
        command = clock
        fills.append(last_word)
        if k % 4096 == 0:
            progress(k, total)
    if current >= 0:
        close(current)
    if writes is not None:
        clocks = port.finish() + START_LATENCY
    else:
        clocks = read.clock(len(boxes) - 1) + FRAME_LATENCY
    return Clocks(clocks, interlock, credit, read)
