"""The predictor of clocks against the cache clock by clock, in plain Python."""

from collections import deque

import pytest

from ncdc_model.fetch.cache_options import CacheOptions
from ncdc_model.fetch.corrector_timing import CorrectorTiming
from ncdc_model.fetch.lookups import lookups
from ncdc_model.fetch.tags import accesses, misses
from ncdc_model.fetch.timing import predict_clocks
from ncdc_model.fetch.writes import frame_writes
from ncdc_model.geometry import Geometry
from ncdc_model.hardware import Hardware
from ncdc_model.interface.frames import FramePlaces
from ncdc_model.memory_timing import LatencyMemory
from windows import random_windows, walking_windows

PITCH = 512

# Of the loop below, and of no hardware in particular.
TIMING = CorrectorTiming(
    start=80, end=23, claim_to_command=10, fill_to_claim=2, fill_to_retire=4, push_to_retire=6,
    retire_to_push=1, retire_to_claim=3, pixel_to_bus=4, row_to_lookup=9, end_to_interrupt=1,
    write_burst=16, queued_words=32, queued_pixels=32)


def clocked(boxes, missed, options, latency, words):
    """Clock in which the last window is read; the memory gives a word per clock after ``latency``.

    One turn of the loop is one clock; what is decided in it takes effect in the next one.
    """
    todo = deque(range(len(boxes)))
    claims = {}
    for i, victim in zip(missed.lookup.tolist(), missed.victim.tolist()):
        # What the place's entry holds; that of an empty place 0, from the reset.
        claims.setdefault(i, deque()).append(0 if victim == -1 else victim)
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
                at(clock + 2, "credit")
                at(clock + 4, "token")
        # Oldest pending look-up.
        if pending and pending[0][1] <= clock and tokens >= counts.get(pending[0][0], 0):
            tokens -= counts.get(pending.popleft()[0], 0)
            retired += 1
            last_retire = clock
            at(clock + 3, "retired")
            if not todo and retired == len(boxes):
                break
        # Tag stage.
        if todo:
            i = todo[0]
            due = claims.get(i)
            if due and outstanding < options.outstanding:
                last_use = due[0]
                window = i - retired_seen
                if not (last_use - retired_seen) % wrap < window:
                    due.popleft()
                    outstanding += 1
                    commands.extend(clock + 10 + row for row in range(4))
            if not due and pushed - retired + (last_retire == clock) < options.pending:
                todo.popleft()
                pushed += 1
                pending.append((i, clock + 6))
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
    hardware = Hardware(data_width=128 // words, cache=options)
    predicted = predict_clocks(missed, boxes, hardware, memory, TIMING, FramePlaces(0, 0, PITCH))
    assert predicted.clocks - TIMING.start - TIMING.end == clocked(boxes, missed, options, latency,
                                                                   words)


def words_of(width, height, strip, word, block):
    """(address, words, last pixel of the burst) of each access, pixel by pixel."""
    order = [(u, v) for left in range(0, width, strip or width) for v in range(height)
             for u in range(left, min(width, left + (strip or width)))]
    # A word ends with its last byte, or with the row of a strip.
    words = []
    for number, (u, v) in enumerate(order):
        address = 4 * (v * width + u)
        fresh = not words or words[-1][0] != address // word or strip and u % strip == 0
        if fresh:
            words.append([address // word, u == 0 or strip and u % strip == 0, number, number])
        words[-1][3] = number
    bursts = []
    for place, row_start, _, last in words:
        if not bursts or len(bursts[-1]) == 16 or strip and row_start:
            bursts.append([])
        bursts[-1].append((place, last))
    found = []
    for burst in bursts:
        blocks = {}
        for place, _ in burst:
            blocks.setdefault(place * word // max(block, word), []).append(place)
        found += [(places[0] * word, len(places), burst[-1][1]) for places in blocks.values()]
    return found


@pytest.mark.parametrize("data_width,block", [(32, 16), (32, 1), (128, 16), (64, 16)])
@pytest.mark.parametrize("strip", [0, 32])
def test_writes_are_those_of_a_loop(data_width, block, strip):
    made = frame_writes(Geometry(80, 8, 80, 8), Hardware(data_width=data_width, strip=strip),
                        block, 0, TIMING)
    expected = words_of(80, 8, strip, data_width // 8, block)
    assert list(zip(made.address, made.words, made.last)) == expected
