"""Table I in gateware: registers of the sensor by I2C, and the system's page."""

from dataclasses import dataclass

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.registers.access import Access
from ncdc_hdl.usb.joiner import PIECE
from ncdc_spec.protocols.table_one import SYSTEM_PAGE, SYSTEM_WORDS, WRITE
from ncdc_spec.registers.system_map import I2C_COMMAND_FLAGS

__all__ = ["NO_SENSOR", "TableOne"]

NO_SENSOR = 0xFFFF
"""Value read from a sensor that does not answer."""

_FLAGS = {name: mask for name, mask, _ in I2C_COMMAND_FLAGS}
_BUSY, _NACK, _FAILED = 0x100, 0x200, 0xC00     # bits of I2C_RESULT
_WORDS = {word.name: word.address for word in SYSTEM_WORDS}
# For the system's page: the register that has the word, and the word's lowest bit in it.
_REGISTERS = {
    "WIDTH_MAX": ("SENT_WIDTH", 0), "HEIGHT_MAX": ("SENT_HEIGHT", 0),
    "OFFSET_X": ("WINDOW_LEFT", 0), "OFFSET_Y": ("WINDOW_TOP", 0),
    "DROPPED_UPPER": ("FRAMES_MISSED", 16), "DROPPED_LOWER": ("FRAMES_MISSED", 0),
    "TORN_UPPER": ("RAW_TAKEN", 16), "TORN_LOWER": ("RAW_TAKEN", 0),
}


@dataclass(frozen=True)
class _Step:
    """A command on the I2C bus: its flags. ``byte``, a constant or the name of one of the
    request's bytes; ``keeps``: the byte received is shifted into the value."""
    flags: int
    byte: object
    keeps: bool = False


