"""The packetiser's program: what it works out between and during packets."""

from amaranth.lib import data, enum

from ncdc_spec.registers.link_map import LINK

__all__ = ["CONDITIONS", "ORDERS", "STEP", "WORDS", "Index", "Source", "assembled"]


class Source(enum.Enum, shape=2):
    """What is added or subtracted."""
    MEMORY = 0
    STAMP = 1
    WORD = 2
    WAITED = 3


class Index(enum.Enum, shape=3):
    """What is put into the lowest bits of a word's address."""
    NONE = 0
    AGAIN = 1
    BANK = 2
    HOST = 3
    STEPS = 4


_PAIRS = {"PLACE": Index.AGAIN, "OFFSET": Index.AGAIN, "END": Index.AGAIN, "BASES": Index.BANK}
_REGISTERS = {register.name.removeprefix("LINK_"): register.address for register in LINK}
WORDS = _REGISTERS | {
    # Registers that are no words of the memory: their places are free.
    "ADDRESS": _REGISTERS["CONTROL"],       # of the bytes that are to be asked for
    "LEFT": _REGISTERS["STATUS"],           # how many they are, less one
    "FACTOR": _REGISTERS["RESEND_LAST"],    # what is left of it, highest bits first
    "ENDED": 15,                            # clock of the last packet's end
    # Of the frame, and of the range that is sent again.
    "PLACE": 16,                            # of the next packet, 0 for the leader
    "OFFSET": 18,                           # that place times LINK_PAYLOAD
    "END": 20,                              # place behind the last packet
    "BASES": 22,                            # of the frame of each set of headers
    "BEGAN": 24,                            # clock of SEND
    # Constants.
    "ONE": 25, "TWO": 26, "BURST": 27, "ABOVE": 28, "PAIR": 29, "DEFAULT": 30,
}
"""Addresses of words by name: those of registers are the registers' own."""

CONDITIONS = (
    "always",       # so is one that is not given
    "zero", "negative",     # the sum is
    "borrow",       # of the last subtraction
    "uneven",       # the sum is no multiple of 16
    "steps",        # of the product are left
    "host",         # a register is accessed, other than to read LINK_STATUS
    "reads",        # it is read
    "kept",         # it is a word that the host may read, or write
    "locked",       # it is a setting, and packets are being sent
    "status", "control", "range",   # it is this register
    "send",         # the word that is written asks for a frame
    "active",       # packets are being sent
    "resending",    # packets are being sent again
    "unknown",      # the frame was never sent of which the word asks for packets
    "gone",         # a packet has ended that is not counted as yet
    "again",        # it was one that was sent before
    "more",         # bytes are to be asked for, and the memory takes a command
    "held",         # no packet may begin until LINK_DELAY is over, and all are counted
    "waited",       # there are clocks of waiting that are not counted as yet
    "job",          # there is a packet to be made, and room for it
    "bare", "short",        # it has no payload; it is the last one that has
)

ORDERS = (
    "none",
    "accept", "answer",         # the access; the answer of a read is the sum
    "set",                      # a register; the sum is its word
    "refuse",
    "clear_status", "abort",    # bits of the word that is written
    "begin",                    # a frame
    "pair",                     # the sum is negative if the queue holds two packets
    "range",                    # the word that is written begins a range
    "multiply", "step",         # set and count the steps of the product
    "count",                    # take a packet that has ended
    "counted",
    "look",                     # at the clock
    "release",                  # a packet may begin
    "take_waited",
    "take_job",
    "leader", "payload", "last", "trailer",     # which header
    "make",                     # the sum is its number
    "finish",                   # it is the last packet of the frame, or of the range
    "bytes",                    # the sum is its payload, less one
    "ask",                      # the sum is the address of a command
    "size",                     # the sum is what is left behind that, less one
)

