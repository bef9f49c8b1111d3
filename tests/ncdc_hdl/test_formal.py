"""Formal proofs of the cache, the Avalon-MM hosts and the queues, see docs/evidence/proofs.md.

Every proof has covers, which show that what it speaks of happens at all, and planted errors, each
of which it must find.
"""

from functools import partial

import pytest
from amaranth import Const, Mux

from cases import cases
from formal.arbiters import Arbiter
from formal.avalon import Commands, Reader, Writer
from formal.captures import Pins, Samples
from formal.fences import FencedReads, FencedWords, WordsInBursts
from formal.fills import FillOrder, FillSpace
from formal.lookups import Progress, Slots, Tokens
from formal.queues import Credits
from formal.sby import FAIL, PASS, run
from formal.sdram_commands import Commands as SdramCommands
from formal.sdram_hosts import BurstsCut, TurnsCome
from formal.sdram_words import WordsRead
from formal.stores import Store
from ncdc_boards.sdram.arbiter import SdramArbiter
from ncdc_boards.sdram.banks import Banks
from ncdc_boards.sdram.segments import Segments
from ncdc_boards.sdram.sequencer import Sequencer
from ncdc_hdl.avalon.read_commands import ReadCommands
from ncdc_hdl.avalon.read_fence import ReadFence
from ncdc_hdl.avalon.write_arbiter import WriteArbiter
from ncdc_hdl.backend.cache.fills import Fills
from ncdc_hdl.backend.cache.interlock import Interlock
from ncdc_hdl.backend.cache.retire import Retire
from ncdc_hdl.backend.cache.tags import Tags
from ncdc_hdl.backend.packer import Packer
from ncdc_hdl.camera.camera_side import CameraSide
from ncdc_hdl.camera.frame_store import FrameStore
from ncdc_hdl.camera.sensor_port import SensorPort
from ncdc_spec.interpolation import GRADIENT

regress = pytest.mark.regress


class TokenEarly(Retire):
    """Leaves the queue a token too early."""

    @staticmethod
    def _enough(balance):
        return balance >= -1


class ReadsWhileWritten(Retire):
    """Reads shared tile memory in any clock."""

    def elaborate(self, platform):
        self.shared = False
        return super().elaborate(platform)


class TokenNotSpent(Retire):
    """Waits for a token too many."""

    @staticmethod
    def _enough(balance):
        return balance > 0


class NeverInFlight(Interlock):
    """Takes all look-ups that the memory reports for read."""

    @staticmethod
    def _in_use(pending):
        return Const(0)


class NoInterlock(Tags):
    """Replaces tiles that pending look-ups need."""

    def __init__(self, f_bits, options):
        super().__init__(f_bits, options)
        self.interlock = NeverInFlight(options)


class FramesMixed(Tags):
    """Keeps the entries of the frame before."""

    @staticmethod
    def _last(position):
        return Const(0)


class CreditTooMany(Fills):
    """Lets one tile more be claimed than allowed."""

    @staticmethod
    def _credit(outstanding, most):
        return outstanding != most + 1


class SlotEarly(Fills):
    """Takes the next tile's slot with each word."""

    def _write(self, m, commands, slots, complete):
        super()._write(m, commands, slots, complete)
        m.d.comb += slots.r_en.eq(commands.valid)


class StaleWords(ReadCommands):
    """Takes words asked for before a reset for those asked for after it."""

    @staticmethod
    def _nothing_due(read, due):
        return ~read


class WordTooFar(Packer):
    """Takes the word after the buffer for one inside."""

    @staticmethod
    def _inside(number, first, end):
        return (number >= first) & (number <= end)


class BeforeTheBuffer(Packer):
    """Looks at the buffer's end only, as if no address came round."""

    @staticmethod
    def _inside(number, first, end):
        return number < end


class BegunClaimed(FrameStore):
    """Lets a reader claim what the writer has only begun."""

    @staticmethod
    def _claimed(newest, writers):
        return writers


class ForgottenReader(FrameStore):
    """Forgets that the first reader has a buffer."""

    @staticmethod
    def _has(one, number):
        return one.held & (number != 0)


class Impatient(WriteArbiter):
    """Gives the port to an urgent host within another's burst."""

    def _chosen(self, held, owner, choice):
        return Mux(held & ~self.urgent[0], owner, choice)


class ForgetfulPort(SensorPort):
    """Does not remember that the queue was full."""

    @staticmethod
    def _overflow(full, now):
        return now


