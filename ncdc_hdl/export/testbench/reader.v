
// A memory with the raw frame that answers bursts of words in order after some clocks.
module ncdc_tb_reader #(
    parameter WIDTH = 32,
    parameter WORDS = 1,
    parameter COUNT = 5,                    // bits of the number of words of a burst
    parameter SEED = 1
) (
    input  wire             clk,
    input  wire             rst,
    input  wire [31:0]      address,        // in bytes
    input  wire             read,
    input  wire [COUNT-1:0] burstcount,
    output reg              waitrequest,
    output reg  [WIDTH-1:0] readdata,
    output reg              readdatavalid,
    output reg              last,           // of a burst
    output reg  [31:0]      outside         // words requested outside the frame
);
    localparam DEPTH = 64;
    reg [WIDTH-1:0] memory [0:WORDS-1];
    reg [31:0] first [0:DEPTH-1], left [0:DEPTH-1];       // word numbers, words to come
    reg [31:0] head, count, random, word;

    initial begin
        $readmemh("{{NAME}}_raw.hex", memory);
        outside = 0;
        random = 32'h2545F491 * SEED;
    end

    always @(posedge clk) begin
        random = {random[30:0], random[31] ^ random[21] ^ random[1] ^ random[0]};
        readdatavalid <= 0;
        if (rst) begin
            head = 0;
            count = 0;
            waitrequest <= 1;
        end else begin
            if (count != 0 && (count > 3 || random[5:4] != 0)) begin
                word = first[head];
                if (word >= WORDS) outside = outside + 1;
                readdata <= memory[word % WORDS];
                readdatavalid <= 1;
                last <= left[head] == 1;
                first[head] = word + 1;
                left[head] = left[head] - 1;
                if (left[head] == 0) begin
                    head = (head + 1) % DEPTH;
                    count = count - 1;
                end
            end
            if (read && !waitrequest) begin
                first[(head + count) % DEPTH] = address / (WIDTH / 8);
                left[(head + count) % DEPTH] = burstcount;
                count = count + 1;
            end
            waitrequest <= count > DEPTH - 4 || random[8:6] == 0;
        end
    end
endmodule
