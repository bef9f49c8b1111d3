// A monitor at the lanes of a DVI link, written from the "Digital Visual Interface" specification 1.0
// (Digital Display Working Group). It recovers the bits from the clock lane's frequency alone, finds
// the words of each lane by runs of control words, decodes them, and writes each pixel clock as four
// bytes: red, green, blue, and bit 0 visible, 1 HSYNC, 2 VSYNC.
//
// Prints "MONITOR-ERROR <reason>" when lanes disagree on what is visible, or a word is none of the
// four control words in a blanking of blue; "MONITOR locked" once; "MONITOR clock <ps>" then.

`timescale 1ps/1ps

module dvi_monitor (
    input wire       clock,
    input wire [2:0] lanes              // blue, green, red
);
    localparam RUN = 12;                // control words in a row that make a boundary

    real last, period;
    integer k, errors, file;
    reg [9:0] word [0:2];               // ten bits as they came, of no known boundary
    initial begin
        last = 0; period = 0; errors = 0;
        file = $fopen("screen.bin", "wb");
    end

    // Ten bits in each period of the clock lane.
    reg ten = 0;
    always @(posedge clock) begin
        period = $realtime - last;
        last = $realtime;
    end
    always @(posedge clock) begin
        #1;
        #(period / 20);
        for (k = 0; k < 10; k = k + 1) begin
            word[0][k] = lanes[0];
            word[1][k] = lanes[1];
            word[2][k] = lanes[2];
            if (k != 9) #(period / 10);
        end
        ten = !ten;
    end

    function control(input [9:0] w);
        control = w == 10'b1101010100 || w == 10'b0010101011 || w == 10'b0101010100
            || w == 10'b1010101011;
    endfunction

    // The boundary of each lane's words.
    reg [9:0]  earlier [0:2];
    integer    run [0:29];              // control words in a row at each boundary of each lane
    integer    boundary [0:2];
    reg [2:0]  known = 0;
    reg        locked = 0;
    reg [9:0]  aligned [0:2];
    integer    lane, at;
    initial for (at = 0; at < 30; at = at + 1) run[at] = 0;
    initial for (lane = 0; lane < 3; lane = lane + 1) begin
        boundary[lane] = 0;
        earlier[lane] = 0;
    end

    function [7:0] colour(input [9:0] w);
        reg [7:0] d;
        integer b;
        begin
            d = w[9] ? ~w[7:0] : w[7:0];
            colour[0] = d[0];
            for (b = 1; b < 8; b = b + 1)
                colour[b] = w[8] ? d[b] ^ d[b-1] : !(d[b] ^ d[b-1]);
        end
    endfunction

    reg [2:0] visible;
    reg [1:0] syncs;
    always @(ten) begin
        for (lane = 0; lane < 3; lane = lane + 1) begin
            for (at = 0; at < 10; at = at + 1) begin
                aligned[lane] = {word[lane], earlier[lane]} >> at;
                run[10*lane + at] = control(aligned[lane]) ? run[10*lane + at] + 1 : 0;
                if (!known[lane] && run[10*lane + at] == RUN) begin
                    known[lane] = 1;
                    boundary[lane] = at;
                end
            end
            aligned[lane] = {word[lane], earlier[lane]} >> boundary[lane];
            earlier[lane] = word[lane];
            visible[lane] = !control(aligned[lane]);
        end
        if (&known) begin
            if (!locked) begin
                $display("MONITOR locked %0d %0d %0d", boundary[0], boundary[1], boundary[2]);
                $display("MONITOR clock %0f", period);
            end
            locked = 1;
            if (visible != 0 && visible != 7 && errors < 20) begin
                errors = errors + 1;
                $display("MONITOR-ERROR the lanes disagree: %b", visible);
            end
            syncs = aligned[0] == 10'b1101010100 ? 0 : aligned[0] == 10'b0010101011 ? 1
                : aligned[0] == 10'b0101010100 ? 2 : 3;
            // While pixels are visible the sync signals keep what they were.
            $fwrite(file, "%c%c%c%c", colour(aligned[2]), colour(aligned[1]), colour(aligned[0]),
                    visible[0] ? 8'd1 : {5'd0, syncs, 1'b0});
        end
    end

    task close;
        $fclose(file);
    endtask
endmodule
