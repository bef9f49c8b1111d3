
// Takes bursts of words, and compares its content with the expected picture.
module ncdc_tb_writer #(
    parameter WIDTH = 32,
    parameter WORDS = 1,
    parameter BASE = 0,                     // byte address of the picture
    parameter COUNT = 5
) (
    input  wire               clk,
    input  wire               rst,
    input  wire [31:0]        address,
    input  wire               write,
    input  wire [COUNT-1:0]   burstcount,
    input  wire [WIDTH-1:0]   writedata,
    input  wire [WIDTH/8-1:0] byteenable,
    output reg                waitrequest,
    output reg  [31:0]        outside
);
    reg [WIDTH-1:0] memory [0:WORDS-1], expected [0:WORDS-1], word;
    reg [31:0] index, left, random;
    integer k;

    initial begin
        $readmemh("{{NAME}}_expected.hex", expected);
        for (k = 0; k < WORDS; k = k + 1) memory[k] = {WIDTH/8{8'hA5}};
        outside = 0;
        random = 32'h5851F42D;
    end

    always @(posedge clk) begin
        random = {random[30:0], random[31] ^ random[21] ^ random[1] ^ random[0]};
        if (rst) begin
            left = 0;
            waitrequest <= 1;
        end else begin
            if (write && !waitrequest) begin
                if (left == 0) begin
                    index = (address - BASE) / (WIDTH / 8);
                    left = burstcount;
                end
                if (index >= WORDS) outside = outside + 1;
                else begin
                    word = memory[index];
                    for (k = 0; k < WIDTH / 8; k = k + 1)
                        if (byteenable[k]) word[8*k +: 8] = writedata[8*k +: 8];
                    memory[index] = word;
                end
                index = index + 1;
                left = left - 1;
            end
            waitrequest <= random[8:6] == 0;
        end
    end

    task compare(output [31:0] wrong);
        integer n;
        begin
            wrong = 0;
            for (n = 0; n < WORDS; n = n + 1)
                if (memory[n] !== expected[n]) begin
                    if (wrong < 10)
                        $display("word %0d is %h instead of %h", n, memory[n], expected[n]);
                    wrong = wrong + 1;
                end
        end
    endtask
endmodule