def _steps(sensor):
    """Steps that read a register, write one, and free the bus after a failure."""
    start, write, read, nack, stop = (_FLAGS[name]
                                      for name in ("START", "WRITE", "READ", "NACK", "STOP"))
    pointer = [_Step(write, f"address{k}") for k in reversed(range(sensor.pointer_bits // 8))]
    value = [_Step(write, f"value{k}") for k in reversed(range(sensor.value_bits // 8))]
    target = sensor.i2c_address << 1
    count = sensor.value_bits // 8
    reads = [_Step(start | write, target), *pointer, _Step(start | write, target | 1),
             *(_Step(read | (nack | stop if k == count - 1 else 0), 0, True)
               for k in range(count))]
    writes = [_Step(start | write, target), *pointer, *value]
    writes[-1] = _Step(write | stop, writes[-1].byte)
    return writes, reads, [_Step(read | nack | stop, 0)]


class TableOne(wiring.Component):
    """Answers a request of Table I that reads or writes a word.

    Addresses below the system's page are registers of the sensor, which are read and written by
    I2C; written values are read back. In the system's page only SOURCE can be written; what this
    system lacks reads as zero.

    Parameters
    ----------
    view : SystemView
    sensor : Sensor
    address_bits : int
        Bits of a word address.

    Members
    -------
    start : ``In(1)``
        Start a request; ignored while ``busy``.
    request : ``In(40)``
        Its five bytes, the last one lowest; constant while ``busy``.
    busy : ``Out(1)``
    source : ``Out(1)``
        1: corrected pictures.
    number : ``In(32)``
        Number of the frame that was sent last.
    access : ``Out(Access(address_bits))``
    o : ``Out(stream.Signature(PIECE))``
    """

    def __init__(self, view, sensor, address_bits):
        self.view, self.sensor = view, sensor
        super().__init__({
            "start": In(1), "request": In(40), "busy": Out(1), "source": Out(1), "number": In(32),
            "access": Out(Access(address_bits)), "o": Out(stream.Signature(PIECE))})

    def elaborate(self, platform):
        m = Module()
        access = self.access
        address, value = Signal(16), Signal(16)
        writes = Signal()                           # the request is a write
        m.d.comb += [address.eq(self.request[16:32]), writes.eq(self.request[32:] == WRITE),
                     self.busy.eq(1)]
        programs = _steps(self.sensor)
        steps = [step for program in programs for step in program]
        reads, frees = len(programs[0]), len(programs[0]) + len(programs[1])
        index = Signal(range(len(steps) + 1))
        rest = Signal()                             # the second piece of the answer
        with m.FSM():
            with m.State("REST"):
                m.d.comb += self.busy.eq(0)
                with m.If(self.start):
                    m.next = "BEGIN"
            with m.State("BEGIN"):
                m.d.sync += [index.eq(Mux(writes, 0, reads)), value.eq(0), rest.eq(0)]
                m.next = "SEND"
                with m.If(address >= SYSTEM_PAGE):
                    with m.If(writes & (address == _WORDS["SOURCE"])):
                        m.d.sync += self.source.eq(self.request[0] & self.view.has_corrected)
                    m.next = "SYSTEM"
            with m.State("SYSTEM"):
                self._system(m, address, value)
            with m.State("SEND"):
                self._command(m, steps, index)
                with m.If(access.done):
                    m.next = "RESULT"
            with m.State("RESULT"):
                self._result(m, steps, index, value, (frees, len(steps)))
            with m.State("ANSWER"):
                o, request = self.o, self.request
                m.d.comb += [
                    o.valid.eq(1), o.p.last.eq(rest), o.p.bytes.eq(Mux(rest, 1, 4)),
                    o.p.data.eq(Mux(rest, value[:8], Cat(request[32:], request[24:32],
                                                         request[16:24], value[8:])))]
                with m.If(o.ready):
                    m.d.sync += rest.eq(1)
                    with m.If(rest):
                        m.next = "REST"
        return m

    def _result(self, m, steps, index, value, ends):
        """Wait for the end of a step's command, and continue. After the steps of a read, and of
        freeing the bus, comes the answer."""
        access = self.access
        m.d.comb += [access.valid.eq(1), access.address.eq(self.view.addresses["I2C_RESULT"])]
        answer, frees = access.answer, ends[0]
        sends, keeps = Signal(), Signal()           # the step sends a byte; it stores one
        with m.Switch(index):
            for k, step in enumerate(steps):
                with m.Case(k):
                    m.d.comb += [sends.eq(bool(step.flags & _FLAGS["WRITE"])),
                                 keeps.eq(step.keeps)]
        failed = (answer & _FAILED).any() | sends & (answer & _NACK).any()
        with m.If(access.done & ~(answer & _BUSY).any()):
            m.d.sync += index.eq(index + 1)
            m.next = "SEND"
            with m.If(keeps):
                m.d.sync += value.eq(Cat(answer[:8], value))
            with m.If(index == ends[1] - 1):
                m.d.sync += value.eq(NO_SENSOR)
                m.next = "ANSWER"
            with m.Elif(failed):
                m.d.sync += index.eq(frees)
            with m.Elif(index == frees - 1):
                m.next = "ANSWER"

    def _command(self, m, steps, index):
        """Write the command of a step."""
        request, access = self.request, self.access
        named = {"value0": request[:8], "value1": request[8:16],
                 "address0": request[16:24], "address1": request[24:32]}
        m.d.comb += [access.valid.eq(1), access.write.eq(1),
                     access.address.eq(self.view.addresses["I2C_COMMAND"])]
        with m.Switch(index):
            for k, step in enumerate(steps):
                with m.Case(k):
                    byte = named.get(step.byte, step.byte)
                    m.d.comb += access.word.eq(byte | step.flags)

    def _system(self, m, address, value):
        """The word of the system's page."""
        view, source = self.view, self.source
        at = view.addresses
        own = {
            "SOURCE": source, "NUMBER_UPPER": self.number[16:], "NUMBER_LOWER": self.number[:16],
            "FORMAT": Mux(source, view.corrected_formation, view.raw_formation)}
        registers = dict(_REGISTERS)
        m.next = "ANSWER"
        with m.Switch(address):
            for name, word in own.items():
                with m.Case(_WORDS[name]):
                    m.d.sync += value.eq(word)
            for name, register, corrected in (("WIDTH", "WINDOW_WIDTH", view.corrected[0]),
                                              ("HEIGHT", "WINDOW_HEIGHT", view.corrected[1])):
                with m.Case(_WORDS[name]):
                    self._register(m, at[register], 0, value, ~source)
                    with m.If(source):
                        m.d.sync += value.eq(corrected)
            for name, (register, shift) in registers.items():
                with m.Case(_WORDS[name]):
                    self._register(m, at[register], shift, value, 1)

    def _register(self, m, address, shift, value, asked):
        """The word at bit ``shift`` of a register."""
        access = self.access
        m.d.comb += [access.valid.eq(asked), access.address.eq(address)]
        with m.If(access.done):
            m.d.sync += value.eq(access.answer >> shift)
        with m.Elif(asked):
            m.next = "SYSTEM"
