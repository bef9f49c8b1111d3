// A scan-out, module `scan_out`, between a memory of frames, a store whose newest frame the plusargs
// choose, and a screen that writes what it is given in each pixel clock.
//
// Claim number k gets the buffer of digit k of `choices` (hexadecimal, the first one lowest); f: there
// is none. A frame begins 148 k modulo 400 bytes after its buffer's begin; the memory decodes the lower 16
// bits of an address. In the frame of claim number `starved` the memory takes no more than `commands` reads for
// `starves` clocks. screen.bin has four bytes for each pixel clock after the reset: blue, green,
// red, and bit 0 visible, 1 HSYNC, 2 VSYNC. The run ends `pixels` pixel clocks after the reset. Before, there
// are `resets` others, every second one of the memory as well, all but the last at times of the core alone.
// After the last one all begins anew. In pixel clock number `reset_at` after that, if it is not 0, the core alone
// is reset for `reset_clocks` of its clocks, and the screen is written on. If `reset_whole` is 1, all is reset and
// begins anew. Later the memory takes all reads.
//
// Lines: RESULT lines.

`timescale 1ns/1ps

module screen_bench (input wire clk, pixel);
    localparam BYTES = 65536, MAX_CLOCKS = 500_000;
    reg [127:0] chosen, choices;
    reg [31:0]  starved, starves, commands, pixels, resets, reset_at, reset_clocks,
                reset_whole;
    integer     content, screen;
    initial begin
        if (!$value$plusargs("choices=%h", chosen)) chosen = -1;
        if (!$value$plusargs("resets=%d", resets)) resets = 0;
        if (!$value$plusargs("starved=%d", starved)) starved = -1;
        if (!$value$plusargs("starves=%d", starves)) starves = 0;
        if (!$value$plusargs("commands=%d", commands)) commands = 0;
        if (!$value$plusargs("pixels=%d", pixels)) pixels = 1000;
        if (!$value$plusargs("reset_at=%d", reset_at)) reset_at = 0;
        if (!$value$plusargs("reset_clocks=%d", reset_clocks)) reset_clocks = 1;
        if (!$value$plusargs("reset_whole=%d", reset_whole)) reset_whole = 0;
        content = $fopen("content.bin", "rb");
        memory.load(content, 0, BYTES);
        screen = $fopen("screen.bin", "wb");
    end

    reg         rst = 1, pixel_rst = 1, memory_rst = 1, whole = 1, held = 0;
    reg  [31:0] base = 0, claims = 0, accepted = 0, since = 0, clocks = 0, pixel_clocks = 0;
    reg  [31:0] left = 8, hash;         // clocks until the reset ends, or the next one may begin
    reg  [31:0] owed = 0;               // words that the memory owes; a reset begins while there are some
    wire        claim, read, memory_waitrequest, valid;
    wire [31:0] address, readdata, shown, underruns, memory_errors, bus_errors;
    wire [3:0]  burstcount;
    wire [26:0] picture;
    wire        stalled = claims == starved + 1 && accepted >= commands && since < starves;
    wire        waitrequest = memory_waitrequest || stalled;
    scan_out dut (
        .clk(clk), .rst(rst), .pixel_clk(pixel), .pixel_rst(pixel_rst), .memory_rst(memory_rst),
        .screen__claim(claim), .screen__held(held), .screen__base(base),
        .bus__address(address), .bus__read(read), .bus__burstcount(burstcount),
        .bus__waitrequest(waitrequest), .bus__readdata(readdata), .bus__readdatavalid(valid),
        .picture(picture), .shown(shown), .underruns(underruns)
    );
    avalon_memory #(.PORTS(1), .DATA_WIDTH(32), .BURST_WIDTH(4), .BYTES(BYTES)) memory (
        .clk(clk), .rst(memory_rst), .errors(memory_errors), .read_address({16'd0, address[15:0]}),
        .read_read(read && !stalled), .read_burstcount(burstcount),
        .read_waitrequest(memory_waitrequest), .read_readdata(readdata),
        .read_readdatavalid(valid), .write_address(32'd0), .write_write(1'b0),
        .write_burstcount(5'd1), .write_writedata(32'd0), .write_byteenable(4'd0),
        .write_waitrequest()
    );
    avalon_checker #(.NAME("bus"), .DATA_WIDTH(32), .BURST_WIDTH(4), .MAX_BURST(8)) bus_checker (
        .clk(clk), .rst(clocks < 8), .host_rst(rst), .memory_rst(memory_rst), .address(address), .read(read),
        .write(1'b0), .burstcount(burstcount), .writedata(32'd0), .byteenable(4'd0),
        .waitrequest(waitrequest), .readdatavalid(valid), .errors(bus_errors), .commands(),
        .beats(), .bytes(), .waits()
    );

    // What each side gives in each of its clocks, as far as it is valid.
    wire [63:0] trace, shown_trace;
    digest #(.WORDS(1)) pixels_digest (.clk(pixel), .sum(shown_trace), .value({5'd0, picture}));
    digest #(.WORDS(4)) digest (.clk(clk), .sum(trace), .value({
        read ? address : 32'd0, read ? burstcount : 4'd0, 26'd0, read, claim, shown, underruns}));

    always @(posedge clk) begin
        clocks <= clocks + 1;
        since <= since + 1;
        if (clocks == MAX_CLOCKS) begin        // no reset comes, as no word is ever owed
            $display("RESULT clocks %0d", clocks);
            $finish;
        end
        if (left != 0) left <= left - 1;
        owed <= memory_rst ? 0 : owed + (read && !waitrequest ? burstcount : 0) - valid;
        hash = clocks * 32'h9E3779B1;
        if (left == 0 && rst) begin
            rst <= 0;
            memory_rst <= 0;
            left <= resets == 0 ? 32'hFFFFFFFF : 100 + hash[31:16] % 9000;
        end else if (left == 0 && owed != 0) begin
            rst <= 1;
            memory_rst <= resets[0];
            whole <= resets == 1 || hash[29];
            left <= resets == 1 || hash[29] ? 6 + hash[31:30] : 1 + hash[31:30];
            resets <= resets - 1;
        end else if (reset_at != 0 && pixel_clocks >= reset_at && resets == 0) begin
            rst <= 1;
            memory_rst <= reset_whole[0];
            whole <= reset_whole[0];
            left <= reset_clocks - 1;
            reset_at <= 0;
            starved <= -1;
        end
        // The base is a buffer's in the clock after a claim only.
        base <= hash;
        if (read && !waitrequest) accepted <= accepted + 1;
        if (rst) begin
            choices = chosen;
            claims <= 0;
            accepted <= 0;
            held <= 0;
        end else if (claim) begin
            held <= choices[3:0] != 4'hF;
            base <= {hash[31:16], choices[3:0], 12'd0} + 148 * claims % 400;
            choices = {4'hF, choices[127:4]};
            claims <= claims + 1;
            accepted <= 0;
            since <= 0;
        end
    end
    always @(posedge pixel) begin
        pixel_rst <= rst && whole;
        if (pixel_rst && pixel_clocks != 0) begin
            $fclose(screen);
            screen = $fopen("screen.bin", "wb");
            pixel_clocks = 0;
        end else if (!pixel_rst) begin
            $fwrite(screen, "%c%c%c%c", picture[7:0], picture[15:8], picture[23:16],
                    {5'd0, picture[26:24]});
            pixel_clocks = pixel_clocks + 1;
            if (pixel_clocks == pixels && resets == 0) begin
                $display("RESULT claims %0d", claims);
                $display("RESULT shown %0d", shown);
                $display("RESULT underruns %0d", underruns);
                $display("RESULT errors %0d", memory_errors + bus_errors);
                $display("RESULT trace %0d", trace);
                $display("RESULT shown_trace %0d", shown_trace);
                $display("RESULT clocks %0d", clocks);
                $fclose(screen);
                $finish;
            end
        end
    end
endmodule