class Forgetful(CameraSide):
    def __init__(self):
        super().__init__()
        self.port = ForgetfulPort()


class ReadTooFar(ReadFence):
    """Lets a command reach one word beyond the buffer."""

    @staticmethod
    def _inside(number, first, end):
        return (number >= first) & (number <= end)


class Greedy(SdramArbiter):
    """Lets the video reader and the writer have as many turns in a row as they like."""

    def _enough(self, run):
        return Const(0)


class RowOverrun(Segments):
    """Goes on after the end of a row."""

    @staticmethod
    def _crosses(end):
        return Const(0)


class AnyRow(Banks):
    """Takes a row that is open for the one that is asked for."""

    def _other(self, opened, row):
        return Const(0)


def sooner(**rules):
    """``Banks`` that waits for a clock less."""
    class Sooner(Banks):
        @property
        def times(self):
            times = super().times
            return times | {name: times[name] - 1 for name in rules}
    return Sooner


class RefreshLast(Sequencer):
    """Begins segments while a refresh is due."""

    @staticmethod
    def _may_begin(due):
        return Const(1)


def planted(top, **error):
    """``top`` with attributes that plant an error."""
    for name, value in error.items():
        setattr(top, name, value)
    return top


# (design, mode, depth): "prove" is for all time, "bmc" for the first clocks.
PROOFS = {
    "commands": (Commands, "prove", 2),
    "reader": (Reader, "prove", 2),
    "writer": (Writer, "prove", 2),
    "reads in their buffer": (FencedReads, "prove", 4),
    "words in their buffer": (FencedWords, "prove", 3),
    "credits": (Credits, "prove", 2),
    "frames of two readers": (Store, "prove", 2),
    "bursts of two hosts": (Arbiter, "prove", 2),
    "samples of a sensor": (Pins, "bmc", 34),
    "two samples per clock": (lambda: Samples(2), "bmc", 24),
    "four samples per clock": (lambda: Samples(4), "bmc", 22),
    "fill space": (FillSpace, "prove", 2),
    "tokens": (Tokens, "prove", 2),
    "tokens, shared tile memory": (
        lambda: Tokens(retire=partial(Retire, shared=True)), "prove", 2),
    "progress": (Progress, "prove", 11),
    "fill order": (FillOrder, "bmc", 20),
    "slots": (Slots, "bmc", 15),
    "turns of SDRAM hosts": (TurnsCome, "prove", 2),
    "bursts cut at rows": (BurstsCut, "prove", 2),
    "SDRAM commands": (lambda: SdramCommands(longest=None), "prove", 2),
}
# Other widths and numbers of the same, and what takes more than some seconds.
LONG = {
    "reader of two words": (lambda: Reader(depth=2, burst=2), "prove", 2),
    "writer of four words": (lambda: Writer(4), "prove", 2),
    "reads of two words in their buffer": (lambda: FencedReads(shortest=2), "prove", 4),
    "words in their buffer, four pixels": (lambda: FencedWords(lanes=4), "prove", 3),
    "words in their buffer, 128 bits": (lambda: FencedWords(data_width=128), "prove", 3),
    "words of a view in their buffer": (lambda: FencedWords(placed=True), "prove", 3),
    "bursts in their buffer": (WordsInBursts, "prove", 2),
    "credits, five": (lambda: Credits(5, 0), "prove", 2),
    "frames of four readers": (lambda: Store(4), "prove", 2),
    "bursts of three hosts": (lambda: Arbiter(hosts=3), "prove", 2),
    "fill space, 32 bits": (lambda: FillSpace(32, 3), "prove", 2),
    "fill space, one tile": (lambda: FillSpace(64, 1), "prove", 2),
    "turns of a reader and a writer": (lambda: TurnsCome(reads=1), "prove", 2),
    # The tiles and tag banks of the gradient-corrected interpolation.
    "fill space, gradient": (lambda: FillSpace(needs=GRADIENT), "prove", 2),
    "tokens, gradient": (lambda: Tokens(needs=GRADIENT), "prove", 2),
    "fill order, gradient": (lambda: FillOrder(needs=GRADIENT), "bmc", 20),
    "bursts of four words in their buffer": (lambda: WordsInBursts(4), "prove", 2),
    "turns of four readers": (lambda: TurnsCome(reads=4), "prove", 2),
    "SDRAM commands and refreshes": (SdramCommands, "prove", 24),
    "SDRAM commands, bursts of two": (lambda: SdramCommands(max_burst=2), "prove", 24),
    "SDRAM commands, words of two beats": (lambda: SdramCommands(16), "prove", 24),
    "words read from SDRAM": (lambda: WordsRead(reads=1), "bmc", 25),
    "progress, gradient": (lambda: Progress(needs=GRADIENT), "prove", 15),
    "slots, gradient": (lambda: Slots(needs=GRADIENT), "bmc", 15),
    "fill order": (FillOrder, "bmc", 25),
    "fill order, 64 bits": (lambda: FillOrder(64), "bmc", 25),
    "fill order with gains": (lambda: FillOrder(kind=partial(Fills, raw_balance=True)), "bmc", 24),
    **{f"slots, split {split}": (lambda split=split: Slots(split), "bmc", 16)
       for split in range(3)},
    "slots of one bank": (lambda: Slots(one_bank=True), "bmc", 18),
}
COVERS = {
    "commands": (Commands, 14, {"full", "dropped", "forgotten", "memory_first"}),
    "reader": (Reader, 16, {"full", "dropped", "memory_first"}),
    "writer": (Writer, 16, {"across_reset", "full", "forgotten"}),
    "reads in their buffer": (FencedReads, 6, {"moved", "to_the_end"}),
    "words in their buffer": (FencedWords, 12, {"void", "to_the_end"}),
    "bursts in their buffer": (WordsInBursts, 12, {"void", "to_the_end"}),
    "credits": (Credits, 20, {"full", "restart", "at_rest"}),
    "frames": (Store, 14, {"all_in_use", "followed", "lost"}),
    "bursts of two hosts": (Arbiter, 10, {"urgent_waits", "other_waits"}),
    "samples of a sensor": (Pins, 37, {"clean", "overflow"}),
    "two samples per clock": (lambda: Samples(2), 26, {"clean", "overflow"}),
    "four samples per clock": (lambda: Samples(4), 24, {"clean", "overflow"}),
    "fill space": (FillSpace, 34, {"all_owed", "claim_while_filled"}),
    "fill order": (FillOrder, 32, {"second_tile"}),
    "progress": (Progress, 25, {"full", "tokens_to_come", "waits"}),
}
LONG_COVERS = {"slots": (Slots, 27, {"replaced", "interlock", "next_frame"}),
               "tokens": (Tokens, 26, {"full", "tokens_to_come"})}
