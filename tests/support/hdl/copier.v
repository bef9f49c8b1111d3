// Stand-in for the corrector, to test the frame bench: copies words, inverted, burst by burst.
// Registers: 0 source, 1 destination, 2 words (a multiple of 8), 3 start, 4 done (write clears),
// 5 constant 4E434443. COPIER_STREAM sends the low 24 bits of each inverted word as a pixel.
// The macros are replaced before the simulator reads this. COPIER_FAULT: 1 changes write data under
// waitrequest, 2 never ends, 3 misaligned reads, 4 changes stream data while it is stalled.

module ncdc(clk, rst, memory_rst, csr_address, csr_read, csr_write, csr_writedata, csr_readdata,
        csr_readdatavalid, csr_waitrequest, irq, camera_rows, front_end_idle,
        read0_address, read0_read, read0_burstcount, read0_waitrequest, read0_readdata,
        read0_readdatavalid,
`ifdef COPIER_STREAM
        stream_valid, stream_ready, stream_data, stream_startofpacket, stream_endofpacket);
`else
        write_address, write_write, write_burstcount, write_writedata, write_byteenable,
        write_waitrequest);
`endif
    input clk;
    input rst;
    input memory_rst;
    input [13:0] csr_address;
    input csr_read;
    input csr_write;
    input [31:0] csr_writedata;
    output reg [31:0] csr_readdata;
    output reg csr_readdatavalid;
    output csr_waitrequest;
    output reg irq;
    input [12:0] camera_rows;
    output front_end_idle;
    output [31:0] read0_address;
    output read0_read;
    output [3:0] read0_burstcount;
    input read0_waitrequest;
    input [`COPIER_WIDTH-1:0] read0_readdata;
    input read0_readdatavalid;
`ifdef COPIER_STREAM
    output stream_valid;
    input stream_ready;
    output [23:0] stream_data;
    output stream_startofpacket;
    output stream_endofpacket;
    wire write_write;
    wire [`COPIER_WIDTH-1:0] write_writedata;
    wire write_waitrequest = !stream_ready;
`else
    output [31:0] write_address;
    output write_write;
    output [3:0] write_burstcount;
    output [`COPIER_WIDTH-1:0] write_writedata;
    output [`COPIER_WIDTH/8-1:0] write_byteenable;
    input write_waitrequest;
`endif

    reg [31:0] source, destination, words, position;
    reg [`COPIER_WIDTH-1:0] buffer [0:7];
    reg [2:0] state;
    reg [3:0] beat;
    reg stalled;

    localparam IDLE = 0, ASK = 1, TAKE = 2, GIVE = 3;

    assign csr_waitrequest = 0;
    assign front_end_idle = state == IDLE;
    assign read0_read = state == ASK;
    assign read0_address = source + position * (`COPIER_WIDTH / 8) + (`COPIER_FAULT == 3);
    assign read0_burstcount = 8;
    assign write_write = state == GIVE;
    assign write_writedata = ~buffer[beat] + (`COPIER_FAULT == 1 && stalled);
`ifdef COPIER_STREAM
    assign stream_valid = state == GIVE;
    assign stream_data = ~buffer[beat] + (`COPIER_FAULT == 4 && stalled);
    assign stream_startofpacket = position == 0 && beat == 0;
    assign stream_endofpacket = position + 8 == words && beat == 7;
`else
    assign write_address = destination + position * (`COPIER_WIDTH / 8);
    assign write_burstcount = 8;
    assign write_byteenable = {`COPIER_WIDTH/8{1'b1}};
`endif

    always @(posedge clk) begin
        csr_readdatavalid <= csr_read;
        csr_readdata <= csr_address == 5 ? 32'h4E434443 : csr_address == 2 ? words : 0;
        stalled <= write_write && write_waitrequest;
        if (csr_write)
            case (csr_address)
                0: source <= csr_writedata;
                1: destination <= csr_writedata;
                2: words <= csr_writedata;
                3: begin state <= ASK; position <= 0; end
                4: irq <= 0;
            endcase
        case (state)
            ASK: if (!read0_waitrequest) begin
                state <= TAKE;
                beat <= 0;
            end
            TAKE: if (read0_readdatavalid) begin
                buffer[beat] <= read0_readdata;
                beat <= beat + 1;
                if (beat == 7) begin
                    state <= GIVE;
                    beat <= 0;
                end
            end
            GIVE: if (!write_waitrequest) begin
                beat <= beat + 1;
                if (beat == 7) begin
                    position <= position + 8;
                    state <= position + 8 == words ? IDLE : ASK;
                    irq <= position + 8 == words && `COPIER_FAULT != 2;
                end
            end
        endcase
        if (rst) begin
            state <= IDLE;
            irq <= 0;
            stalled <= 0;
        end
    end
endmodule
