"""The Verilog model of a sensor under cocotb."""

import numpy as np

from benches.sensor import LIGHT
from cocotb_run import Design, run_cocotb
from ncdc_hdl.camera.i2c import I2cController
from ncdc_hdl.export.verilog import module_verilog
from ncdc_sim.sensor.verilog import Light, sensor_sources

__all__ = ["controlled", "random_light", "run_sensor", "with_lines"]

_SENSOR = """
    sensor #(.SENSOR("{name}")) model (
        .extclk(extclk), .reset_n(reset_n), .pixclk(pixclk), .frame_valid(frame_valid),
        .line_valid(line_valid), .data(data), .scl(scl), .sda(sda), .sda_low(sda_low));
endmodule
"""
_WITH_LINES = """
module {top} (
    input wire extclk, input wire reset_n, input wire scl_o, input wire sda_o,
    output wire scl, output wire sda, output wire pixclk, output wire frame_valid,
    output wire line_valid, output wire [11:0] data
);
    wire sda_low;
    assign scl = scl_o;
    assign sda = sda_o && !sda_low;
""" + _SENSOR
_CONTROLLED = """
module {top} (
    input wire clk, input wire rst, input wire [15:0] quarter, input wire [31:0] limit,
    input wire [12:0] i__payload, input wire i__valid, output wire i__ready, output wire done,
    output wire [10:0] result, output wire scl, output wire sda, output wire frame_valid
);
    wire extclk = clk, reset_n = !rst, sda_low, controller_scl_low, controller_sda_low;
    wire pixclk, line_valid;
    wire [11:0] data;
    assign scl = !controller_scl_low;
    assign sda = !controller_sda_low && !sda_low;
    controller controls (
        .clk(clk), .rst(rst), .quarter(quarter), .limit(limit), .i__payload(i__payload),
        .i__valid(i__valid), .i__ready(i__ready), .done(done), .result(result),
        .scl_low(controller_scl_low), .sda_low(controller_sda_low), .scl(scl), .sda(sda));
""" + _SENSOR


def _text(template, name, *more):
    top = f"bench_{name}"
    texts = [text for _, text in sensor_sources()]
    return Design(top, "\n".join([template.replace("{top}", top).replace("{name}", name), *more,
                                  *texts]))


def with_lines(name):
    """:class:`Design` of the model, its lines open to a bench."""
    return _text(_WITH_LINES, name)


def controlled(name):
    """:class:`Design` of the model and our I2C controller on one bus."""
    design = _text(_CONTROLLED, name, module_verilog(I2cController(), "controller"))
    return Design("controlled" + design.top, design.verilog.replace(
        f"module {design.top} ", f"module controlled{design.top} "))


def random_light(shape, seed, left=0, top=0, nominal=0):
    """:class:`Light` of random samples."""
    frames = np.random.default_rng(seed).integers(0, 4096, shape, np.uint16)
    return Light(frames, left, top, nominal)


def run_sensor(name, simulator, asked, light, count=2, fault=None):
    """Compare ``count`` frames with the reference model's; ``asked``: fields of Settings."""
    more = {} if fault is None else {"fault": vars(fault)}
    return run_cocotb(with_lines(name), "sensor", simulator, files={LIGHT: light.data()},
                      plusargs=light.plusargs(LIGHT) + (fault.plusargs() if fault else []),
                      sensor=name, asked=asked, shape=light.frames.shape, count=count,
                      corner=[light.left, light.top], nominal=light.nominal, **more)
