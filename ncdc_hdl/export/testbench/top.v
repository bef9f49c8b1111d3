// A frame through {{MODULE}}, compared with the golden model's result. Made by
// ncdc generate --testbench, for any simulator:
//     $ iverilog -g2005 -s {{NAME}} -o {{NAME}} {{NAME}}.v {{MODULE}}.v && vvp {{NAME}}
//     $ verilator --binary --timing -CFLAGS -fcoroutines -Wno-fatal --top-module {{NAME}} {{NAME}}.v {{MODULE}}.v && obj_dir/V{{NAME}}
// It prints PASS, or FAIL and the differences. The registers have their values after configuration.

`timescale 1ns/1ps

module {{NAME}};
    localparam WIDTH = {{WIDTH}};           // bits of a word of the memory
    localparam LIMIT = {{LIMIT}};           // clocks that the frame may take

    reg clk = 0, rst = 1;
    always #5 clk = !clk;

{{WIRES}}

    // The host.
    reg  [{{ADDRESS_HIGH}}:0] csr_address = 0;
    reg         csr_write = 0;
    reg  [31:0] csr_writedata = 0;
    wire        csr_waitrequest;            // the host waits
    wire        irq;

    {{MODULE}} dut (
{{PORTS}}
    );

{{MODELS}}

    task put(input [31:0] address, input [31:0] value);
        begin
            csr_address <= address;
            csr_writedata <= value;
            csr_write <= 1;
            @(posedge clk);
            while (csr_waitrequest) @(posedge clk);
            csr_write <= 0;
            @(posedge clk);
        end
    endtask

    reg [31:0] clocks = 0, wrong;
    always @(posedge clk) clocks <= clocks + 1;

    initial begin
        repeat (20) @(posedge clk);
        rst <= 0;
        repeat (4) @(posedge clk);
        put({{IRQ_ENABLE}}, 1);
        put({{CTRL}}, {{START}});
        while (!irq && clocks < LIMIT) @(posedge clk);
        repeat (100) @(posedge clk);
        {{CHECK}}.compare(wrong);
        if (!irq)
            $display("FAIL: the frame is not done after %0d clocks", clocks);
        else if (wrong != 0{{OUTSIDE}})
            $display("FAIL: {{WHAT}} that differ: %0d of {{COUNT}}, or words outside the frames", wrong);
        else
            $display("PASS: {{COUNT}} {{WHAT}}, {{PIXELS}} pixels, in %0d clocks", clocks);
        $finish;
    end
endmodule
