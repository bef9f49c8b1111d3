
// Takes the pixels of a stream, and compares them with those of the expected picture.
module ncdc_tb_sink #(
    parameter WIDTH = 24,
    parameter WORDS = 1,                    // groups of pixels of the frame
    parameter ROW = 1                       // groups of a row
) (
    input  wire             clk,
    input  wire             rst,
    input  wire             valid,
    output reg              ready,
    input  wire [WIDTH-1:0] data,
    input  wire             first,          // of the frame
    input  wire             last            // of the frame, or of the row
);
    reg [WIDTH-1:0] expected [0:WORDS-1];
    reg [31:0] taken, faults, random;

    initial begin
        $readmemh("{{NAME}}_expected.hex", expected);
        taken = 0;
        faults = 0;
        random = 32'h5851F42D;
    end

    always @(posedge clk) begin
        random = {random[30:0], random[31] ^ random[21] ^ random[1] ^ random[0]};
        ready <= !rst && random[8:6] != 0;
        if (!rst && valid && ready) begin
            if (taken >= WORDS || data !== expected[taken % WORDS] || first !== (taken == 0)
                    || last !== (taken % ROW == ROW - 1)) begin
                if (faults < 10)
                    $display("group %0d is %h (%b %b) instead of %h", taken, data, first, last,
                             expected[taken % WORDS]);
                faults = faults + 1;
            end
            taken = taken + 1;
        end
    end

    task compare(output [31:0] wrong);
        begin
            wrong = faults + (taken < WORDS ? WORDS - taken : 0);
        end
    endtask
endmodule