# The last turn that a host may have to wait for, of each.
_TURNS = {f"last_{host}" for host in ("video", "write", "read0", "read1")}
COVERS |= {
    "turns of SDRAM hosts": (TurnsCome, 32, _TURNS),
    "bursts cut at rows": (BurstsCut, 8, {"cut_while_another_waits", "whole_row"}),
    "SDRAM commands": (lambda: SdramCommands(period=16), 34, {"next_row_of_the_bank", "refresh"}),
}
LONG_COVERS["words read from SDRAM"] = (lambda: WordsRead(reads=1), 30, {"read0"})
# (design, depth, the rule that it breaks)
PLANTED = {
    "hosts that never end": (lambda: TurnsCome(Greedy), 12, "turn_of_write"),
    "a burst beyond its row": (lambda: BurstsCut(RowOverrun), 8, "one_row"),
    "a word of another row": (lambda: SdramCommands(banks=AnyRow), 30, "own_row0"),
    "READ too early": (lambda: SdramCommands(banks=sooner(rcd=1)), 24, "rcd0"),
    "command dropped under waitrequest": (lambda: Commands(forget=True), 8, "command_held"),
    "words of before a reset": (lambda: Commands(StaleWords), 10, "asked_for"),
    "reset forgets words owed": (lambda: planted(Commands(), forgotten=[("due",)]), 10,
                                 "all_handed_on"),
    "words that the memory forgot": (lambda: Commands(deaf=True), 10, "owed_is_known"),
    "words that never come": (lambda: Commands(deaf=True), 12, "never_locked_up"),
    "burst that the memory forgot": (lambda: Writer(deaf=True), 12, "left"),
    "a word after the buffer": (lambda: FencedWords(WordTooFar), 12, "inside"),
    "a word before the buffer": (lambda: FencedWords(BeforeTheBuffer), 12, "inside"),
    "a read after the buffer": (lambda: FencedReads(ReadTooFar), 6, "inside"),
    "reader's queue too small": (lambda: planted(Reader(), entries_missing=1), 12, "no_overflow"),
    "word dropped under waitrequest": (lambda: Writer(forget=True), 10, "word_held"),
    "reset forgets the burst": (lambda: planted(Writer(), forgotten=[("left",)]), 12,
                                "burst_goes_on"),
    "a buffer too few": (lambda: Store(buffers_missing=1), 14, "space"),
    "a frame that is not complete": (lambda: Store(kind=BegunClaimed), 10, "alone1"),
    "a frame that is begun anew": (lambda: Store(kind=ForgottenReader), 14, "unchanged0"),
    "a burst that another breaks into": (lambda: Arbiter(kind=Impatient), 10, "burst_is_one1"),
    "samples lost without a word": (lambda: Pins(kind=Forgetful), 35, "nothing_lost"),
    "samples lost, four per clock": (lambda: Samples(4, ForgetfulPort), 24, "nothing_lost"),
    "credit too many": (lambda: Credits(credit_error=1), 16, "no_overflow"),
    "credits' queue too small": (lambda: planted(Credits(), entries_missing=1), 16, "no_overflow"),
    "tile too many": (lambda: FillSpace(kind=CreditTooMany), 30, "words_owed"),
    "fills' queues too small": (lambda: planted(FillSpace(128, 3), entries_missing=1), 20,
                                "no_overflow"),
    "slot too early": (lambda: FillOrder(kind=SlotEarly), 24, "slot"),
}

