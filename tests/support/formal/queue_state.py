"""What the registers of a queue hold: said in the queue itself, for proofs by induction."""

from contextlib import ExitStack, contextmanager
from unittest import mock

from amaranth import *
from amaranth.hdl import Assert, Fragment
from amaranth.lib.fifo import SyncFIFOBuffered

from formal.properties import Property, always, inner
from ncdc_hdl.lib.memory import Fifo

__all__ = ["entries", "opened"]


@contextmanager
def opened(queues, entries_missing):
    """Queues elaborated meanwhile are added to ``queues``, and assert that nothing is written into
    them while they are full. Each has ``entries_missing`` entries less than it was made with."""
    def smaller(create):
        def init(queue, *, depth, **options):
            create(queue, depth=depth - entries_missing, **options)
        return init

    def checked(elaborate, rows_of, state):
        def with_properties(queue, platform):
            within = elaborate(queue, platform)
            queues.append(queue)
            rows = rows_of(queue)
            if rows:
                # The memory itself, for induction.
                ports = [within.submodules.storage.read_port(domain="comb") for _ in range(rows)]
                within.d.comb += [port.addr.eq(row) for row, port in enumerate(ports)]
                queue.rows = [port.data for port in ports]
                queue.read = within.submodules.storage.read_ports[0].data
            fragment = Fragment.get(within, platform)
            _say(fragment, ~queue.w_en | queue.w_rdy, "no_overflow")
            queue.output = state(queue, fragment)
            queue.pointers = inner(fragment, "consume"), inner(fragment, "produce")
            return fragment
        return with_properties

    with ExitStack() as patches:
        for kind, rows_of, state in (
                (SyncFIFOBuffered, lambda queue: queue.depth - 1, _library),
                (Fifo, lambda queue: queue.words, _own)):
            for name, changed in (("elaborate", checked(kind.elaborate, rows_of, state)),
                                  ("__init__", smaller(kind.__init__))):
                patches.enter_context(mock.patch.object(kind, name, changed))
        yield


def _say(fragment, condition, name):
    """:func:`always`, in a part of the design that is elaborated already."""
    fragment.add_subfragment(Fragment.get(Property(Assert, condition, name), None), name)


def _library(queue, fragment):
    """(Whether it is there, item) of what is no longer in the memory."""
    stored = queue.level - queue.r_rdy
    _say(fragment, (queue.level >= queue.r_rdy) & (stored <= max(1, queue.depth - 1)),
         "stored_words")
    _say(fragment, queue.r_rdy | (stored <= 1), "output_first")
    return [(queue.r_rdy, queue.r_data)]


def _own(queue, fragment):
    """The same of a queue with two stages after the memory."""
    stored, read_valid, both, some = (inner(fragment, name) for name in (
        "stored", "read_valid", "both", "some"))
    _say(fragment, queue.level == stored + read_valid + queue.r_rdy, "stored_words")
    _say(fragment, queue.level <= queue.depth, "level_limit")
    _say(fragment, some == (stored != 0), "some_flag")
    _say(fragment, both == (read_valid & queue.r_rdy), "both_flag")
    _say(fragment, (read_valid & queue.r_rdy) | (stored <= 1), "output_first")
    return [(queue.r_rdy, queue.r_data), (read_valid, queue.read)]


def entries(m, queue):
    """(Whether it is there, item) of each entry in a queue of at least three."""
    (consume, produce), rows = queue.pointers, len(queue.rows)
    stored = queue.level - sum(there for there, _ in queue.output)
    end = consume + stored
    always(m, (consume < rows) & (produce == Mux(end >= rows, end - rows, end)),
           f"pointers{len(queue.r_data)}")
    return queue.output + [
        (Mux(consume <= row, row - consume, row + rows - consume) < stored, item)
        for row, item in enumerate(queue.rows)]
