// Frames of an image sensor at its pins, by the meanings that a register file gives.
//
// A line takes `line_clocks`, a frame `frame_lines` lines, of which the first `height` are rows.
// FRAME_VALID is high from LEAD clocks before the first sample of the first row until TAIL clocks
// after the last sample of the last; LINE_VALID is high for `width` clocks of each row. With the
// window's corner at (left, top) of the active pixels, sample (x, y) is the pixel
// (left + x, top + y), or counted from the other end of the window if mirrored.
//
// With `skip` above 1, of each 2 * skip columns the first two are sent, and of rows likewise: sample
// x begins at column left + 2 * skip * floor(x / 2) + x mod 2. With `binning` above 1 it is the mean
// of so many columns, from there on every other one, by as many rows: floor((sum + n / 2) / n), of
// all n at once. A pixel outside of the file counts as 0. Mirrors are not modelled then.
//
// A sample s of the file leaves as
//     min(4095, floor((s * factor + 32768) / 65536) + black)
//     factor = floor(exposure * gain * 256 / nominal)
// without the bits below BITS. Test patterns replace all this; `pattern` is
//     1 one value per colour                   2, 3, 4 ramps along rows, columns, diagonals
//     5 walking ones along each row            6, 7 bars of 16 pixels across and along
//     8 eight colour bars: white, yellow, cyan, green, magenta, red, blue, black
// counted from the first sample.

