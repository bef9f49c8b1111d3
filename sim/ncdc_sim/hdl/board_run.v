// What happens to a board while it runs: buttons, and when it is over.
//
// Plusargs: run_us, how long it runs; press_following_us, press_raw_us, press_again_us, when a button is
// pressed (0: never), for hold_us.

`timescale 1ps/1ps

module board_run (output reg following, raw, again, over);
    integer run_us, following_us, raw_us, again_us, hold_us;
    initial begin
        following = 0; raw = 0; again = 0; over = 0;
        if (!$value$plusargs("run_us=%d", run_us)) run_us = 1000;
        if (!$value$plusargs("press_following_us=%d", following_us)) following_us = 0;
        if (!$value$plusargs("press_raw_us=%d", raw_us)) raw_us = 0;
        if (!$value$plusargs("press_again_us=%d", again_us)) again_us = 0;
        if (!$value$plusargs("hold_us=%d", hold_us)) hold_us = 25000;
        fork
            if (following_us != 0) begin
                #(following_us * 1000000.0) following = 1;
                #(hold_us * 1000000.0) following = 0;
            end
            if (raw_us != 0) begin
                #(raw_us * 1000000.0) raw = 1;
                #(hold_us * 1000000.0) raw = 0;
            end
            if (again_us != 0) begin
                #(again_us * 1000000.0) again = 1;
                #(hold_us * 1000000.0) again = 0;
            end
            #(run_us * 1000000.0) over = 1;
        join
    end
endmodule
