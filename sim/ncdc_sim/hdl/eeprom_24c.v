// EEPROM of the 24C kind at an I2C bus: up to 2048 bytes it has addresses of one byte, whose upper bits are
// in the chip's own address; a larger one has addresses of two bytes.
//
// A write begins with STOP, and takes bytes of one page, at whose end the address goes back to its
// beginning. While it lasts the chip does not answer to its own address; data without STOP write
// nothing. A read goes on from byte to byte, and after the last one with the first. SCL and SDA are
// sampled with `clk`, at least 16 times as fast as a bit.
//
// The plusarg eeprom_file=<name> names a file of its content, with ones after it. Without it there is
// no chip.

`timescale 1ns/1ps

module eeprom_24c #(
    parameter BYTES = 4096,             // a power of 2, 256 to 65536
    parameter PAGE = 32,                // bytes, a power of 2
    parameter [2:0] PINS = 0,           // A2..A0
    parameter WRITE_CLOCKS = 500,       // of `clk`, that a write lasts
    parameter FILE = "eeprom_file=%s"   // the plusarg
) (
    input  wire clk,
    input  wire scl,                    // the lines, as all that pull them leave them
    input  wire sda,
    output reg  sda_low                 // pulls SDA low
);
    localparam WIDE = BYTES > 2048;
    localparam [2:0] BLOCK = WIDE ? 0 : BYTES / 256 - 1;    // bits of the chip's address that are the byte's
    localparam [15:0] IN_CHIP = BYTES - 1, IN_PAGE = PAGE - 1;
    localparam IDLE = 0, SELECT = 1, POINT = 2, TAKE = 3, GIVE = 4;

    reg [7:0]      content [0:BYTES-1];
    reg [7:0]      page [0:PAGE-1];     // data of the write to come
    reg [PAGE-1:0] given;               // bytes of `page` that it has
    reg            present;
    reg [31:0]     busy;                // clocks of a write to come
    reg [2:0]      state;
    reg            scl_was, sda_was;
    reg [3:0]      bits;                // of the byte and its acknowledge that have come
    reg [7:0]      shift;               // a byte that comes or goes
    reg            upper;               // the byte is the upper one of the address
    reg            nack;                // the controller did not acknowledge
    reg [15:0]     pointer;

    reg [8*256-1:0] name;
    integer         file, k;
    initial begin
        for (k = 0; k < BYTES; k = k + 1) content[k] = 8'hFF;
        present = 0;
        if ($value$plusargs(FILE, name)) begin
            file = $fopen(name, "rb");
            present = file != 0;
            if (present) begin
                k = $fread(content, file);
                $fclose(file);
            end
        end
        {sda_low, busy, state, scl_was, sda_was, bits, pointer, given} = 0;
    end

    wire mine = shift[7:4] == 4'hA && ((shift[3:1] ^ PINS) & ~BLOCK) == 0 && busy == 0;
    wire [15:0] next = pointer + 1;
    wire [7:0]  byte_there = content[pointer & IN_CHIP];

    // After the last bit of a byte that came: its meaning, and whether it is acknowledged.
    task take;
        begin
            sda_low <= 1;
            case (state)
                SELECT:
                    if (!mine) begin
                        state <= IDLE;
                        sda_low <= 0;
                    end else if (shift[0])
                        state <= GIVE;
                    else begin
                        state <= POINT;
                        upper <= WIDE;
                        if (!WIDE)
                            pointer[15:8] <= shift[3:1] & BLOCK;
                    end
                POINT: begin
                    upper <= 0;
                    if (upper)
                        pointer[15:8] <= shift;
                    else begin
                        pointer[7:0] <= shift;
                        state <= TAKE;
                    end
                end
                default: begin          // TAKE
                    page[pointer & IN_PAGE] <= shift;
                    given[pointer & IN_PAGE] <= 1;
                    pointer <= (pointer & ~IN_PAGE) | (next & IN_PAGE);
                end
            endcase
        end
    endtask

    task fall;
        begin
            if (bits == 8) begin
                if (state == GIVE) begin
                    sda_low <= 0;
                    pointer <= next;
                end else
                    take;
            end else if (bits == 9) begin
                bits <= 0;
                sda_low <= 0;
                if (state == GIVE && nack)
                    state <= IDLE;
                else if (state == GIVE) begin
                    shift <= {byte_there[6:0], 1'b0};
                    sda_low <= !byte_there[7];
                end
            end else if (state == GIVE) begin
                shift <= {shift[6:0], 1'b0};
                sda_low <= !shift[7];
            end
        end
    endtask

    // SCL has risen once more since the acknowledge of the last byte.
    task stop;
        integer j;
        begin
            state <= IDLE;
            sda_low <= 0;
            if (state == TAKE && bits == 1 && given != 0) begin
                busy <= WRITE_CLOCKS;
                for (j = 0; j < PAGE; j = j + 1)
                    if (given[j])
                        content[pointer & IN_CHIP & ~IN_PAGE | j] <= page[j];
            end
        end
    endtask

    always @(posedge clk) if (present) begin
        scl_was <= scl;
        sda_was <= sda;
        if (busy != 0)
            busy <= busy - 1;
        if (scl && scl_was && sda_was && !sda) begin
            state <= SELECT;            // START
            bits <= 0;
            given <= 0;
            sda_low <= 0;
        end else if (scl && scl_was && !sda_was && sda)
            stop;
        else if (state != IDLE && scl && !scl_was) begin
            if (bits < 8 && state != GIVE)
                shift <= {shift[6:0], sda};
            if (bits == 8)
                nack <= sda;
            bits <= bits + 1;
        end else if (state != IDLE && !scl && scl_was)
            fall;
    end
endmodule
