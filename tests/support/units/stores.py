"""Buffers of frames, their readers, and the control of the corrector between two stores."""

import numpy as np

from pipelines import run_bench

__all__ = ["check_frame_store", "check_run_control", "check_store_reader"]


class _Store:
    """A reference model of the frame store: what each request does in its clock."""

    def __init__(self, readers, buffers):
        self.count, self.buffers = readers, buffers
        self.reset()

    def reset(self):
        """The state after a reset."""
        self.busy = self.some = self.came = self.begun = self.bad = self.taken = 0
        self.buffer = self.newest = 0
        self.readers = [{"held": 0, "lost": 0, "buffer": 0, "left": 0} for _ in range(self.count)]

    def free(self):
        """Buffers that no reader has."""
        used = {self.newest} if self.some else set()
        used |= {self.buffer} if self.busy else set()
        used |= {one["buffer"] for one in self.readers if one["held"]}
        return [k for k in range(self.buffers) if k not in used]

    def clock(self, given, frames):
        """A clock with these inputs; ``frames`` gets what is stored with each buffer."""
        some, newest, busy, buffer = self.some, self.newest, self.busy, self.buffer
        free = self.free()
        for k, (one, (claim, release)) in enumerate(zip(self.readers, given["readers"])):
            if claim:
                follow = k == 0 and given["follow"]
                one.update(held=busy if follow else some, lost=0, left=given["limit"],
                           buffer=buffer if follow else newest)
            elif release:
                one.update(held=0, lost=0)
            elif one["held"] and given["limit"] and one["left"] == 0:
                one.update(held=0, lost=1)
                self.taken += 1
            one["left"] -= 1
        self.came = 0
        if given["begins"] and not busy:
            self.busy, self.buffer, self.begun = 1, free[0], self.begun + 1
            frames[free[0]] = given["about"]
        elif given["ends"] and busy:
            self.busy = 0
            if given["good"]:
                self.newest, self.some, self.came = buffer, 1, 1
            else:
                self.bad += 1


