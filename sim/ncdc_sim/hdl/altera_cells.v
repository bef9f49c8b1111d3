// Models of the cells of Intel's devices that a design for Quartus names, written from their
// descriptions in Intel, "I/O Buffer (ALTIOBUF) IP Core User Guide" (UG-01024), "Double Data Rate I/O
// (ALTDDIO_IN, ALTDDIO_OUT, and ALTDDIO_BIDIR) IP Cores User Guide" (UG-DDRMGAFCTN), "ALTPLL IP Core
// User Guide" (UG-ALTPLL) and "Altera Phase-Locked Loop (Altera PLL) IP Core User Guide" (UG-01087).
// No delays but those of clocks.

`timescale 1ps/1ps

module altiobuf_in #(
    parameter enable_bus_hold = "FALSE", use_differential_mode = "FALSE", number_of_channels = 1
) (
    input wire  [number_of_channels-1:0] datain,
    output wire [number_of_channels-1:0] dataout
);
    assign dataout = datain;
endmodule

module altiobuf_out #(
    parameter enable_bus_hold = "FALSE", use_differential_mode = "FALSE", use_oe = "FALSE",
    parameter number_of_channels = 1
) (
    input wire  [number_of_channels-1:0] datain, oe,
    output wire [number_of_channels-1:0] dataout
);
    // Every output of the boards is driven always.
    assign dataout = datain;
    always @(oe)
        if (oe !== {number_of_channels{1'b1}} && $time > 1000000)
            $display("BOARD-ERROR an output is not driven");
endmodule

module altiobuf_bidir #(
    parameter enable_bus_hold = "FALSE", use_differential_mode = "FALSE", number_of_channels = 1
) (
    input wire  [number_of_channels-1:0] datain, oe,
    output wire [number_of_channels-1:0] dataout,
    inout wire  [number_of_channels-1:0] dataio
);
    genvar k;
    generate for (k = 0; k < number_of_channels; k = k + 1) begin : channel
        assign dataio[k] = oe[k] ? datain[k] : 1'bz;
    end endgenerate
    assign dataout = dataio;
endmodule

// Two bits a clock, both of the rising edge: `datain_h` while the clock is high, `datain_l` while it is
// low.
module altddio_out #(parameter width = 1) (
    input wire  [width-1:0] datain_h, datain_l,
    input wire              outclock,
    output wire [width-1:0] dataout
);
    reg [width-1:0] high, low, later, rises, falls;     // changes at each edge: no pulse of no length
    initial begin high = 0; low = 0; later = 0; rises = 0; falls = 0; end
    always @(posedge outclock) begin
        later <= datain_l;
        rises <= datain_h ^ falls;
    end
    always @(negedge outclock) falls <= later ^ rises;
    assign dataout = rises ^ falls;
endmodule

// Two bits a clock, both from the same rising edge: its own one, and that of the falling edge before it.
module altddio_in #(parameter width = 1) (
    input wire  [width-1:0] datain,
    input wire              inclock,
    output reg  [width-1:0] dataout_h, dataout_l
);
    reg [width-1:0] fell;
    initial begin fell = 0; dataout_h = 0; dataout_l = 0; end
    always @(negedge inclock) fell <= datain;
    always @(posedge inclock) begin
        dataout_h <= datain;
        dataout_l <= fell;
    end
endmodule

// The same two as LiteX writes them: Quartus knows its own functions in capitals too.
module ALTDDIO_OUT #(parameter WIDTH = 1) (
    input wire  [WIDTH-1:0] datain_h, datain_l,
    input wire              outclock,
    output wire [WIDTH-1:0] dataout
);
    altddio_out #(.width(WIDTH)) cell_ (
        .datain_h(datain_h), .datain_l(datain_l), .outclock(outclock), .dataout(dataout));
endmodule

module ALTDDIO_IN #(parameter WIDTH = 1) (
    input wire  [WIDTH-1:0] datain,
    input wire              inclock,
    output wire [WIDTH-1:0] dataout_h, dataout_l
);
    altddio_in #(.width(WIDTH)) cell_ (
        .datain(datain), .inclock(inclock), .dataout_h(dataout_h), .dataout_l(dataout_l));
endmodule

// Quartus' flip-flop with clear and preset, both low.
module DFF (input wire d, input wire clk, input wire clrn, input wire prn, output reg q);
    initial q = 0;
    always @(posedge clk or negedge clrn or negedge prn)
        if (!clrn) q <= 0;
        else if (!prn) q <= 1;
        else q <= d;
endmodule

module altera_std_synchronizer #(parameter depth = 3) (
    input wire clk, reset_n, din,
    output wire dout
);
    reg [depth-1:0] stages;
    initial stages = 0;
    always @(posedge clk or negedge reset_n)
        if (!reset_n) stages <= 0;
        else stages <= {stages[depth-2:0], din};
    assign dout = stages[depth-1];
endmodule

module altera_std_synchronizer_bundle #(parameter width = 1, depth = 3) (
    input wire              clk, reset_n,
    input wire  [width-1:0] din,
    output wire [width-1:0] dout
);
    genvar k;
    generate for (k = 0; k < width; k = k + 1) begin : bits
        altera_std_synchronizer #(.depth(depth)) one (
            .clk(clk), .reset_n(reset_n), .din(din[k]), .dout(dout[k]));
    end endgenerate
endmodule

// An output of a loop: so many edges per period, from `locked` on, late by some time.
module altera_loop_output (
    input wire  locked,
    input real  period, late,           // ps
    output reg  clock
);
    real start;
    integer edges;
    initial begin
        clock = 0;
        edges = 0;
        forever begin
            @(posedge locked);
            start = $realtime;
            edges = 0;
            clock = 0;
            // Edge k comes at its own multiple: no rounding adds up.
            while (locked) begin
                #(start + late + edges * period / 2 - $realtime);
                if (locked) clock = !clock;
                edges = edges + 1;
            end
        end
    end
endmodule

// Cyclone IV.
module altpll #(
    parameter OPERATION_MODE = "NORMAL", COMPENSATE_CLOCK = "CLK0", BANDWIDTH_TYPE = "AUTO",
    parameter PORT_LOCKED = "PORT_UNUSED", PORT_ARESET = "PORT_UNUSED",
    parameter PORT_CLK0 = "PORT_UNUSED", PORT_CLK1 = "PORT_UNUSED", PORT_CLK2 = "PORT_UNUSED",
    parameter WIDTH_CLOCK = 5, INCLK0_INPUT_FREQUENCY = 0,
    parameter CLK0_MULTIPLY_BY = 1, CLK0_DIVIDE_BY = 1, CLK0_DUTY_CYCLE = 50,
    parameter CLK1_MULTIPLY_BY = 1, CLK1_DIVIDE_BY = 1, CLK1_DUTY_CYCLE = 50,
    parameter CLK2_MULTIPLY_BY = 1, CLK2_DIVIDE_BY = 1, CLK2_DUTY_CYCLE = 50,
    parameter CLK0_PHASE_SHIFT = "0", CLK1_PHASE_SHIFT = "0", CLK2_PHASE_SHIFT = "0"
) (
    input wire [1:0]              inclk,
    input wire                    areset,
    output wire [WIDTH_CLOCK-1:0] clk,
    output wire                   locked
);
    wire [2:0] outputs;
    real late [0:2];
    integer found;
    initial begin
        found = $sscanf(CLK0_PHASE_SHIFT, "%f", late[0]);
        found = $sscanf(CLK1_PHASE_SHIFT, "%f", late[1]);
        found = $sscanf(CLK2_PHASE_SHIFT, "%f", late[2]);
    end
    altera_lock lock (.reference(inclk[0]), .reset(areset), .locked(locked));
    real last, period;                  // of the input, as it is
    initial last = 0;
    always @(posedge inclk[0]) begin
        if (!locked) period = $realtime - last;
        last = $realtime;
        if (locked && (period > INCLK0_INPUT_FREQUENCY + 1 || period < INCLK0_INPUT_FREQUENCY - 1))
            $display("BOARD-ERROR the input has %0f ps, not %0d", period, INCLK0_INPUT_FREQUENCY);
    end
    altera_loop_output output0 (.locked(locked), .late(late[0]), .clock(outputs[0]),
                                .period(period * CLK0_DIVIDE_BY / CLK0_MULTIPLY_BY));
    altera_loop_output output1 (.locked(locked), .late(late[1]), .clock(outputs[1]),
                                .period(period * CLK1_DIVIDE_BY / CLK1_MULTIPLY_BY));
    altera_loop_output output2 (.locked(locked), .late(late[2]), .clock(outputs[2]),
                                .period(period * CLK2_DIVIDE_BY / CLK2_MULTIPLY_BY));
    assign clk = {{(WIDTH_CLOCK-3){1'b0}}, outputs};
endmodule

// Cyclone V.
module altera_pll #(
    parameter fractional_vco_multiplier = "false", reference_clock_frequency = "",
    parameter operation_mode = "normal", pll_type = "General", pll_subtype = "General",
    parameter number_of_clocks = 1,
    parameter output_clock_frequency0 = "0 MHz", phase_shift0 = "0 ps", duty_cycle0 = 50,
    parameter output_clock_frequency1 = "0 MHz", phase_shift1 = "0 ps", duty_cycle1 = 50,
    parameter output_clock_frequency2 = "0 MHz", phase_shift2 = "0 ps", duty_cycle2 = 50
) (
    input wire                         refclk, rst, fbclk,
    output wire [number_of_clocks-1:0] outclk,
    output wire                        locked
);
    wire [2:0] outputs;
    real late [0:2];
    real mhz [0:2];
    real wanted, last, period;
    integer found;
    initial begin
        found = $sscanf(reference_clock_frequency, "%f MHz", wanted);
        found = $sscanf(output_clock_frequency0, "%f MHz", mhz[0]);
        found = $sscanf(output_clock_frequency1, "%f MHz", mhz[1]);
        found = $sscanf(output_clock_frequency2, "%f MHz", mhz[2]);
        found = $sscanf(phase_shift0, "%f ps", late[0]);
        found = $sscanf(phase_shift1, "%f ps", late[1]);
        found = $sscanf(phase_shift2, "%f ps", late[2]);
        last = 0;
    end
    altera_lock lock (.reference(refclk), .reset(rst), .locked(locked));
    always @(posedge refclk) begin
        if (!locked) period = $realtime - last;
        last = $realtime;
        if (locked && (period * wanted > 1000100 || period * wanted < 999900))
            $display("BOARD-ERROR the input has %0f ps, not %0f MHz", period, wanted);
    end
    altera_loop_output output0 (.locked(locked), .late(late[0]), .clock(outputs[0]),
                                .period(period * wanted / mhz[0]));
    altera_loop_output output1 (.locked(locked && number_of_clocks > 1), .late(late[1]),
                                .clock(outputs[1]), .period(period * wanted / mhz[1]));
    altera_loop_output output2 (.locked(locked && number_of_clocks > 2), .late(late[2]),
                                .clock(outputs[2]), .period(period * wanted / mhz[2]));
    assign outclk = outputs[number_of_clocks-1:0];
endmodule

// A loop is locked some edges of its input after the end of its reset.
module altera_lock (input wire reference, reset, output reg locked);
    integer edges;
    initial begin locked = 0; edges = 0; end
    always @(posedge reference or posedge reset)
        if (reset) begin
            edges <= 0;
            locked <= 0;
        end else begin
            edges <= edges == 8 ? 8 : edges + 1;
            locked <= edges == 8;
        end
endmodule
