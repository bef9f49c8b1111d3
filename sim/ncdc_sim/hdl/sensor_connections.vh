// Connections of the ports of sensor_meanings.vh to wires of the same names.
            .streaming(streaming), .mirror_columns(mirror_columns), .mirror_rows(mirror_rows),
            .left(left), .top(top), .width(width), .height(height), .skip(skip), .binning(binning),
            .line_clocks(line_clocks), .frame_lines(frame_lines), .exposure(exposure), .gain(gain),
            .pattern(pattern), .colours(colours), .black(black)
