"""The predictor of clocks compared with the cache clock by clock, in plain Python."""

from collections import deque

import pytest

from ncdc_model.planner.corrector_timing import CorrectorTiming
from ncdc_model.planner.lookups import lookups
from ncdc_model.planner.memory_timing import LatencyMemory
from ncdc_model.planner.tags import accesses, misses
from ncdc_model.planner.timing import predict_clocks
from ncdc_model.planner.writes import frame_writes
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.frames import FrameAddresses
from ncdc_spec.geometry import Geometry
from ncdc_spec.hardware import Hardware
from windows import random_windows, walking_windows

PITCH = 512

# Of the loop below, and of no hardware in particular.
TIMING = CorrectorTiming(
    start=80, end=23, claim_to_command=10, fill_to_claim=2, fill_to_retire=4, push_to_retire=6,
    retire_to_push=1, retire_to_replace=3, push_to_claim=2, pixel_to_bus=4, row_to_lookup=9,
    end_to_interrupt=1, write_burst=16, queued_words=32, queued_pixels=32)


class ClockedCache:
    """The cache in plain Python: a call of ``step`` is a clock, its decisions count in the next.

    The memory gives a word per clock after ``latency`` clocks; a row of a tile is ``words`` words.
    """

    def __init__(self, boxes, missed, options, latency, words):
        self.lookups, self.options, self.latency, self.words = len(boxes), options, latency, words
        self.todo = deque(range(len(boxes)))
        self.victims = {}
        for i, victim in zip(missed.lookup.tolist(), missed.victim.tolist()):
            # What the slot's entry holds; that of an empty slot 0, from the reset.
            self.victims.setdefault(i, []).append(0 if victim == -1 else victim)
        self.to_claim = 0               # tiles of the look-up whose tiles are claimed
        self.waiting = deque()          # tiles of each of those after it, at most two
        self.pushed, self.pending, self.retired = 0, deque(), 0
        self.retired_seen = 0           # what the tag stage's busy flags know
        self.commands = deque()         # first clock in which each command may go
        self.words_due = deque()        # clock of each word
        self.beats, self.outstanding, self.tokens = 0, 0, 0
        self.later = {}                 # clock: names of the counters that change
        self.clock = self.last_word = self.last_retire = 0

    def at(self, when, counter, step):
        self.later.setdefault(when, []).append((counter, step))

    def step(self):
        for counter, step in self.later.pop(self.clock, ()):
            setattr(self, counter, getattr(self, counter) + step)
        self.memory()
        self.oldest_pending()
        space = len(self.waiting) < 2
        if self.to_claim and self.outstanding < self.options.outstanding:
            self.to_claim -= 1
            self.outstanding += 1
            self.commands.extend(self.clock + 10 + row for row in range(4))
        if not self.to_claim and self.waiting:
            self.to_claim = self.waiting.popleft()
        if self.todo:
            self.tag_stage(space)
        self.clock += 1

    def memory(self):
        if self.commands and self.commands[0] <= self.clock:
            self.commands.popleft()
            for _ in range(self.words):
                self.last_word = max(self.last_word + 1, self.clock + self.latency)
                self.words_due.append(self.last_word)
        if self.words_due and self.words_due[0] == self.clock:
            self.words_due.popleft()
            self.beats += 1
            if self.beats % (4 * self.words) == 0:
                self.at(self.clock + 2, "outstanding", -1)
                self.at(self.clock + 4, "tokens", 1)

    def oldest_pending(self):
        if not self.pending or self.pending[0][1] > self.clock:
            return
        needed = len(self.victims.get(self.pending[0][0], ()))
        if self.tokens >= needed:
            self.pending.popleft()
            self.tokens -= needed
            self.retired += 1
            self.last_retire = self.clock
            self.at(self.clock + 3, "retired_seen", 1)

    def tag_stage(self, space_for_claims):
        i = self.todo[0]
        victims = self.victims.get(i, ())
        space = self.options.pending - (self.last_retire == self.clock)
        clear = all((victim - self.retired_seen) % (1 << self.options.sequence_bits)
                    >= i - self.retired_seen for victim in victims)
        if self.pushed - self.retired < space and (
                not victims or clear and space_for_claims):
            self.todo.popleft()
            self.pushed += 1
            self.pending.append((i, self.clock + 6))
            if victims:
                self.waiting.append(len(victims))


def clocked(boxes, missed, options, latency, words):
    """Clock in which the last window is read."""
    cache = ClockedCache(boxes, missed, options, latency, words)
    while cache.retired < len(boxes):
        cache.step()
    return cache.last_retire


@pytest.mark.parametrize("make", [random_windows, walking_windows])
@pytest.mark.parametrize("tiles,pending,outstanding", [(16, 8, 2), (64, 32, 4), (256, 128, 16)])
@pytest.mark.parametrize("latency,words", [(1, 4), (30, 1), (100, 2)])
def test_clocks_are_those_of_the_loop(make, tiles, pending, outstanding, latency, words):
    options = CacheOptions(tiles, pending=pending, outstanding=outstanding)
    boxes = lookups(make(tiles, (48, 40)))
    missed = misses(accesses(boxes), options, 1)
    memory = LatencyMemory(latency=(latency, latency))
    hardware = Hardware(data_width=128 // words, cache=options)
    predicted = predict_clocks(missed, boxes, hardware, memory, TIMING, FrameAddresses(0, 0, PITCH))
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
    for number, row_start, _, last in words:
        if not bursts or len(bursts[-1]) == 16 or strip and row_start:
            bursts.append([])
        bursts[-1].append((number, last))
    found = []
    for burst in bursts:
        blocks = {}
        for number, _ in burst:
            blocks.setdefault(number * word // max(block, word), []).append(number)
        found += [(numbers[0] * word, len(numbers), burst[-1][1]) for numbers in blocks.values()]
    return found


@pytest.mark.parametrize("data_width,block", [(32, 16), (32, 1), (128, 16), (64, 16)])
@pytest.mark.parametrize("strip", [0, 32])
def test_writes_are_those_of_a_loop(data_width, block, strip):
    made = frame_writes(Geometry(80, 8, 80, 8), Hardware(data_width=data_width, strip=strip),
                        block, 0, TIMING)
    expected = words_of(80, 8, strip, data_width // 8, block)
    assert [access[:3] for access in made.accesses()] == expected
    assert made.count == len(expected)
