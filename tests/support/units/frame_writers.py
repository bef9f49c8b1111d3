"""Words of frames and their bursts: what lands in memory, which frames are good."""

import numpy as np

from ncdc_hdl.camera.layouts import SAMPLES, Kind
from pipelines import run_bench

__all__ = ["check_burst_writer", "check_frame_writer"]

_END = 1 << 32
_TALL = 4           # number of a frame with many rows


class _Frame:
    """Entries of a frame, its area, and what must become of both."""

    def __init__(self, rng, word, number):
        self.rng, self.kind = rng, int(rng.integers(18))
        self.width, self.height = int(rng.integers(1, 60)), int(rng.integers(1, 7))
        row = -(-self.width // word) * word
        self.pitch = row + word * int(rng.integers(0, 5)) * int(rng.integers(2))
        if self.kind == 1 and row > word:
            self.pitch = row - word
        if number % 9 == 8:
            self.width, self.height = int(rng.integers(1000, 8100)), 1
            row = -(-self.width // word) * word
            self.pitch = 8184
        if number == _TALL:
            self.kind, self.width, self.height, row, self.pitch = 0, 4, 1100, word, word
        used = self.pitch * (self.height - 1) + row
        base = int(rng.integers(0, (_END - 1 - used) // word)) >> int(rng.choice([0, 0, 8, 16]))
        self.base = base * word
        self.limit = self.base + used + word * int(rng.integers(3))
        if self.kind == 2:
            self.limit = self.base + max(1, used - word * int(rng.integers(1, 4)))
        self.row_bytes = row
        self._entries()

    def _entries(self):
        rng, count = self.rng, -(-self.width // SAMPLES)
        rows = self.height + {3: 1, 4: -1}.get(self.kind, 0)
        self.entries, self.bytes, self.right = [(Kind.BEGIN, int(rng.integers(_END)))], {}, True
        address = self.base
        for y in range(rows):
            entries = count
            if self.kind == 5 and y == rows - 1:
                entries = max(1, count + int(rng.choice([-1, 1])))
            fits = address + self.row_bytes <= self.limit and self.row_bytes <= self.pitch
            self.right &= entries == count and fits
            # The last row of such a frame has no end.
            cut = self.kind == 6 and y == rows - 1
            for k in range(entries):
                data = int(rng.integers(_END))
                kind = Kind.ROW_END if k == entries - 1 and not cut else Kind.WORD
                self.entries += [(kind, data)] + [(Kind.ALIVE, 5)] * int(rng.random() < .1)
                if fits and y < self.height and k < count:
                    self.bytes[address + SAMPLES * k] = data
            if fits and y < self.height:
                address += self.pitch
        self.right &= rows == self.height and self.kind != 6
        self.report = 0
        if rng.random() < .2:
            self.report = int(rng.integers(_END)) if rng.random() < .7 else 1 << rng.integers(16)
        elif rng.random() < .3:
            self.report = int(rng.integers(1 << 16)) << 16      # only missed frames
        if self.kind != 7:      # else the next frame begins without an end of this one
            self.entries.append((Kind.END, self.report))
        self.good = self.right and self.report & 0xFFFF == 0 and self.kind not in (7, 8)


class _Memory:
    """What takes the words: with pauses, and each row's end some clocks later."""

    def __init__(self, rng):
        self.rng, self.bytes, self.due, self.stall = rng, {}, [], 0.0

    def done(self):
        """Whether the last word of one more row is in memory."""
        self.due = [clocks - 1 for clocks in self.due]
        if self.due and self.due[0] <= 0:
            self.due.pop(0)
            return 1
        return 0

    def take(self, word):
        """A word that is taken."""
        assert word.address % 8 == 0 and word.end == word.last
        for k in range(2):
            enable = word.enable >> 4 * k & 15
            assert enable in (0, 15) and word.void == (word.enable == 0)
            if enable:
                self.bytes[word.address + 4 * k] = word.data >> 32 * k & _END - 1
        if word.last:
            later = self.due[-1] if self.due else 0
            self.due.append(max(later, 0) + int(self.rng.integers(1, 12)))


def check_frame_writer(dut, frames=90, seed=11):
    """Frames in areas anywhere, with wrong rows, reports, a clock that stops, writes that fail.

    ``dut``: :class:`simulations.traces.Alone` with a frame writer of words of 64 bits.
    """
    rng = np.random.default_rng(seed)
    totals = dict.fromkeys(("lines", "cut", "overflows", "bad", "missed", "stopped"), 0)
    outcome = {0: 0, 1: 0}

    async def bench(ctx):
        unended, missed = False, 0
        for number in range(frames):
            frame = _Frame(rng, 8, number)
            if number % 13 == 12:
                ctx.set(dut.i.valid, 0)
                ctx.set(dut.reset, 1)
                await ctx.tick()
                ctx.set(dut.reset, 0)
                totals.update(dict.fromkeys(totals, 0))
                unended, missed = False, 0
            run = _Run(dut, frame, _Memory(rng), unended)
            ends = await run.frame(ctx)
            outcome[ends] += 1
            if frame.kind not in (7, 8):
                for name, bits, at in (("cut", 1, 0), ("overflows", 1, 1), ("bad", 1, 2),
                                       ("lines", 13, 3)):
                    totals[name] += frame.report >> at & (1 << bits) - 1
                totals["missed"] += (frame.report >> 16) - missed & 0xFFFF
                missed = frame.report >> 16
            totals["stopped"] += frame.kind == 8
            unended = frame.kind == 7
            counts = ctx.get(dut.counts)
            assert {name: getattr(counts, name) for name in totals} == totals, number

    run_bench(dut, bench)
    assert min(outcome.values()) > frames // 5, outcome


class _Run:
    """A frame that a writer gets."""

    def __init__(self, dut, frame, memory, unended):
        self.dut, self.frame_, self.memory, self.unended = dut, frame, memory, unended
        self.rng = frame.rng
        memory.stall = float(self.rng.choice([0, .3, .8])) if frame.height < 9 else 0.0

    async def frame(self, ctx):
        """Give the entries, and compare; whether the frame is good."""
        frame, dut, rng = self.frame_, self.dut, self.rng
        gap, failed, entries = float(rng.choice([0, .3])), False, list(frame.entries)
        stops = frame.kind == 8
        if stops:
            entries = entries[:int(rng.integers(1, len(entries)))]
        elif frame.kind == 7:
            entries.append((Kind.BEGIN, 0))     # it ends this frame, and stays for the next one
        limit = int(rng.integers(20, 90)) if stops else int(rng.choice([0, 300, _END - 1]))
        ctx.set(dut.limit, limit)
        ctx.set(dut.area, {"base": int(rng.integers(_END)), "limit": 5, "pitch": 1, "width": 2})
        offered, fails = self.unended, False
        for _ in range(40_000):
            if not offered and entries and rng.random() >= gap:
                ctx.set(dut.i.payload, dict(zip(("kind", "data"), entries[0])))
                ctx.set(dut.i.valid, 1)
                offered = True
            fails = frame.kind == 9 and not failed and rng.random() < .05 and len(
                entries) < len(frame.entries) - 1
            failed |= fails
            ctx.set(dut.failed, int(fails))
            ctx.set(dut.done, self.memory.done())
            ctx.set(dut.o.ready, int(rng.random() >= self.memory.stall))
            *_, taken, begins, ends, good, valid, ready, word = await ctx.tick().sample(
                dut.i.ready, dut.begins, dut.ends, dut.good, dut.o.valid, dut.o.ready,
                dut.o.payload)
            if begins:
                ctx.set(dut.area, {name: getattr(frame, name) for name in (
                    "base", "limit", "pitch", "width", "height")})
            if offered and taken:
                entries.pop(0)
                offered = False
                ctx.set(dut.i.valid, 0)
            if valid and ready:
                self.memory.take(word)
            if ends:
                ctx.set(dut.done, 0)
                ctx.set(dut.failed, 0)
                return self._compare(good, failed, stops)
        raise AssertionError("the frame does not end")

    def _compare(self, good, failed, stops):
        """Compare the bytes in memory; of a frame that stops they are some of its own."""
        frame, found = self.frame_, self.memory.bytes
        assert good == (frame.good and not failed), (frame.kind, good, failed)
        if stops:
            assert found.items() <= frame.bytes.items()
        else:
            assert found == frame.bytes, frame.kind
        return good


class _Bus:
    """A memory at the bus of a burst writer: whole bursts, and answers to them."""

    def __init__(self, rng, answers):
        self.rng, self.answers = rng, answers
        self.bytes, self.bursts, self.left, self.address = {}, [], 0, 0
        self.rate = .1          # of the answers
        self.due, self.held, self.failed = [], None, 0

    def drive(self, ctx, bus, wait):
        """Inputs of a clock; whether a burst is answered."""
        ctx.set(bus.waitrequest, int(self.rng.random() < wait))
        if not self.answers:
            return 0
        answer = bool(self.due) and self.rng.random() < self.rate
        ctx.set(bus.writeresponsevalid, int(answer))
        response = int(self.rng.choice([0, 0, 0, 1, 2, 3]))
        ctx.set(bus.response, response)
        if answer:
            self.due.pop(0)
            self.failed += response != 0
        return answer

    def take(self, beat, waiting):
        """A beat on the bus."""
        assert self.held is None or beat == self.held, "a beat changed while it waits"
        self.held = beat if waiting else None
        if waiting:
            return
        address, count, data, enable = beat
        if self.left == 0:
            assert count and address % 8 == 0
            self.left, self.address = count, address
            self.bursts.append((address, count))
            if self.answers:
                self.due.append(address)
        for k in range(8):
            if enable >> k & 1:
                self.bytes[self.address + k] = data >> 8 * k & 0xFF
        self.left, self.address = self.left - 1, self.address + 8


def _words(rng, most):
    """Words of a frame, the bytes that they set, and its bursts."""
    words, content, bursts = [], {}, []
    address = int(rng.integers((_END >> 3) - 4 * most)) << 3
    # Many short rows fill the queue of bursts.
    rows, longest = (int(rng.integers(1, 5)), 3 * most) if rng.random() < .7 else (24, 4)
    for _ in range(rows):
        count = int(rng.integers(1, longest))
        void = rng.random() < .2
        if void and rng.random() < .5:      # nothing is left for the last burst
            count = 1 + most * int(rng.integers(longest // most + 1))
        for k in range(count):
            data, enable = int(rng.integers(1 << 63)) << 1 | k & 1, int(rng.integers(256))
            last = k == count - 1
            words.append({"data": data, "enable": enable, "address": address + 8 * k,
                          "end": last, "last": last, "void": last and void})
            if not (last and void):
                content |= {address + 8 * k + b: data >> 8 * b & 0xFF for b in range(8)
                            if enable >> b & 1}
        count -= void
        bursts += [(address + 8 * k, min(most, count - k)) for k in range(0, count, most)]
        address = (address + 8 * count + 8 * int(rng.integers(1 << 8))) % (_END - 8 * 4 * most)
    return words, content, bursts


def check_burst_writer(dut, frames=100, seed=12):
    """Words in rows of any length, with waits, answers and resets of either side or both.

    Without a reset each byte, burst and answer is the right one. After one the bus has whole
    bursts, and no byte that was not given. The words of a frame that come at once are all written.
    ``dut``: :class:`simulations.traces.Alone` with a burst writer of words of 64 bits.
    """
    rng = np.random.default_rng(seed)
    answers, most = dut.part.pending, dut.part.burst
    memory = _Bus(rng, answers)

    async def bench(ctx):
        for number in range(frames):
            words, content, bursts = _words(rng, most)
            cut = int(rng.integers(5, 60)) if number % 4 == 3 else None
            memory.bytes, memory.bursts, memory.failed = {}, [], 0
            memory.rate = float(rng.choice([.02, .1, .5]))
            rows = sum(word["last"] for word in words)
            later = _words(rng, most) if cut else ([], {}, [])
            done, failed = await _burst_frame(ctx, dut, memory, words, rng, cut,
                                              later[0] if cut else rows)
            if cut is None:
                assert memory.bytes == content and memory.bursts == bursts, number
                assert done == rows and failed == memory.failed, number
            else:
                assert later[1].items() <= memory.bytes.items() <= (content | later[1]).items()
                assert done == sum(word["last"] for word in later[0]), number

    run_bench(dut, bench)


async def _burst_frame(ctx, dut, memory, words, rng, cut, then):
    """Give the words, with a reset after ``cut`` clocks; (rows done, bursts failed).

    ``then``: rows of the words, or the words of the frame after the reset.
    """
    wait, gap = float(rng.choice([0, .3, .9])), float(rng.choice([0, .4]))
    waiting, offered, done, failed, quiet, clock = list(words), False, 0, 0, 0, 0
    sides = 1 + int(rng.integers(2)) if cut else 0      # the writer alone, or the memory as well
    rows = 0 if cut else then
    early = int(rng.choice([0, 9]))     # words of a burst that are to come when the writer is reset
    while quiet < 12:
        if not offered and waiting and rng.random() >= gap:
            ctx.set(dut.i.payload, waiting[0])
            ctx.set(dut.i.valid, 1)
            offered = True
        if sides == 1 and clock == cut and memory.left < early and waiting:
            cut += 1
        reset = cut is not None and cut <= clock < cut + 2
        ctx.set(dut.reset, int(reset))
        memory_rst = sides == 2 and cut - 2 <= clock < cut + 3
        ctx.set(dut.memory_rst, int(memory_rst))
        answered = memory.drive(ctx, dut.bus, wait)
        _, _, ready, write, waits, ended, fails, *beat = await ctx.tick().sample(
            dut.i.ready, dut.bus.write, dut.bus.waitrequest, dut.done, dut.failed,
            dut.bus.address, dut.bus.burstcount, dut.bus.writedata, dut.bus.byteenable)
        if offered and ready and not reset:
            waiting.pop(0)
        if offered and (ready or reset):
            offered = False
            ctx.set(dut.i.valid, 0)
        if memory_rst:
            memory.left, memory.held, memory.due = 0, None, []
        elif write:
            memory.take(tuple(beat), waits)
        if reset:
            waiting, rows, ended, done = list(then), sum(word["last"] for word in then), 0, 0
        done, failed, clock = done + ended, failed + fails, clock + 1
        quiet = 0 if waiting or offered or write or memory.due or answered or memory.left or (
            done < rows) or cut is not None and clock <= cut + 3 else quiet + 1
        assert clock < 8000, (len(waiting), done, rows)
    return done, failed
