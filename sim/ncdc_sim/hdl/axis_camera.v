// A camera that sends AXI4-Stream video by itself, COUNT samples a beat, the first one lowest: what a
// vendor's receiver makes of a sensor's lanes. TUSER is with the first beat of a frame, TLAST with
// the last beat of each row.
//
// A line takes `camera_line_clocks`, a frame `camera_frame_lines` lines, of which the first ones are
// the rows of the file. The camera cannot wait: a beat that is not taken in its clock prints
// "SENSOR-ERROR <reason>" and ends the run. Each frame prints "SENSOR frame <number>".
//
// Plusargs:
//   sensor_file=<name>       samples of 12 bits in 16, the low byte first, row by row, frame by frame
//   sensor_file_width=, sensor_file_height=      of a frame; the width is a multiple of COUNT
//   camera_line_clocks=, camera_frame_lines=
// The file begins anew when it has ended.

`timescale 1ns/1ps

module axis_camera #(
    parameter COUNT = 1, BITS = 12
) (
    input  wire clk,
    input  wire reset_n,                // frames begin when it is released
    output reg  tvalid,
    input  wire tready,
    output reg  [(COUNT*BITS+7)/8*8-1:0] tdata,
    output reg  tuser, tlast
);
    localparam MAX_WIDTH = 8192;

    reg [8*256-1:0] name;
    reg [31:0] width, height, line_clocks, frame_lines;
    integer    file, frames, got;
    initial begin
        if (!$value$plusargs("sensor_file_width=%d", width)) width = 0;
        if (!$value$plusargs("sensor_file_height=%d", height)) height = 0;
        if (!$value$plusargs("camera_line_clocks=%d", line_clocks)) line_clocks = 0;
        if (!$value$plusargs("camera_frame_lines=%d", frame_lines)) frame_lines = 0;
        frames = 0;
        file = 0;
        if ($value$plusargs("sensor_file=%s", name))
            file = $fopen(name, "rb");
        if (file == 0)
            reject("the file cannot be read");
        else if (width == 0 || height == 0 || width > MAX_WIDTH || width % COUNT != 0
                 || line_clocks < width / COUNT || frame_lines < height)
            reject("the size of the frames is wrong");
        else begin
            got = $fseek(file, 0, 2);
            frames = $ftell(file) / (2 * width * height);
            if (frames == 0)
                reject("the file has no whole frame");
        end
        tvalid = 0;
    end

    task reject(input [8*48-1:0] reason);
        begin
            $display("SENSOR-ERROR %0s", reason);
            $finish;
        end
    endtask

    reg [31:0] number, line, clock;     // of the beat that is next
    reg [7:0]  row [0:2*MAX_WIDTH-1];   // bytes of the file's row
    reg [11:0] sample;
    integer    k;

    task begin_row;
        begin
            if (line == 0) begin
                $display("SENSOR frame %0d", number);
                got = $fseek(file, 2 * width * height * (number % frames), 0);
            end
            got = $fread(row, file, 0, 2 * width);
        end
    endtask

    always @(posedge clk) begin
        if (reset_n && tvalid && !tready)
            reject("a beat was not taken");
        tvalid <= 0;
        if (!reset_n) begin
            number = 0;
            line = 0;
            clock = 0;
        end else begin
            if (clock == 0 && line < height)
                begin_row;
            if (line < height && clock < width / COUNT) begin
                for (k = 0; k < COUNT; k = k + 1) begin
                    got = 2 * (COUNT * clock + k);
                    sample = {row[got + 1][3:0], row[got]};
                    tdata[BITS*k +: BITS] <= BITS > 12 ? sample << (BITS - 12)
                                                       : sample >> (12 - BITS);
                end
                tvalid <= 1;
                tuser <= line == 0 && clock == 0;
                tlast <= clock + 1 == width / COUNT;
            end
            clock = clock + 1;
            if (clock == line_clocks) begin
                clock = 0;
                line = line + 1;
            end
            if (line == frame_lines) begin
                line = 0;
                number = number + 1;
            end
        end
    end
endmodule
