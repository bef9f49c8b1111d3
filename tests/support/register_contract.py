"""The register agent with what it is joined to, a host at its bus, and what it promises."""

from amaranth import *
from amaranth.lib import wiring

from cameras import barrel_descriptor
from ncdc_hdl.frontend.valid import ValidTable
from ncdc_hdl.neural.banks import WeightBanks
from ncdc_hdl.registers.agent import Registers
from ncdc_hdl.registers.weight_store import in_memory
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.registers.register_map import CTRL_COMMIT, CTRL_START, TABLE, registers
from ncdc_spec.view_rows import ROWS_STATUS
from pipelines import run_bench

__all__ = ["BY_NAME", "Contract", "D", "Dut", "Host", "ROWS", "RandomWrites", "SHADOW_ROWS",
           "control", "end_frame", "run", "status", "wait"]

D = barrel_descriptor(hidden_neurons=3)
ROWS = registers(3, D.formats)
BY_NAME = {r.name: r for r in ROWS}
SHADOW_ROWS = [r for r in ROWS if r.access == "shadow"]


class Dut(Elaboratable):
    """The registers of ``D``, its table of valid rows, and the memories of its weights if units
    serve ``share`` neurons in turn; ``view_rows`` matrices of a view. ``rst`` resets all."""

    def __init__(self, share=1, view_rows=0):
        hardware = Hardware(share=share)
        stored = in_memory(ROWS, hardware)
        rows = ROWS
        if view_rows:
            rows = registers(3, D.formats, view=True, view_rows=view_rows)
        constants = {"DIGEST": int(D.digest[:8], 16), "NEURONS": 3,
                     "CAPABILITIES": 7, "LARGEST": 9,
                     **({ROWS_STATUS: view_rows} if view_rows else {})}
        self.registers = Registers(rows, host_values(D), constants,
                                   in_memory=stored, neurons=hardware.served(3))
        self.table = ValidTable(D.valid, *D.geometry.corrected)
        self.share, self.rst = share, Signal()
        self.turn = Signal(range(share))            # of the words that the banks show a clock later
        kinds = {(r.parameter[0] == "output", r.address & 3): r.shape for r in stored}
        self.banks = {(*kind, unit): WeightBanks(
            Shape(shape.width, shape.signed), unit=unit, share=share, output=kind[0], role=kind[1])
            for kind, shape in kinds.items() for unit in range(hardware.units(3))}
        self.names = {(r.parameter[0] == "output", r.address & 3, r.address >> 2 & 31): r.name
                      for r in stored}

    def elaborate(self, platform):
        m = Module()
        m.submodules.registers, m.submodules.table = self.registers, self.table
        wiring.connect(m, self.registers.valid_table, self.table.host)
        for (output, role, unit), bank in self.banks.items():
            m.submodules[f"bank{output:d}_{role}_{unit}"] = bank
            wiring.connect(m, self.registers.writes, bank.writes)
            m.d.comb += bank.turn.eq(self.turn)
        return ResetInserter(self.rst)(m)

    def shown(self, ctx, turn):
        """By name what the memories show of ``turn``; zero for turns without a neuron, left out."""
        words = {}
        for (output, role, unit), bank in self.banks.items():
            name = self.names.get((output, role, unit * self.share + turn))
            if name is None:
                assert ctx.get(bank.o) == 0
            else:
                words[name] = ctx.get(bank.o)
        return words


class Host:
    """Avalon-MM accesses in the Amaranth simulator."""

    def __init__(self, ctx, bus):
        self.ctx, self.bus = ctx, bus

    async def write(self, address, value):
        ctx, bus = self.ctx, self.bus
        ctx.set(bus.address, address)
        ctx.set(bus.writedata, value & 0xFFFFFFFF)
        ctx.set(bus.write, 1)
        while (await ctx.tick().sample(bus.waitrequest))[2]:
            pass
        ctx.set(bus.write, 0)

    async def read(self, address):
        ctx, bus = self.ctx, self.bus
        ctx.set(bus.address, address)
        ctx.set(bus.read, 1)
        while (await ctx.tick().sample(bus.waitrequest))[2]:
            pass
        ctx.set(bus.read, 0)
        while True:
            _, _, valid, value = await ctx.tick().sample(bus.readdatavalid, bus.readdata)
            if valid:
                return value


async def wait(ctx, clocks):
    for _ in range(clocks):
        await ctx.tick()