`timescale 1ns/1ps

module sensor_core #(
    parameter BITS = 12,
    parameter RED_COLUMN = 0,           // parities of the red pixels
    parameter RED_ROW = 0
) (
    input  wire               extclk,
    input  wire               reset_n,
    output wire               pixclk,
    output reg                frame_valid,
    output reg                line_valid,
    output reg  [11:0]        data,
`define NCDC_MEANING input
`include "sensor_meanings.vh"
`undef NCDC_MEANING
);
    localparam LEAD = 4, TAIL = 4;
    localparam MAX_WIDTH = 8192;                // of a frame in the file
    localparam MAX_BINS = 4;
    localparam [11:0] MASK = 12'hFFF << (12 - BITS);

    // Settings of the run.
    reg [8*256-1:0] name;
    reg [8*16-1:0]  fault;
    reg [31:0] fault_frame, fault_row, fault_clocks;
    reg [31:0] file_width, file_height;
    reg [31:0] file_left, file_top;
    reg [63:0] nominal;
    integer    file, frames, got;
    initial begin
        if (!$value$plusargs("sensor_file_width=%d", file_width)) file_width = 0;
        if (!$value$plusargs("sensor_file_height=%d", file_height)) file_height = 0;
        if (!$value$plusargs("sensor_file_left=%d", file_left)) file_left = 0;
        if (!$value$plusargs("sensor_file_top=%d", file_top)) file_top = 0;
        if (!$value$plusargs("sensor_nominal=%d", nominal)) nominal = 0;
        if (!$value$plusargs("sensor_fault=%s", fault)) fault = 0;
        if (!$value$plusargs("sensor_fault_frame=%d", fault_frame)) fault_frame = 0;
        if (!$value$plusargs("sensor_fault_row=%d", fault_row)) fault_row = 0;
        if (!$value$plusargs("sensor_fault_clocks=%d", fault_clocks)) fault_clocks = 20000;
        frames = 0;
        file = 0;
        if ($value$plusargs("sensor_file=%s", name)) begin
            file = $fopen(name, "rb");
            if (file == 0)
                reject("the file cannot be read");
            else if (file_width == 0 || file_height == 0 || file_width > MAX_WIDTH)
                reject("the size of the file's frames is wrong");
            else begin
                got = $fseek(file, 0, 2);
                frames = $ftell(file) / (2 * file_width * file_height);
                if (frames == 0)
                    reject("the file has no whole frame");
            end
        end
    end

    task reject(input [8*48-1:0] reason);
        begin
            $display("SENSOR-ERROR %0s", reason);
            $finish;
        end
    endtask

    // Settings of the frame.
    reg               run, flip_columns, flip_rows;
    reg signed [17:0] first_column, first_row;
    reg [15:0]        columns, rows;
    reg [3:0]         step;             // active pixels per sample
    reg [2:0]         together;         // of which a sample is the mean, in each direction
    reg [31:0]        clocks, lines;
    reg [63:0]        factor;
    reg [3:0]         shows;
    reg [47:0]        colour;
    reg [11:0]        dark;

    reg [31:0] number;                  // of the frame since the start
    reg [31:0] line, clock;             // where the outputs are
    reg [31:0] stopped;                 // clocks for which the pixel clock still stands
    reg        stood;                   // it has stopped in this run
    reg [7:0]  row [0:2*MAX_WIDTH*MAX_BINS-1];  // bytes of the file's rows
    reg [MAX_BINS-1:0] row_there;       // the file has the row
    reg        faulty, reached;         // this is the frame of the fault; the row, too
    reg [31:0] x;
    reg signed [17:0] u, v;             // column and row in the active pixels: of the first pixel
    reg signed [17:0] at_u, at_v;       // and of one of the mean
    reg [63:0] sample;
    integer    i, j;

    assign pixclk = extclk && stopped == 0;

    task begin_frame;
        begin
            flip_columns = mirror_columns;
            flip_rows = mirror_rows;
            first_column = {left[16], left};
            first_row = {top[16], top};
            columns = width;
            rows = height;
            step = skip;
            together = binning;
            if (step != 1 && (flip_columns || flip_rows))
                $display("SENSOR-ERROR mirrors are not modelled with skipping");
            clocks = line_clocks < width + LEAD + TAIL ? width + LEAD + TAIL : line_clocks;
            lines = frame_lines > height ? frame_lines : height + 1;
            factor = nominal == 0 ? 65536 : {16'd0, exposure} * {32'd0, gain} * 256 / nominal;
            shows = pattern;
            colour = colours;
            dark = black;
            $display("SENSOR frame %0d", number);
        end
    endtask

    // Active pixels from the first one of a window to that of a sample.
    function signed [17:0] away(input [15:0] number);
        away = step == 1 ? number : 2 * step * number[15:1] + number[0];
    endfunction

    // The rows of the file that belong to this row of the frame.
    task read_row;
        begin
            v = first_row + away(flip_rows ? rows - 16'd1 - line[15:0] : line[15:0]);
            for (j = 0; j < together; j = j + 1) begin
                at_v = v + 2 * j;
                row_there[j] = frames != 0 && at_v >= $signed(file_top[17:0])
                    && at_v < $signed(file_top[17:0] + file_height[17:0]);
                if (row_there[j]) begin
                    got = $fseek(file, 2 * file_width
                        * ((number % frames) * file_height + at_v - file_top), 0);
                    got = $fread(row, file, 2 * MAX_WIDTH * j, 2 * file_width);
                end
            end
        end
    endtask

    task find_sample;
        begin
            u = first_column + away(flip_columns ? columns - 16'd1 - x[15:0] : x[15:0]);
            sample = 0;
            for (j = 0; j < together; j = j + 1)
                for (i = 0; i < together; i = i + 1) begin
                    at_u = u + 2 * i;
                    if (row_there[j] && at_u >= $signed(file_left[17:0])
                        && at_u < $signed(file_left[17:0] + file_width[17:0]))
                        sample = sample
                            + {52'd0, row[2 * (MAX_WIDTH * j + at_u - file_left) + 1][3:0],
                               row[2 * (MAX_WIDTH * j + at_u - file_left)]};
                end
            sample = (sample + together * together / 2) / (together * together);
            sample = ((sample * factor + 32768) >> 16) + {52'd0, dark};
            if (sample > 4095)
                sample = 4095;
            if (shows != 0)
                find_pattern;
            data <= sample[11:0] & MASK;
        end
    endtask

    reg       in_red_column, in_red_row;
    reg [2:0] bar;
    task find_pattern;
        begin
            in_red_column = u[0] == RED_COLUMN;
            in_red_row = v[0] == RED_ROW;
            bar = x * 8 / columns;
            case (shows)
                1: sample = {52'd0, in_red_row ? (in_red_column ? colour[35:24] : colour[47:36])
                                               : (in_red_column ? colour[11:0] : colour[23:12])};
                2: sample = x * 4095 / (columns - 1);
                3: sample = line * 4095 / (rows - 1);
                4: sample = (x + line) * 4095 / (columns + rows - 2);
                5: sample = x % 16 < 12 ? 1 << (x % 16) : 0;
                6: sample = line[4] ? 4095 : 0;
                7: sample = x[4] ? 4095 : 0;
                // Red is missing in bars 2, 3, 6, 7, green in 4 to 7, blue in the odd ones.
                default: sample = (in_red_row ? (in_red_column ? !bar[1] : !bar[2])
                                              : (in_red_column ? !bar[2] : !bar[0])) ? 4095 : 0;
            endcase
        end
    endtask

    always @(negedge extclk) begin
        if (!reset_n || !streaming) begin
            run <= 0;
            frame_valid <= 0;
            line_valid <= 0;
            stopped <= 0;
            if (!reset_n)
                stood <= 0;
        end else if (stopped != 0)
            stopped <= stopped - 1;
        else begin
            run <= 1;
            if (!run) begin
                number = 0;
                line = 0;
                clock = 0;
            end else begin
                clock = clock + 1;
                if (clock == clocks) begin
                    clock = 0;
                    line = line + 1;
                end
                if (line == lines) begin
                    line = 0;
                    number = number + 1;
                end
            end
            if (clock == 0 && line == 0)
                begin_frame;
            if (clock == 0 && line < {16'd0, rows})
                read_row;
            x = clock - LEAD;
            faulty = fault != 0 && number == fault_frame;
            reached = faulty && line == fault_row;
            frame_valid <= (line + 1 < {16'd0, rows}
                            || (line + 1 == {16'd0, rows} && clock < LEAD + columns + TAIL))
                && !(faulty && fault == "cut_frame" && line >= fault_row);
            line_valid <= line < {16'd0, rows} && clock >= LEAD
                && x < columns + (reached && fault == "long_line")
                       - (reached && fault == "short_line")
                && !(reached && fault == "glitch" && x == {16'd0, columns / 16'd2})
                && !(faulty && fault == "cut_frame" && line >= fault_row);
            if (reached && fault == "clock_stop" && x == {16'd0, columns / 16'd2} && !stood) begin
                stopped <= fault_clocks;
                stood <= 1;
            end
            if (line < {16'd0, rows} && clock >= LEAD && x < {16'd0, columns})
                find_sample;
            else
                data <= 12'h5A5 & MASK;
        end
    end
endmodule
