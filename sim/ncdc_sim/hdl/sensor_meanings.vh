// What a sensor's registers mean: ports of the register files, which give it, and of sensor_core.
    `NCDC_MEANING wire               streaming,
    `NCDC_MEANING wire               mirror_columns,
    `NCDC_MEANING wire               mirror_rows,
    `NCDC_MEANING wire signed [16:0] left,
    `NCDC_MEANING wire signed [16:0] top,
    `NCDC_MEANING wire [15:0]        width,
    `NCDC_MEANING wire [15:0]        height,
    `NCDC_MEANING wire [3:0]         skip,             // 1 or more
    `NCDC_MEANING wire [2:0]         binning,          // 1 to MAX_BINS
    `NCDC_MEANING wire [31:0]        line_clocks,
    `NCDC_MEANING wire [31:0]        frame_lines,
    `NCDC_MEANING wire [47:0]        exposure,         // pixel clocks
    `NCDC_MEANING wire [31:0]        gain,             // 256 is 1
    `NCDC_MEANING wire [3:0]         pattern,          // as of sensor_core
    `NCDC_MEANING wire [47:0]        colours,          // Gr, R, B, Gb
    `NCDC_MEANING wire [11:0]        black
