"""The firmware's part of sending pictures, on the registers of a NetworkRun."""

from dataclasses import dataclass

from ncdc_boards.camera_board.design import READER_OF_HOST
from ncdc_sim.board.network import HEADERS
from ncdc_sim.tools import SimulationError
from ncdc_spec.pixel_formats import format_of_name, raw_format
from ncdc_spec.protocols.link_headers import Endpoint, gvsp_headers
from ncdc_spec.registers.link_map import CONTROL_SEND, STATUS_BUSY, STATUS_DONE, TEMPLATE_WORDS
from ncdc_spec.registers.system_map import EVENTS

__all__ = ["Claimed", "PictureSender", "Sent"]

_READERS = READER_OF_HOST + 1, READER_OF_HOST + 2       # that claim in turn
_CLAIM_RAW, _CLAIM_CORRECTED, _HELD, _BUFFER_AT = 1, 2, 0x100, 11
_DEVICE = Endpoint(b"\x02\x4e\x0a\x4d\x00\x0b", bytes([10, 77, 0, 11]), 49152)
_CLIENT = Endpoint(b"\x02\x00\x00\x00\x00\x01", bytes([10, 77, 0, 10]), 50001)


@dataclass(frozen=True)
class Claimed:
    """A buffer that a reader holds: its byte address, the number of its raw frame, the core's
    clock of that frame's beginning."""
    base: int
    number: int
    clock: int


@dataclass(frozen=True)
class Sent:
    """A picture that was sent: its number on the line, that of its raw frame, the bench's counts
    after it (see :meth:`NetworkRun.counts`)."""
    block: int
    number: int
    counts: tuple


class PictureSender:
    """Claims frames, writes their headers, sends them, as the firmware's ``stream.c`` does.

    Two readers take turns, so that the frame before stays as it is while packets of it may be
    wanted again. The next frame is claimed when the last packet of the one before is sent.

    Parameters
    ----------
    run : NetworkRun
    payload : int
        Bytes of picture in a packet.
    """

    def __init__(self, run, payload=1456):
        self.run, self.payload = run, payload
        self._turn = self._block = 0

    def corrected(self, count):
        """Send corrected frames, each when it is complete; a list of :class:`Sent`."""
        return [self._send(self._next("CORRECTED_FRAME", "CORRECTED"), "BGR8")
                for _ in range(count)]

    def replayed(self, count):
        """Switch the camera off after two raw frames, and send them in turn."""
        held = [self._next("RAW_FRAME", "RAW") for _ in _READERS]
        for name in ("RUN", "CAMERA_ENABLE"):
            self.run.write(name, 0)
        # The corrector ends the frame that it has begun, the camera the one that is under way.
        self.run.until("CAMERA_STATUS", 3, 0)
        bayer = raw_format(self.run.model.descriptor.geometry).name
        return [self._send(held[k % len(held)], bayer) for k in range(count)]

    def _next(self, event, store):
        """Wait for a new frame, and claim the newest one."""
        mask = 1 << 8 + [name for name, _ in EVENTS].index(event)
        self.run.until("CAMERA_STATUS", mask, mask)
        self.run.write("CAMERA_STATUS", mask)
        self._turn = 1 - self._turn
        return self._claim(f"READER{_READERS[self._turn]}", store)

    def _claim(self, reader, store):
        """The newest frame of a store, which the reader holds from now on."""
        run = self.run
        run.write(reader, _CLAIM_RAW if store == "RAW" else _CLAIM_CORRECTED)
        state = run.read(reader)
        if not state & _HELD:
            raise SimulationError(f"{reader} holds no frame")
        name = f"{store}{state >> _BUFFER_AT & 15}"
        high, low = run.read(f"{name}_TIME_HIGH"), run.read(f"{name}_TIME_LOW")
        return Claimed(run.read(f"{name}_BASE"), run.read(f"{name}_NUMBER"), high << 32 | low)

    def _send(self, frame, format_name):
        """Send a frame that is held, and wait until it has gone."""
        run, geometry = self.run, self.run.model.descriptor.geometry
        self._block += 1
        form = format_of_name(format_name)
        size = geometry.corrected if format_name == "BGR8" else geometry.distorted
        headers = gvsp_headers(_DEVICE, _CLIENT, (form, *size), self._block,
                               frame.clock * 10**9 // run.model.design.core_hz, self.payload)
        for name, value in (
                ("LINK_PAYLOAD", headers.payload_bytes), ("LINK_PACKETS", headers.packets),
                ("LINK_LAST", headers.last_bytes), ("LINK_FIRST_NUMBER", headers.first),
                ("LINK_NUMBER_FIELD", headers.field[0] | headers.field[1] << 8),
                ("LINK_DELAY", 0), ("LINK_BASE", frame.base)):
            run.write(name, value)
        for k, header in enumerate((headers.leader, headers.payload, headers.last,
                                    headers.trailer)):
            run.write(HEADERS + TEMPLATE_WORDS * k, len(header))
            for at in range(0, len(header), 4):
                run.write(HEADERS + TEMPLATE_WORDS * k + 1 + at // 4,
                          int.from_bytes(header[at:at + 4], "little"))
        run.write("LINK_STATUS", STATUS_DONE)
        run.write("LINK_CONTROL", CONTROL_SEND)
        run.until("LINK_STATUS", STATUS_BUSY, 0)
        return Sent(self._block, frame.number, run.counts())
