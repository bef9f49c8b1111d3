// Ports of the Altera modules that a board's top instantiates; nothing inside.
module altpll #(parameter OPERATION_MODE = 0, INCLK0_INPUT_FREQUENCY = 0, CLK0_MULTIPLY_BY = 0,
                CLK0_DIVIDE_BY = 0, CLK1_MULTIPLY_BY = 0, CLK1_DIVIDE_BY = 0, CLK1_PHASE_SHIFT = 0,
                PORT_CLK0 = 0, PORT_CLK1 = 0, PORT_LOCKED = 0, WIDTH_CLOCK = 5)
    (input [1:0] inclk, input areset, output [4:0] clk, output locked);
endmodule

module altiobuf_in #(parameter enable_bus_hold = 0, number_of_channels = 1,
                     use_differential_mode = 0)
    (input [number_of_channels-1:0] datain, output [number_of_channels-1:0] dataout);
endmodule

module altiobuf_out #(parameter enable_bus_hold = 0, number_of_channels = 1,
                      use_differential_mode = 0, use_oe = 0)
    (input [number_of_channels-1:0] datain, oe, output [number_of_channels-1:0] dataout);
endmodule

module altiobuf_bidir #(parameter enable_bus_hold = 0, number_of_channels = 1,
                        use_differential_mode = 0)
    (input [number_of_channels-1:0] datain, oe, output [number_of_channels-1:0] dataout,
     inout [number_of_channels-1:0] dataio);
endmodule

module altera_std_synchronizer #(parameter depth = 2)
    (input clk, reset_n, din, output dout);
endmodule

module altera_std_synchronizer_bundle #(parameter depth = 2, width = 1)
    (input clk, reset_n, input [width-1:0] din, output [width-1:0] dout);
endmodule