def check_frame_store(dut, clocks=7200, seed=13):
    """Random requests of the writer and of all readers, compared with a reference model.

    ``dut``: :class:`simulations.traces.Alone` with a frame store.
    """
    rng, part = np.random.default_rng(seed), dut.part
    model, frames = _Store(len(part.readers), part.buffers), {}
    given = {"limit": 0, "follow": 0}

    async def bench(ctx):
        busy_rate, looked = .1, None
        for clock in range(clocks):
            if clock % 100 == 0:    # a limit of any bits, and of few clocks
                given["limit"] = (int(rng.choice([0, 1, 2, 20, 60])) if clock % 300 == 0 else
                                  (1 << clock // 100 % 32) + int(rng.integers(12)))
                # Readers that hold for ever, until the clocks in which all requests are frequent.
                busy_rate = float(rng.choice([.02, .05, .1, .5]))
            if clock > 3600:    # another limit in each clock: 0, one bit, or few clocks
                given["limit"] = int(rng.choice([0, 1 << int(rng.integers(32)),
                                                 int(rng.integers(1, 9))], p=[.2, .2, .6]))
                busy_rate = .1
            if clock > 5000:    # whole times of a limit, then the first clocks of each bit's
                given["limit"], busy_rate = 613 + clock // 650 * 2, float(clock % 650 == 100)
            if clock > 6600:
                given["limit"], busy_rate = (1 << clock // 16 % 32) + 3, float(clock % 16 == 0)
            ctx.set(dut.limit, given["limit"])
            given.update({
                "begins": rng.random() < .2, "ends": rng.random() < .2,
                "good": rng.random() < .7, "follow": int(rng.random() < .5),
                "about": {"number": int(rng.integers(1 << 32)),
                          "time": int(rng.integers(1 << 63)) * 2 + clock % 2},
                "readers": [(rng.random() < busy_rate, rng.random() < busy_rate)
                            for _ in part.readers]})
            reset = rng.random() < .004 and clock <= 5000
            for name in ("begins", "ends", "good", "follow", "about"):
                value = given[name]
                ctx.set(getattr(dut, name), value if name == "about" else int(value))
            for one, (claim, release) in zip(dut.readers, given["readers"]):
                ctx.set(one.claim, int(claim))
                ctx.set(one.release, int(release))
            look = int(rng.integers(part.buffers))
            for each in dut.looks:
                ctx.set(each.buffer, look)
            ctx.set(dut.reset, int(reset))
            found = ctx.get(dut.looks[-1].frame)
            if looked in frames:
                assert {"number": found.number, "time": found.time} == frames[looked], clock
            _check_store(ctx, dut, model)
            await ctx.tick()
            looked = look if frames.get(look) else None
            before = frames.get(look)
            model.clock(given, frames)
            if frames.get(look) is not before:      # it is written in the clock of the look
                looked = None
            if reset:
                model.reset()

    run_bench(dut, bench)


def _check_store(ctx, dut, model):
    """Compare all outputs that mean something with the model."""
    for name in ("busy", "some", "came", "begun", "bad", "taken"):
        assert ctx.get(getattr(dut, name)) == getattr(model, name), name
    assert not model.busy or ctx.get(dut.buffer) == model.buffer
    assert not model.some or ctx.get(dut.newest) == model.newest
    for one, wanted in zip(dut.readers, model.readers):
        assert (ctx.get(one.held), ctx.get(one.lost)) == (wanted["held"], wanted["lost"])
        assert not wanted["held"] or ctx.get(one.buffer) == wanted["buffer"]


def check_store_reader(dut, clocks=1500, seed=14):
    """Random requests: one claim, a release of the other store, the state of the last claim's."""
    rng, which = np.random.default_rng(seed), 0

    async def bench(ctx):
        nonlocal which
        for _ in range(clocks):
            raw, corrected, release, reset = (int(rng.random() < rate)
                                              for rate in (.2, .2, .2, .02))
            given = [[int(value) for value in rng.integers(0, 2, 2)]
                     + [int(rng.integers(1 << len(dut.stores[k].buffer)))] for k in range(2)]
            for name, value in (("claim_raw", raw), ("claim_corrected", corrected),
                                ("release", release), ("reset", reset)):
                ctx.set(getattr(dut, name), value)
            for store, values in zip(dut.stores, given):
                for name, value in zip(("held", "lost", "buffer"), values):
                    ctx.set(getattr(store, name), value)
            claims = [raw, int(corrected and not raw)]
            for store, claim in zip(dut.stores, claims):
                released = int((any(claims) or release) and not claim)
                assert (ctx.get(store.claim), ctx.get(store.release)) == (claim, released)
            state = ctx.get(dut.state)
            assert state.corrected == which
            assert [state.held, state.lost, state.buffer] == given[which]
            await ctx.tick()
            which = 0 if reset else claims[1] if any(claims) else which

    run_bench(dut, bench)


def check_run_control(dut, frames=240, seed=15):
    """Raw frames that come while the corrector is idle or busy, good or bad, taken away or not.

    ``dut``: :class:`simulations.traces.Alone` with a run control. The numbers of frames corrected,
    skipped and bad are those of the requests that were seen.
    """
    rng = np.random.default_rng(seed)
    control = _Control(dut, rng)

    async def bench(ctx):
        for number in range(frames):
            if number % 60 == 0:
                await control.settle(ctx)
            await control.frame(ctx, number)

    run_bench(dut, bench)
    assert control.corrected > frames // 4 and 0 < control.bad < control.corrected


class _Control:
    """Both stores and the corrector at a run control."""

    def __init__(self, dut, rng):
        self.dut, self.rng = dut, rng
        self.corrected = self.bad = self.follow = 0
        self.left = None        # clocks until the corrector ends its frame
        self.wrong = False      # something is wrong with the frame
        self.raw_over = False
        self.number, self.begun_count, self.bad_count = 0, 0, 0
        self.about = {"number": 0, "time": 0}

    async def settle(self, ctx):
        """Let a frame end, and choose the sizes and whether frames start early."""
        dut, rng = self.dut, self.rng
        ctx.set(dut.run, 0)
        for _ in range(80):
            await self.clock(ctx)
        self.follow = int(rng.integers(2))
        ctx.set(dut.follow, self.follow)
        for name, bits in (("raw_pitch", 13), ("raw_width", 13), ("raw_height", 13),
                           ("raw_bytes", 32), ("corrected_bytes", 32)):
            ctx.set(getattr(dut, name), int(rng.integers(1 << bits)))
        await self.clock(ctx, reset=int(rng.random() < .5))
        ctx.set(dut.run, 1)

    async def frame(self, ctx, number):
        """A raw frame."""
        rng = self.rng
        if rng.random() < .1:
            ctx.set(self.dut.run, int(rng.integers(2)))
        good = rng.random() < .7
        await self.clock(ctx, begun=1)
        for _ in range(int(rng.integers(1, 40))):
            await self.clock(ctx)
        await self.clock(ctx, ended=1, good=int(good))
        if good:
            await self.clock(ctx, came=1)
        for _ in range(int(rng.choice([0, 1, 2, 30]))):
            await self.clock(ctx)
        if number % 20 == 10:
            ctx.set(self.dut.run, 1)

    async def clock(self, ctx, reset=0, **pulses):
        """A clock in which these inputs are high."""
        dut, rng = self.dut, self.rng
        given = dict.fromkeys(("begun", "ended", "came"), 0) | {"good": int(rng.integers(2))}
        given |= pulses
        for name, value in given.items():
            ctx.set(getattr(dut, name), value)
        ctx.set(dut.reset, reset)
        over = self.left == 0
        faults = {"over": int(over), "cut": int(rng.random() < .2),
                  "fault": int(rng.random() < .01), "idle": int(self.left is None)}
        for name, value in faults.items():
            ctx.set(getattr(dut.corrector, name), value)
        held = int(rng.random() > .003)
        ctx.set(dut.held, held)
        for name in ("raw_base", "target_base"):
            ctx.set(getattr(dut, name), int(rng.integers(1 << 32)))
        self.about = {"number": int(rng.integers(1 << 32)), "time": 0}
        ctx.set(dut.about, self.about)
        names = ("claim", "release", "target_begins", "target_ends", "target_good")
        *_, claim, release, begins, ends, good, start, waits = await ctx.tick().sample(
            *(getattr(dut, name) for name in names), dut.corrector.start, dut.corrector.assigned)
        if reset:
            self.left, self.wrong = None, False
            self.number = self.begun_count = self.bad_count = 0
            return
        self._follow(given, faults, held, claim, waits)
        assert release == ends
        if begins:
            self.begun_count += 1
            self.pending = self.about["number"]
        if start:
            self.left = int(rng.choice([1, 5, 60]))
        elif over:
            self.left = None
        elif self.left is not None:
            self.left -= 1
        if ends:
            assert good == (not self.failed), "a frame is good or not"
            self.number, self.bad_count = self.pending, self.bad_count + (not good)
            self.corrected, self.bad = self.corrected + 1, self.bad + (not good)
        counts = [ctx.get(getattr(dut, name)) for name in ("number", "begun_count", "bad_count")]
        assert counts == [self.number, self.begun_count, self.bad_count]

    def _follow(self, given, faults, held, claim, assigned):
        """Whether what has come so far makes the frame under way a bad one."""
        if assigned:
            self.failed = self.wrong
            if given["ended"]:
                self.wrong |= not self.raw_over and not given["good"]
                self.raw_over = True
            self.wrong |= bool(faults["fault"]) or not held
            self.wrong |= bool(faults["over"] and faults["cut"])
        if claim:
            self.wrong, self.raw_over = False, not self.follow
