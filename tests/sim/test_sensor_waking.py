"""The sensors' models answer no sooner than their data sheets say, after a long enough reset."""

import subprocess

import pytest

from cases import cases
from ncdc_sim.sensor.verilog import Fault, sensor_sources
from ncdc_sim.tools import environment, tool
from ncdc_spec.sensors.catalogue import SENSORS, sensor_named
from ncdc_spec.sensors.waking import Waking, wake_times

NAMES = [sensor.name for sensor in SENSORS]
CLOCK_HZ = 25_000_000
# Asks for the sensor's address so many us after the reset's end, and once more, later.
BENCH = """
`timescale 1ns/1ps
module bench;
    reg extclk = 0, reset_n = 0, scl = 1, out = 1;
    wire sda_low;
    wire sda = out && !sda_low;
    always #20 extclk = !extclk;
    integer low_us, first_us, second_us, k;
    sensor #(.SENSOR(`NAME)) dut (
        .extclk(extclk), .reset_n(reset_n), .pixclk(), .frame_valid(), .line_valid(), .data(),
        .scl(scl), .sda(sda), .sda_low(sda_low));
    task ask;
        reg [7:0] byte_;
        begin
            byte_ = `ADDRESS << 1;
            out = 0;
            #2500 scl = 0;
            for (k = 7; k >= 0; k = k - 1) begin
                #2500 out = byte_[k];
                #2500 scl = 1;
                #5000 scl = 0;
            end
            #2500 out = 1;
            #2500 scl = 1;
            #2500 $display("ACK %0d", !sda);
            #2500 scl = 0;
            #2500 out = 0;
            #2500 scl = 1;
            #2500 out = 1;
        end
    endtask
    initial force dut.core.streaming = 0;       // frames take time and do not matter
    initial begin
        if (!$value$plusargs("low_us=%d", low_us)) low_us = 0;
        if (!$value$plusargs("first_us=%d", first_us)) first_us = 0;
        if (!$value$plusargs("second_us=%d", second_us)) second_us = 0;
        #(low_us * 1000.0) reset_n = 1;
        #(first_us * 1000.0) ask;
        #(second_us * 1000.0) ask;
        $finish;
    end
endmodule
"""


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """Runs the bench for a sensor: what its answers were, and how many STARTs came too early."""
    built = {}

    def run(name, low_us, first_us, second_us, *more):
        if name not in built:
            folder = built[name] = tmp_path_factory.mktemp(name)
            files = {"bench.v": f'`define NAME "{name}"\n'
                                f"`define ADDRESS 8'd{sensor_named(name).i2c_address}\n{BENCH}"}
            for file, text in (files | dict(sensor_sources())).items():
                (folder / file).write_text(text)
            subprocess.run([tool("icarus"), "-g2012", "-s", "bench", "-o", "bench",
                            *files, *dict(sensor_sources())], cwd=folder, check=True,
                           env=environment())
        done = subprocess.run(
            ["vvp", "bench", f"+low_us={low_us}", f"+first_us={first_us}",
             f"+second_us={second_us}", *more], cwd=built[name], check=True, text=True,
            capture_output=True, env=environment())
        lines = done.stdout.splitlines()
        return [line == "ACK 1" for line in lines if line.startswith("ACK")], lines.count(
            "SENSOR early")

    return run


def rest_us(name):
    return float(sensor_named(name).waking.rest_at(CLOCK_HZ))


@pytest.mark.regress
@pytest.mark.parametrize("name", ["mt9p031", "mt9d111"])
def test_it_answers_from_its_time_on_and_not_before(bench, name):
    """True times; between the two questions is less than a hundredth of the rest. Not of the
    OV5640, whose 65,536 registers are reset in every clock of a reset: that takes minutes."""
    need = round(rest_us(name))
    assert bench(name, 1001, need - 150, 80) == ([False, True], 1)


@pytest.mark.parametrize("name", cases(NAMES, longer=["ov5640"]))
def test_a_hundredth_of_the_times(bench, name):
    need = round(rest_us(name) / 100)
    assert bench(name, 11, need + 1, 1, "+sensor_time_scale=100") == ([True, True], 0)
    # A reset that is too short does not wake it, however long it rests.
    assert bench(name, 9, need + 1, need, "+sensor_time_scale=100") == ([False, False], 2)


@pytest.mark.longer
def test_without_its_supply_it_sleeps_until_another_reset(bench):
    unplugged = Fault("unplug", start=1000, clocks=500).plusargs()
    awake = "mt9d111", 11, 250, 500, "+sensor_time_scale=100"
    assert bench(*awake, *unplugged) == ([False, False], 2)
    assert bench(*awake) == ([True, True], 0)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("clock_hz", (6_000_000, CLOCK_HZ))
def test_a_board_gives_more_than_that(name, clock_hz):
    waking = sensor_named(name).waking
    reset, rest = wake_times(waking, clock_hz)
    assert reset >= max(5000, 1.1 * waking.reset_us)
    assert rest >= max(40_000, 1.1 * float(waking.rest_at(clock_hz)))
    assert waking.source


def test_the_data_count_and_not_only_the_boards_least():
    assert wake_times(Waking(10_000, 0, 1_000_000, ""), 10_000_000) == (11_500, 115_000)
