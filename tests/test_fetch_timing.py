"""The predictor of clocks against the cache clock by clock, in plain Python."""

from collections import deque

import pytest

from ncdc_model.fetch.cache_options import CacheOptions
from ncdc_model.fetch.lookups import lookups
from ncdc_model.fetch.ports import memory_port
from ncdc_model.fetch.tags import accesses, misses
from ncdc_model.fetch.timing import FRAME_LATENCY, predict_clocks
from ncdc_model.memory_timing import LatencyMemory, memory_timing
from test_fetch_tags import random_windows, walking_windows

PITCH = 512


def clocked(boxes, missed, options, latency, words):
    """Clock in which the last window is read; the memory gives a word per clock after ``latency``.

    One turn of the loop is one clock; what is decided in it takes effect in the next one.
    """
    todo = deque(range(len(boxes)))
    claims = {}
    for i, victim in zip(missed.lookup.tolist(), missed.victim.tolist()):
        claims.setdefault(i, deque()).append(victim)
    counts = {i: len(of) for i, of in claims.items()}
    wrap = 1 << options.sequence_bits
    pushed, pending, retired = 0, deque(), 0
    commands, words_due = deque(), deque()      # clock of a command's first chance, of a word
    beats, outstanding, tokens = 0, 0, 0
    later = {}                                  # clock: events
    clock = last_word = last_retire = 0

    def at(when, event):
        later.setdefault(when, []).append(event)

    retired_seen = 0                            # what the tag stage's busy flags know
    while retired < len(boxes):
        for event in later.pop(clock, ()):
            if event == "credit":
                outstanding -= 1
            elif event == "token":
                tokens += 1
            elif event == "retired":
                retired_seen += 1
        # Memory.
        if commands and commands[0] <= clock:
            commands.popleft()
            for _ in range(words):
                last_word = max(last_word + 1, clock + latency)
                words_due.append(last_word)
        if words_due and words_due[0] == clock:
            words_due.popleft()
            beats += 1
            if beats % (4 * words) == 0:
                at(clock + 1, "credit")
                at(clock + 3, "token")
        # Oldest pending look-up.
        if pending and pending[0][1] <= clock and tokens >= counts.get(pending[0][0], 0):
            tokens -= counts.get(pending.popleft()[0], 0)
            retired += 1
            last_retire = clock
            at(clock + 2, "retired")
            if not todo and retired == len(boxes):
                break
        # Tag stage.
        if todo:
            i = todo[0]
            due = claims.get(i)
            if due and outstanding < options.outstanding:
                victim = due[0]
                window = i - retired_seen
                if not (victim - retired_seen) % wrap < window:
                    due.popleft()
                    outstanding += 1
                    commands.extend(clock + 5 + row for row in range(4))
            if not due and pushed - retired + (last_retire == clock) < options.pending:
                todo.popleft()
                pushed += 1
                pending.append((i, clock + 3))
        clock += 1
    return clock


@pytest.mark.parametrize("make", [random_windows, walking_windows])
@pytest.mark.parametrize("tiles,pending,outstanding", [(16, 8, 2), (64, 32, 4), (256, 128, 16)])
@pytest.mark.parametrize("latency,words", [(1, 4), (30, 1), (100, 2)])
def test_clocks_are_those_of_the_loop(make, tiles, pending, outstanding, latency, words):
    options = CacheOptions(tiles, pending=pending, outstanding=outstanding)
    boxes = lookups(make(tiles, (48, 40)))
    missed = misses(accesses(boxes), options, 1)
    memory = LatencyMemory(latency=(latency, latency))
    predicted = predict_clocks(missed, boxes, options, memory, 128 // words, pitch=PITCH)
    assert predicted.clocks - FRAME_LATENCY == pytest.approx(
        clocked(boxes, missed, options, latency, words), rel=.005)
