"""The camera's side of a system alone: capture and its parts, stores, the page of registers, hosts.

In the system each needs a simulation of the whole corrector, and its rare states hardly come.
"""


from amaranth import Cat, DomainRenamer

from mutation.system import make as make_system
from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.avalon.burst_writer import BurstWriter, word_layout
from ncdc_hdl.avalon.bus import PENDING
from ncdc_hdl.avalon.write_arbiter import WriteArbiter
from ncdc_hdl.camera.capture import Capture
from ncdc_hdl.camera.entry_packer import EntryPacker
from ncdc_hdl.camera.frame_store import FrameStore
from ncdc_hdl.camera.frame_writer import FrameWriter
from ncdc_hdl.camera.grid import Grid
from ncdc_hdl.camera.i2c import I2cController
from ncdc_hdl.camera.layouts import ENTRY
from ncdc_hdl.camera.level import Level
from ncdc_hdl.camera.moved import Moved
from ncdc_hdl.camera.parallel_source import ParallelSource
from ncdc_hdl.camera.readers import StoreReader
from ncdc_hdl.camera.run_control import RunControl
from ncdc_hdl.camera.sensor_port import SensorPort
from ncdc_hdl.lib.gains import BALANCE, NO_BALANCE
from ncdc_hdl.lib.relay import Relay
from ncdc_hdl.lib.word_crossing import WordCrossing
from simulations.traces import Alone, Recorded
from units.captures import check_capture, check_parallel_source
from units.crossings import check_queue, check_relay, check_word_crossing, queue_of
from units.frame_writers import check_burst_writer, check_frame_writer
from units.hosts import check_page, check_write_arbiter
from units.i2c_commands import check_i2c
from units.levels import check_level, check_moved
from units.sensor_entries import check_entry_packer, check_grid, check_sensor_port
from units.stores import check_frame_store, check_run_control, check_store_reader

__all__ = ["DESIGN"]

_TOP = "camera"
_WIDTH, _BURST = 64, 16     # of a word of memory; most words of a burst, as in the system


def _while(name, *outputs):
    """Outputs that mean something while the output ``name`` is high."""
    return dict.fromkeys(outputs, lambda part: _at(part, name))


def _at(part, name):
    for each in name.split("__"):
        part = getattr(part, each)
    return part


def _written(part):
    """Bits of the bytes that a bus writes in a clock."""
    bus = part.bus
    return Cat((bus.write & enable).replicate(8) for enable in bus.byteenable)


_PASSED = _while("bus__write", "bus__address", "bus__burstcount", "bus__writedata",
                 "bus__byteenable")
_BUS = _PASSED | {"bus__writedata": _written}


def _store(store):
    """A frame store; what a buffer is means something while it is in use."""
    means = _while("busy", "buffer") | _while("some", "newest")
    for k, _ in enumerate(store.readers):
        means |= {f"readers__{k}__buffer": lambda part, k=k: part.readers[k].held}
    return Alone(store, means=means), check_frame_store


def _sensor_side(row):
    """Parts in the sensor's clock, each after the parts that contain it."""
    packed = _while("valid", "row_end", "o")
    taken = {"o__sample": lambda part: part.o.valid}
    pushed = _while("push", "entry")
    return {name: (Alone(part, "camera", means), check) for name, part, means, check in (
        ("source", ParallelSource(), {"o__sample": lambda part: part.o.valid[0]},
         check_parallel_source),
        ("port", SensorPort(1, row), pushed, check_sensor_port),
        ("even", Grid(row), taken, check_grid),
        ("packer", EntryPacker(1), packed, check_entry_packer),
        ("moved", Moved(), {}, check_moved), ("levels", Level(), {}, check_level))}


def _crossings():
    """What a capture has between its parts and clocks, as it has it, under the same names."""
    queue = queue_of(ENTRY.size, Capture(_WIDTH, burst=_BURST).depth, "sync", "camera_queue")
    balance = DomainRenamer({"there": "camera"})(WordCrossing(BALANCE, init=NO_BALANCE))
    return {
        "entry_relay": (Alone(Relay(ENTRY), "camera", name="entries"), check_relay),
        "read_relay": (Alone(Relay(ENTRY), name="relay"), check_relay),
        "word_relay": (Alone(Relay(word_layout(_WIDTH)), name="words"), check_relay),
        "entry_queue": (Alone(queue, name="queue", other="camera_queue", reset_less=True),
                        check_queue),
        "balances": (Alone(balance, name="balance", other="camera"),
                     check_word_crossing)}


def units():
    """Each part, as the system has it, with its check, by name."""
    system = make_system()
    row, index = system.grid, len(system.raw.buffer)
    finished = _while("ends", "good")
    arbiter = WriteArbiter(_WIDTH, _BURST, 2)
    # Of equal modules the last instance is changed: parts come after those that contain them.
    return {
        "capture": (Alone(Capture(_WIDTH, burst=_BURST, grid=row), means=_BUS | finished),
                    check_capture),
        "writer": (Alone(FrameWriter(_WIDTH), means=finished), check_frame_writer),
        "bursts": (Alone(BurstWriter(_WIDTH, burst=_BURST), means=_BUS), check_burst_writer),
        "answered": (Alone(BurstWriter(_WIDTH, burst=_BURST, pending=PENDING), means=_BUS),
                     check_burst_writer),
        "raw": _store(FrameStore(len(system.raw.readers), looks=2)),
        "corrected": _store(FrameStore(len(system.corrected.readers))),
        "reader": (Alone(StoreReader(index)), check_store_reader),
        "control": (Alone(RunControl(), means=_while("target_ends", "target_good")),
                    check_run_control),
        "page": (Alone(system.page(), means=_while("bus__readdatavalid", "bus__readdata")),
                 check_page),
        "arbiter": (Alone(arbiter, means=_PASSED), check_write_arbiter),
        "arbiter_answers": (Alone(WriteArbiter(_WIDTH, _BURST, 3, PENDING), means=_PASSED),
                            check_write_arbiter),
        "i2c": (Alone(I2cController()), check_i2c)} | _sensor_side(row) | _crossings()


_RECORDED = Recorded(units, _TOP)
DESIGN = Design(_TOP, _TOP, _RECORDED.make, (PlayedBench("parts", _RECORDED.parts),), bare=2,
                leaves=(
    "capture.part.side.port", "capture.part.side.source", "capture.part.writer",
    "capture.part.bursts", "capture.part.entries", "capture.part.queue", "capture.part.balance",
    "port.part.grid", "port.part.packer"))