def run(bench, share=1, view_rows=0):
    """Simulate ``bench(ctx, registers, host)``."""
    dut = Dut(share, view_rows)

    async def testbench(ctx):
        await bench(ctx, dut.registers, Host(ctx, dut.registers.bus))

    run_bench(dut, testbench)


async def control(ctx, host, value):
    await host.write(BY_NAME["CTRL"].address, value)
    await wait(ctx, 3)


async def status(host):
    return await host.read(BY_NAME["STATUS"].address)


async def end_frame(ctx, dut):
    """One clock of ``ended``; returns in the clock after it."""
    ctx.set(dut.ended, 1)
    await ctx.tick()
    ctx.set(dut.ended, 0)


def cut(register, value):
    """What a register of this shape keeps of a word."""
    value &= (1 << register.shape.width) - 1
    return value - (1 << register.shape.width) * (
        register.shape.signed and value >> register.shape.width - 1)


class RandomWrites:
    """A write of six clocks now and then: CTRL, a valid row, a register of the committed set."""

    CHOSEN = [BY_NAME[name] for name in ("VALID_BANK", "FILL", "BAYER_PHASE", "VALID_WINDOW")]

    def __init__(self, rng):
        self.rng = rng
        self.age = 0            # clocks for which the present write has been under way
        self.waits = False      # the present write waits until weights are copied
        self.wanted = False
        self.address = self.value = 0

    def choose(self, rest):
        """The next write, unless one is under way; never one, if it should ``rest``."""
        if self.age or self.waits:
            return
        rng = self.rng
        self.wanted = not rest and rng.random() < 0.9
        kind, self.value = rng.integers(10), int(rng.integers(0, 1 << 32))
        if kind < 2:
            self.address, self.value = BY_NAME["CTRL"].address, int(rng.integers(0, 4))
        elif kind < 5:
            self.address = TABLE + int(rng.integers(0, 4))
        else:
            pool = self.CHOSEN if kind < 8 else SHADOW_ROWS
            self.address = pool[rng.integers(len(pool))].address

    def drive(self, ctx, bus, copying):
        ctx.set(bus.address, self.address)
        ctx.set(bus.writedata, self.value)
        ctx.set(bus.write, self.wanted)
        assert ctx.get(bus.waitrequest) == (self.age != 5)
        self.waits = self.wanted and not self.age and copying
        if self.waits:
            return False
        counts = self.wanted and self.age == 2
        self.age = (self.age + self.wanted) % 6
        return counts


class Contract:
    """What registers.md promises, clock by clock.

    ``active`` are the registers after configuration; ``words`` those that a copy has to go
    through, 0 without memories. ``under_way``: an access is, to which the copy gives way.
    """

    def __init__(self, active, words=0):
        self.active, self.words = active, words
        self.copies = 2 * words         # words left to be copied
        self.held = active | {"VALID_WINDOW": 0}
        self.busy = self.pending = self.committed = self.rejected = self.begin = self.take = False
        self.commits = self.waits = 0

    def holds_valid_row(self):
        bank = self.held["VALID_WINDOW"]
        return ((self.busy or self.pending) and bank == self.active["VALID_BANK"]
                or self.committed and bank == self.held["VALID_BANK"])

    def write_register(self, address, value):
        register = next((r for r in ROWS if r.address == address), None)
        if register is None or register.name not in self.held:
            return
        if register.access == "shadow" and self.committed:
            self.rejected = True
        else:
            self.held = self.held | {register.name: cut(register, value)}

    def step(self, write, address, value, ended, under_way):
        """One clock; whether a valid row was written in it."""
        control = value if write and address == BY_NAME["CTRL"].address else 0
        before, row = self.held, write and address >= TABLE
        row_taken = row and not self.holds_valid_row()
        self.rejected |= row and not row_taken
        if write and not row:
            self.write_register(address, value)
        between = ((ended or not self.busy) and not self.begin
                   and not (self.committed and self.copies))
        self.copies -= bool(self.copies) and not under_way
        if self.take:
            self.active = {name: before[name] for name in self.active}
            self.copies = self.words
            self.commits += 1
        self.waits += self.committed and self.busy
        self.begin, self.take, self.pending, self.committed, self.busy = (
            self.pending and between,
            self.committed and between and not self.take,
            bool(control & CTRL_START) or self.pending and not self.begin,
            bool(control & CTRL_COMMIT) or self.committed and not self.take,
            self.begin or self.busy and not ended)
        return row_taken
