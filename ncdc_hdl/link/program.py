"""The packetiser's program: its computations between and during packets."""

from amaranth.lib import data, enum

from ncdc_spec.registers.link_map import LINK

__all__ = ["CONDITIONS", "ORDERS", "STEP", "WORDS", "Index", "Source", "assembled"]


class Source(enum.Enum, shape=2):
    """The operand of an addition or subtraction."""
    MEMORY = 0
    STAMP = 1
    WORD = 2
    WAITED = 3


class Index(enum.Enum, shape=3):
    """The part that goes into the lowest bits of a word's address."""
    NONE = 0
    AGAIN = 1
    BANK = 2
    HOST = 3
    STEPS = 4


_PAIRS = {"POSITION": Index.AGAIN, "OFFSET": Index.AGAIN, "END": Index.AGAIN, "BASES": Index.BANK}
_REGISTERS = {register.name.removeprefix("LINK_"): register.address for register in LINK}
WORDS = _REGISTERS | {
    # Addresses of registers that are not in the memory are free for other words.
    "ADDRESS": _REGISTERS["CONTROL"],       # address of the bytes to be requested
    "LEFT": _REGISTERS["STATUS"],           # their number, less one
    "FACTOR": _REGISTERS["RESEND_LAST"],    # rest of the factor, highest bits first
    "ENDED": 15,                            # clock of the last packet's end
    # For the frame, and for the range that is sent again.
    "POSITION": 16,                         # of the next packet, 0 for the leader
    "OFFSET": 18,                           # that position times LINK_PAYLOAD
    "END": 20,                              # position after the last packet
    "BASES": 22,                            # base of the frame of each set of headers
    "BEGAN": 24,                            # clock of SEND
    # Constants.
    "ONE": 25, "TWO": 26, "BURST": 27, "ABOVE": 28, "PAIR": 29, "DEFAULT": 30,
}
"""Addresses of words by name: those of registers are the registers' own."""

CONDITIONS = (
    "always",       # the default condition
    "zero", "negative",     # the sum is
    "borrow",       # of the last subtraction
    "uneven",       # the sum is no multiple of 16
    "steps",        # of the product are left
    "host",         # a register is accessed, other than to read LINK_STATUS
    "reads",        # it is read
    "stored",       # it is a word that the host may read, or write
    "locked",       # it is a setting, and packets are being sent
    "status", "control", "range",   # it is this register
    "send",         # the word that is written requests a frame
    "active",       # packets are being sent
    "resending",    # packets are being sent again
    "unknown",      # the word requests packets of a frame that was never sent
    "gone",         # a packet has ended and is not yet counted
    "again",        # it was sent before
    "more",         # bytes are to be requested, and the memory takes a command
    "held",         # no packet may begin until LINK_DELAY is over, and all are counted
    "waited",       # there are clocks of waiting not yet counted
    "job",          # there is a packet to build, and space for it
    "bare", "short",        # it has no payload; it is the last one with payload
)

ORDERS = (
    "none",
    "accept", "answer",         # the access; the answer of a read is the sum
    "set",                      # a register; the sum is its word
    "reject",
    "clear_status", "abort",    # bits of the word that is written
    "begin",                    # a frame
    "pair",                     # the sum is negative if the queue holds two packets
    "range",                    # the word that is written begins a range
    "multiply", "step",         # set and count the steps of the product
    "count",                    # take a packet that has ended
    "counted",
    "look",                     # read the time counter
    "release",                  # allow a packet to begin
    "take_waited",
    "take_job",
    "leader", "payload", "last", "trailer",     # the packet's header
    "make",                     # build it; the sum is its number
    "finish",                   # it is the last packet of the frame, or of the range
    "bytes",                    # the sum is its payload, less one
    "ask",                      # the sum is the address of a command
    "size",                     # the sum is the rest after that, less one
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
            add POSITION
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
            # While its header is built: is it the last one, and what is its address?
            add POSITION
            add ONE
            store POSITION
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

            # The range's first position times LINK_PAYLOAD, bit by bit.
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
            if not stored: ANSWER
            add HOST
    ANSWER: do accept
            do answer, clear, goto WORK
    WRITE:  if locked: REJECT
            if not stored: ACTION
            add WORD
            store HOST, do set, goto ACCEPT
    ACTION: if range: RANGE
            if control: CONTROL
            if not status: ACCEPT
            do clear_status, goto ACCEPT
    REJECT: do reject
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
            store POSITION
            store OFFSET
            add STAMP
            store BEGAN, clear
            add PACKETS
            add TWO
            store END, goto ABORT
    DENY:   do reject
    ABORT:  do abort, goto ACCEPT

            # Positions of the range, limited to those of the frame.
    RANGE:  if resending: REJECT
            if unknown: REJECT
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
            if not negative: BEGIN
            clear
    BEGIN:  store POSITION
            store FACTOR
            sub END
            if not negative: EMPTY, clear
            store OFFSET, do multiply, goto REST
    EMPTY:  do finish, goto REST
"""


STEP = data.StructLayout({
    "address": 5, "index": Index,           # address of the word
    "source": Source, "adds": 1, "subtracts": 1,
    "stores": 1,                            # store the sum
    "clears": 1,                            # clear the sum, once it is stored
    "order": 5,
    "condition": 5, "inverted": 1,          # evaluated before the sum changes
    "target": 8,                            # target of the jump
})
"""A step: a sum, an order to the other parts, and a jump; each part is always executed."""


def assembled():
    """The program as values of STEP.

    A line of the text is a step: ``add``, ``sub`` or ``store`` and a word, ``clear``, ``do`` and an
    order, ``goto`` or ``if`` (``not``) and a label.
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
    # A step without a jump has a condition that is false.
    return {"condition": 0, "inverted": "target" not in step} | step


def _word(name):
    if name in ("STAMP", "WORD", "WAITED"):
        return {"source": Source[name]}
    if name in ("HOST", "CLEARED"):
        return {"index": Index.HOST if name == "HOST" else Index.STEPS}
    if name == "AGAIN_OFFSET":
        return {"address": WORDS["OFFSET"] + 1}
    return {"address": WORDS[name], "index": _PAIRS.get(name, Index.NONE)}