LONG_PLANTED = {
    "samples lost, two per clock": (lambda: Samples(2, ForgetfulPort), 26, "nothing_lost"),
    "no interlock, claimed twice": (lambda: Slots(tags=NoInterlock), 20, "filled_once"),
    "frames mixed": (lambda: Slots(tags=FramesMixed), 20, "own_tile"),
    "token not spent": (lambda: Progress(retire=TokenNotSpent), 26, "something_happens"),
    "ACTIVE too early": (lambda: SdramCommands(banks=sooner(rp=1)), 30, "rp0"),
    "DQ turned too early": (lambda: SdramCommands(banks=sooner(read_write=1)), 24, "turn"),
    "refresh that waits": (lambda: SdramCommands(kind=RefreshLast, period=16), 52,
                           "due_no_longer"),
    "words a clock late": (lambda: WordsRead(reads=1, late=1), 24, "own_word0"),
    "token early, counted": (lambda: Tokens(retire=TokenEarly), 20, "most_awaited"),
    "token early, seen": (lambda: Slots(retire=TokenEarly), 20, "own_tile"),
    "no interlock, seen": (lambda: Slots(tags=NoInterlock), 20, "own_tile"),
    "a read while words are written": (
        lambda: Tokens(retire=partial(ReadsWhileWritten, shared=True)), 20, "read_or_written"),
}


SHORT_COVERS = {"commands", "credits", "bursts of two hosts", "bursts cut at rows"}
LONGER_PLANTED = {
    "a word of another row", "READ too early", "burst that the memory forgot",
    "a word after the buffer", "a word before the buffer", "a read after the buffer",
    "word dropped under waitrequest", "reset forgets the burst", "a buffer too few",
    "samples lost without a word", "samples lost, four per clock",
    "tile too many", "fills' queues too small", "slot too early"}


def long_cases(rows):
    return [pytest.param(*value, id=f"{name}, {value[-1]} clocks" if len(value) == 3
                         and isinstance(value[-1], int) else name, marks=regress)
            for name, value in rows.items()]


@pytest.mark.parametrize("design,mode,depth", [
    *cases(PROOFS, longer=PROOFS.keys() - {"tokens"}), *long_cases(LONG)])
def test_holds(design, mode, depth, tmp_path):
    assert run(design(), tmp_path, mode=mode, depth=depth) == (PASS, set())


@pytest.mark.parametrize("design,depth,names", [
    *cases(COVERS, longer=COVERS.keys() - SHORT_COVERS), *long_cases(LONG_COVERS)])
def test_is_reached(design, depth, names, tmp_path):
    assert run(design(), tmp_path, mode="cover", depth=depth) == (PASS, names)


@pytest.mark.parametrize("design,depth,rule", [
    *cases(PLANTED, LONGER_PLANTED), *long_cases(LONG_PLANTED)])
def test_planted_error_is_found(design, depth, rule, tmp_path):
    status, names = run(design(), tmp_path, mode="bmc", depth=depth, only=rule)
    assert status == FAIL and {name.rpartition(".")[2] for name in names} == {rule}
