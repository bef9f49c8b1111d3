"""Registers of the packetiser, which sends frames from memory as packets."""

from ncdc_spec.frames import ADDRESS_BITS
from ncdc_spec.registers.register_map import Bits, Flag, Register

__all__ = ["CONTROL_ABORT", "CONTROL_SEND", "HEADER_BYTES", "LINK", "LINK_SETTINGS",
           "LINK_WORDS_BITS", "NUMBER_BITS", "PAYLOAD_BITS", "RESEND_BEFORE", "STATUS_BUSY",
           "STATUS_DONE", "STATUS_REFUSED", "STATUS_RESENDING", "STATUS_RESENT", "TEMPLATES",
           "TEMPLATE_WORDS"]

LINK_WORDS_BITS = 10
TEMPLATE_WORDS = 64                     # of each header, the first of which is its length
TEMPLATES = 1 << LINK_WORDS_BITS - 1    # word address of the four headers
HEADER_BYTES = 4 * (TEMPLATE_WORDS - 1)
NUMBER_BITS = 24                        # of a packet's number
PAYLOAD_BITS = 14                       # of a packet's payload, in bytes

CONTROL_SEND, CONTROL_ABORT = 1, 2
STATUS_BUSY, STATUS_DONE, STATUS_RESENDING, STATUS_RESENT, STATUS_REFUSED = 1, 2, 4, 8, 16
RESEND_BEFORE = 1 << 31

LINK_SETTINGS = ("LINK_PAYLOAD", "LINK_PACKETS", "LINK_LAST", "LINK_FIRST_NUMBER",
                 "LINK_NUMBER_FIELD")
"""What is not written while packets are sent."""

_COUNT = Bits(32)

LINK = (
    Register("LINK_CONTROL", 0x00, "action", Bits(2), "", (
        Flag("SEND", CONTROL_SEND, "w1",
             "send the frame at `LINK_BASE`, with the headers written since the last one"),
        Flag("ABORT", CONTROL_ABORT, "w1", "send no more of the frame than the packets on their "
             "way"))),
    Register("LINK_STATUS", 0x01, "action", Bits(5), "", (
        Flag("BUSY", STATUS_BUSY, "ro", "packets of a frame are to be sent"),
        Flag("DONE", STATUS_DONE, "w1c", "the last packet of a frame was sent"),
        Flag("RESENDING", STATUS_RESENDING, "ro", "packets are to be sent again"),
        Flag("RESENT", STATUS_RESENT, "w1c", "the last packet of a range was sent again"),
        Flag("REFUSED", STATUS_REFUSED, "w1c",
             "a write was ignored: of a setting or of `SEND` while a frame is sent, of a range "
             "while another one is or of a frame that was never sent, of a header that is being "
             "sent again, or of `SEND` with a payload that the queue does not hold"))),
    Register("LINK_BASE", 0x02, "rw", Bits(ADDRESS_BITS),
             "Byte address of the next frame, a multiple of the memory word."),
    Register("LINK_PAYLOAD", 0x03, "rw", Bits(PAYLOAD_BITS),
             "Bytes of the frame in a packet, a multiple of 16."),
    Register("LINK_PACKETS", 0x04, "rw", Bits(NUMBER_BITS), "Packets with bytes of the frame."),
    Register("LINK_LAST", 0x05, "rw", Bits(PAYLOAD_BITS),
             "Bytes of the frame in the last of them, at most `LINK_PAYLOAD`."),
    Register("LINK_FIRST_NUMBER", 0x06, "rw", Bits(NUMBER_BITS),
             "Number of the first of them; the leader's is one less, the trailer's one more than "
             "the last one's."),
    Register("LINK_NUMBER_FIELD", 0x07, "rw", Bits(11),
             "Where a packet's number stands in its header, big endian: bits 7:0 byte, bits 10:8 "
             "how many bytes, 0..4."),
    Register("LINK_DELAY", 0x08, "rw", _COUNT, "Clocks between two packets, at least."),
    Register("LINK_RESEND_FIRST", 0x09, "rw", Bits(NUMBER_BITS),
             "Number of the first packet to be sent again."),
    Register("LINK_RESEND_LAST", 0x0A, "action", Bits(32),
             "Writing sends the range again, before new packets.", (
                 Flag("NUMBER", (1 << NUMBER_BITS) - 1, "w1", "of the last packet of the range"),
                 Flag("BEFORE", RESEND_BEFORE, "w1", "of the frame before the last one"))),
    Register("LINK_SENT", 0x0B, "ro", _COUNT, "Packets sent, those sent again apart."),
    Register("LINK_RESENT", 0x0C, "ro", _COUNT, "Packets sent again."),
    Register("LINK_CLOCKS", 0x0D, "ro", _COUNT,
             "Clocks of the last frame, from `SEND` to the end of its last packet."),
    Register("LINK_STALLS", 0x0E, "ro", _COUNT,
             "Clocks in which a packet waited for its bytes from memory, when it might have gone."),
)
