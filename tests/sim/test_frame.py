"""Whole frames through the bench, with a stand-in for the corrector."""

import numpy as np
import pytest

from copier import copier
from ncdc_model.planner.memory_timing import LatencyMemory
from ncdc_sim.system.frame import Program, simulate_frame
from ncdc_sim.tools import SIMULATORS, SimulationError
from ncdc_spec.errors import InputError

WORDS = 512
SOURCE, OUTPUT = 0x2000, 0x10000
WORDS_REGISTER, MAGIC_REGISTER, MAGIC = 2, 5, 0x4E434443


def program(words=WORDS):
    return (Program().compare(MAGIC_REGISTER, MAGIC).write(0, SOURCE).write(1, OUTPUT)
            .write(2, words).write(3, 1).wait_irq().read(WORDS_REGISTER).write(4, 0))


def frame(width=32, words=WORDS):
    return np.random.default_rng(1).integers(0, 256, words * width // 8, np.uint8)


def copy(verilog, width=32, words=WORDS, **options):
    options = {"program": program(words), "output_bytes": words * width // 8} | options
    return simulate_frame(verilog, frame(width, words).tobytes(), source_base=SOURCE,
                          output_base=OUTPUT, **options)


@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("width", [32, 128])
@pytest.mark.parametrize("memory", ["ideal", "hostile", "sdram", "ddr3@150"])
def test_copies(memory, width, simulator):
    result = copy(copier(width), width, memory=memory, simulator=simulator)
    np.testing.assert_array_equal(np.frombuffer(result.output, np.uint8), ~frame(width))
    assert result.bytes_read == (WORDS * width // 8,)
    assert result.bytes_written == WORDS * width // 8
    assert result.registers == {WORDS_REGISTER: WORDS}
    assert result.counters["read0_commands"] == result.counters["output_commands"] == WORDS // 8


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_a_memory_that_decodes_some_bits_holds_frames_far_apart(simulator):
    """Bytes outside count with all bits of their addresses."""
    far = (Program().allow((1 << 31, (1 << 31) + (1 << 30)), (3 << 30, 0xFFFFFFFF))
           .write(0, 1 << 31 | SOURCE).write(1, 3 << 30 | OUTPUT).write(2, WORDS).write(3, 1)
           .wait_irq().write(4, 0))
    result = copy(copier(), program=far, decoded=24, simulator=simulator)
    np.testing.assert_array_equal(np.frombuffer(result.output, np.uint8), ~frame())
    assert result.counters["outside_bytes"] == 0
    near = copy(copier(), program=program(), decoded=24, simulator=simulator)
    assert near.counters["outside_bytes"] == 0


def test_a_transcript_runs_again():
    transcripts = []
    result = copy(copier(), transcripts=transcripts)
    [one] = transcripts
    assert one.written == {"output.bin": result.output}
    assert f"FRAME {result.clocks[0]} {result.ends[0]} {result.outputs[0]}" in one.report["lines"]
    assert not any(line.startswith(("PROGRESS", "- ")) for line in one.report["lines"])


@pytest.mark.parametrize("sink_probability", [256, 100])
@pytest.mark.parametrize("simulator", SIMULATORS)
def test_streams(simulator, sink_probability):
    result = copy(copier(stream=True), simulator=simulator, sink_probability=sink_probability,
                  output_bytes=3 * WORDS)
    pixels = (~frame()).reshape(-1, 4)[:, 2::-1]
    np.testing.assert_array_equal(np.frombuffer(result.output, np.uint8), pixels.ravel())
    assert result.counters["output_commands"] == 1
    assert (result.counters["output_waits"] > 0) == (sink_probability < 256)


@pytest.mark.parametrize("latency", [1, 2, 37])
def test_latency_is_exact(latency):
    """A burst of the copier takes a clock to ask, 8 beats in, 8 beats out, and the latency."""
    result = copy(copier(), memory=LatencyMemory(latency=(latency, latency)))
    assert result.clocks == (WORDS // 8 * (16 + latency) + 1,)


@pytest.mark.parametrize("bytes_per_clock", [3.5, 1.0, 0.25])
def test_bandwidth_is_met(bytes_per_clock):
    result = copy(copier(), memory=LatencyMemory(bytes_per_clock=bytes_per_clock))
    # Before the start two beats are saved up; each burst idles a clock or two at its turns.
    least = (2 * WORDS - 2) * 4 / bytes_per_clock - 1
    assert least <= result.clocks[0] <= least + WORDS // 8 * 3


def test_simulators_agree_on_every_clock():
    results = [copy(copier(), memory="hostile", seed=5, simulator=s) for s in SIMULATORS]
    assert results[0] == results[1]


def test_seed_changes_the_timing():
    clocks = [copy(copier(), memory="hostile", seed=seed).clocks for seed in (1, 9)]
    assert clocks[0] != clocks[1]


@pytest.mark.parametrize("simulator", [
    "icarus", pytest.param("verilator", marks=pytest.mark.regress)])
@pytest.mark.parametrize("fault,stream,message", [
    (1, False, "AVALON-ERROR write held"), (2, False, "FAILED clock-limit 4000 clocks"),
    (3, False, "AVALON-ERROR read0 aligned"), (4, True, "AVALON-ERROR stream held")])
def test_faults_are_named(fault, stream, message, simulator):
    with pytest.raises(SimulationError, match=message):
        copy(copier(stream=stream, fault=fault), memory=LatencyMemory(wait_probability=100),
             simulator=simulator, sink_probability=128, clock_limit=4000)


def test_output_that_was_not_written_is_seen():
    result = copy(copier(), output_bytes=4 * WORDS + 16)
    assert result.output[-16:] == bytes([0xA5] * 16)


def test_access_beyond_the_memory():
    with pytest.raises(SimulationError, match="memory read-range"):
        copy(copier(), program=Program().write(0, 0x20000000).write(1, OUTPUT).write(2, 8)
             .write(3, 1).wait_irq())


def test_two_frames_of_other_buffers():
    """Registers written between two frames: each goes from its own source to its own buffer."""
    half = WORDS // 2
    steps = program(half)
    steps.write(0, SOURCE + 4 * half).write(1, OUTPUT + 4 * half).write(3, 1).wait_irq()
    result = copy(copier(), program=steps, memory="sdram")
    np.testing.assert_array_equal(np.frombuffer(result.output, np.uint8), ~frame())
    assert len(result.clocks) == len(result.ends) == 2
    assert result.ends[1] - result.ends[0] > result.clocks[1]


def reset_after(*waits):
    """The stream's pixels when the copier is reset in its first frame and does another one."""
    steps = Program().write(0, SOURCE).write(1, OUTPUT).write(2, WORDS).write(3, 1)
    for wait in waits:
        wait(steps)
    steps.reset().write(0, SOURCE).write(1, OUTPUT).write(2, WORDS).write(3, 1).wait_irq()
    result = copy(copier(stream=True), program=steps, output_bytes=6 * WORDS,
                  memory=LatencyMemory(latency=(40, 40)))
    assert len(result.resets) == 1
    return result.output[:result.resets[0]], result.output[result.resets[0]:]


def test_reset_in_mid_frame():
    pixels = (~frame()).reshape(-1, 4)[:, 2::-1].tobytes()
    first, second = reset_after(lambda steps: steps.wait_output(3 * 100))
    assert 300 <= len(first) < 320 and pixels.startswith(first)
    # Sent in the clock in which the reset begins.
    assert len(second) - len(pixels) in (0, 3) and second.endswith(pixels)


def test_words_under_way_survive_a_reset():
    """The copier forgets at a reset what it has asked for, so its next frame is wrong."""
    pixels = (~frame()).reshape(-1, 4)[:, 2::-1].tobytes()
    first, second = reset_after(lambda steps: steps.wait_output(3 * 100).wait(30))
    assert pixels.startswith(first) and len(second) == len(pixels)
    assert second[:24] == pixels[len(first):len(first) + 24]


def test_poll():
    steps = Program().write(2, 7).poll(WORDS_REGISTER, 7).wait(50).read(WORDS_REGISTER)
    assert copy(copier(), program=steps).registers == {WORDS_REGISTER: 7}
    with pytest.raises(SimulationError, match="FAILED clock-limit 3000 clocks"):
        copy(copier(), program=Program().poll(WORDS_REGISTER, 8), clock_limit=3000)


def test_wrong_register_value():
    with pytest.raises(SimulationError, match="word 5 reads 4e434443 instead of 00000001"):
        copy(copier(), program=Program().compare(MAGIC_REGISTER, 1))


def test_progress_rises_to_one():
    seen = []
    copy(copier(), progress=seen.append)
    assert len(seen) > 20 and seen == sorted(seen) and seen[-1] == 1.0


def test_verilog_that_does_not_compile():
    with pytest.raises(SimulationError, match="verilator failed"):
        copy(copier().replace("endmodule", "assign nothing = ;\nendmodule"))


@pytest.mark.parametrize("options,message", [
    ({"memory": "sram"},
     "memory is 'sram', one of ideal, sdram, ddr3, ddr3-1066, hps, hostile, litedram"),
    ({"simulator": "questa"}, "simulator is 'questa', one of verilator, icarus is needed"),
    ({"memory": "fixed:0:3"}, r"latency is 0\.\.0 clocks, the limits are 1")])
def test_bad_options(options, message):
    with pytest.raises(InputError, match=message):
        copy(copier(), **options)


def test_bad_module():
    with pytest.raises(InputError, match="no module ncdc"):
        copy("module other();\nendmodule\n")
    with pytest.raises(InputError, match="1 read ports of 16 bits"):
        copy(copier(16))


def test_bad_base():
    with pytest.raises(InputError, match="multiples of 16"):
        simulate_frame(copier(), b"", program(), source_base=8, output_base=0, output_bytes=16)


def test_warnings_that_are_not_waived_are_shown():
    with pytest.raises(SimulationError, match="%Warning-PINMISSING"):
        copy(copier().replace("endmodule", "part p();\nendmodule")
             + "module part(input a);\nendmodule\n")