_TEXT = """
            store CLEARED, do step, if steps: START
            add DEFAULT
            store PAYLOAD, clear

    REST:   if host: HOST
    WORK:   if gone: GONE
            if more: MORE
            if held: HELD
    UNHELD: if waited: WAITED
            if job: JOB
            if steps: PRODUCT
            goto REST

            # The next packet: which header it has, and its number.
    JOB:    do take_job
            add PLACE
            if zero: LEADER, sub PACKETS
            if negative: MIDDLE
            if zero: LAST
            do trailer, goto NUMBER
    LEADER: do leader, goto NUMBER
    LAST:   do last, goto NUMBER
    MIDDLE: do payload
    NUMBER: add PACKETS
            add FIRST_NUMBER
            sub ONE
            do make, clear
            # While its header is made: is it the last one, and where are its bytes?
            add PLACE
            add ONE
            store PLACE
            sub END
            if not zero: OFFSET, clear
            do finish
    OFFSET: add OFFSET
            add PAYLOAD
            store OFFSET
            if bare: REST, clear
            add OFFSET
            add BASES
            sub PAYLOAD
            sub PAYLOAD
            store ADDRESS, clear
            if short: SHORT
            add PAYLOAD, goto BYTES
    SHORT:  add LAST
    BYTES:  sub ONE
            store LEFT, do bytes, clear, goto REST

            # A command for some of its bytes.
    MORE:   add ADDRESS
            add BURST, do ask
            store ADDRESS, clear
            add LEFT
            sub BURST
            store LEFT, do size, clear, goto REST

            # A packet has ended.
    GONE:   do count
            add STAMP
            store ENDED
            if again: AGAIN, clear
            add STAMP
            sub BEGAN
            store CLOCKS, clear
            add SENT
            add ONE
            store SENT, do counted, clear, goto REST
    AGAIN:  add RESENT
            add ONE
            store RESENT, do counted, clear, goto REST

    HELD:   do look
            add STAMP
            sub ENDED
            sub DELAY
            if borrow: UNHELD, clear
            do release, goto UNHELD

    WAITED: add STALLS
            add WAITED, do take_waited
            store STALLS, clear, goto REST

            # The range's first place times LINK_PAYLOAD, a bit of the place after the other.
    PRODUCT: add FACTOR
            add FACTOR
            store FACTOR
            if negative: BIT, clear
            goto DOUBLE
    BIT:    add PAYLOAD
    DOUBLE: add AGAIN_OFFSET
            add AGAIN_OFFSET
            store AGAIN_OFFSET, do step, clear, goto REST

            # An access of the host.
    HOST:   if not reads: WRITE
            if not kept: ANSWER
            add HOST
    ANSWER: do accept
            do answer, clear, goto WORK
    WRITE:  if locked: REFUSE
            if not kept: ACTION
            add WORD
            store HOST, do set, goto ACCEPT
    ACTION: if range: RANGE
            if control: CONTROL
            if not status: ACCEPT
            do clear_status, goto ACCEPT
    REFUSE: do refuse
    ACCEPT: do accept, clear, goto WORK

    CONTROL: if not send: ABORT
            if active: DENY, add PAYLOAD
            if zero: DENY
            if uneven: DENY
            sub ABOVE
            if not negative: DENY, clear
            add PACKETS
            if zero: DENY, clear
            add LAST
            if zero: DENY, sub ONE
            sub PAYLOAD
            if not negative: DENY, clear
            add PAYLOAD
            sub PAIR
            do pair, clear
            do begin
            add BASE
            store BASES, clear
            store PLACE
            store OFFSET
            add STAMP
            store BEGAN, clear
            add PACKETS
            add TWO
            store END, goto ABORT
    DENY:   do refuse
    ABORT:  do abort, goto ACCEPT

            # Places of the range, as far as the frame has them.
    RANGE:  if resending: REFUSE
            if unknown: REFUSE
            do range
            add WORD
            add TWO, do accept
            sub FIRST_NUMBER
            store END
            sub PACKETS
            sub TWO
            if negative: FIRST, clear
            add PACKETS
            add TWO
            store END, clear
    FIRST:  add RESEND_FIRST
            add ONE
            sub FIRST_NUMBER
            if not negative: PLACE
            clear
    PLACE:  store PLACE
            store FACTOR
            sub END
            if not negative: EMPTY, clear
            store OFFSET, do multiply, goto REST
    EMPTY:  do finish, goto REST
"""


STEP = data.StructLayout({
    "address": 5, "index": Index,           # of the word
    "source": Source, "adds": 1, "subtracts": 1,
    "stores": 1,                            # the sum
    "clears": 1,                            # the sum, once it is stored
    "order": 5,
    "condition": 5, "inverted": 1,          # looked at before the sum changes
    "target": 8,                            # of the jump
})
"""A step: a sum, an order to the other parts, and a jump; all of it is done in any case."""


def assembled():
    """The program as values of STEP.

    A line of the text is a step: ``add``, ``sub`` or ``store`` and a word, ``clear``, ``do`` and an
    order, ``goto`` or ``if`` (``not``) and where to.
    """
    lines = [line.split("#")[0].strip() for line in _TEXT.splitlines()]
    labels, steps = {"START": 0}, []
    for line in filter(None, lines):
        label, colon, rest = line.partition(":")
        if colon and " " not in label:
            labels[label] = len(steps)
            line = rest
        steps.append([part.split() for part in line.replace(":", "").split(",")])
    return [STEP.const(_step(parts, labels)).as_value().value for parts in steps]


def _step(parts, labels):
    step = {}
    for verb, *rest in parts:
        if verb in ("add", "sub"):
            step |= _word(rest[0]) | {"adds": 1, "subtracts": verb == "sub"}
        elif verb == "store":
            step |= _word(rest[0]) | {"stores": 1}
        elif verb == "clear":
            step["clears"] = 1
        elif verb == "do":
            step["order"] = ORDERS.index(rest[0])
        else:
            *inverted, condition, target = ["always", *rest] if verb == "goto" else rest
            step |= {"condition": CONDITIONS.index(condition), "inverted": bool(inverted),
                     "target": labels[target]}
    # A step that does not jump has a condition that does not hold.
    return {"condition": 0, "inverted": "target" not in step} | step


def _word(name):
    if name in ("STAMP", "WORD", "WAITED"):
        return {"source": Source[name]}
    if name in ("HOST", "CLEARED"):
        return {"index": Index.HOST if name == "HOST" else Index.STEPS}
    if name == "AGAIN_OFFSET":
        return {"address": WORDS["OFFSET"] + 1}
    return {"address": WORDS[name], "index": _PAIRS.get(name, Index.NONE)}
