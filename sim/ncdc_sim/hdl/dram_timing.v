// Timing of a dynamic memory whose controller keeps rows open: when an access gets its
// column command, and when its data is there. The rules are those of `DramMemory` in
// model/ncdc_model/planner/memory_timing.py.
//
// No ports: `avalon_memory` calls `restart`, `step` and `schedule`. Times are numbers of memory
// clocks (MC). `step` goes on to the corrector's next clock edge; `schedule` plans the commands of
// one access at once, after those planned before; `ready` says that the controller would look at
// one more access.
//
// Every planned command is logged under its MC, and read back when that MC has come by a checker
// that knows the rules of the memory and nothing of the planning. A violation prints
// "AVALON-ERROR memory <rule> <time>" and counts in `errors`.

`timescale 1ns/1ps

module dram_timing;
    localparam MAX_BANKS = 16;
    localparam MAX_LOOK_AHEAD = 16;
    localparam LOG = 4096;              // MC; more than a command is planned in advance

    localparam NONE = 0, PRECHARGE = 1, PRECHARGE_ALL = 2, ACTIVATE = 3, READ = 4, WRITE = 5,
        REFRESH = 6;

    // Settings; names as in `DramMemory`, sizes of powers of two as their exponents.
    reg [31:0] ratio_mul, ratio_div, bank_bits, column_bits, access_bits, word_bits, word_clocks;
    reg [31:0] cas_latency, rcd, rp, ras, rc, rrd, faw, read_to_write, write_to_read,
        write_to_precharge, refresh, refresh_interval, look_ahead;

    initial begin
        if (!$value$plusargs("ratio_mul=%d", ratio_mul)) ratio_mul = 1;
        if (!$value$plusargs("ratio_div=%d", ratio_div)) ratio_div = 1;
        if (!$value$plusargs("bank_bits=%d", bank_bits)) bank_bits = 2;
        if (!$value$plusargs("column_bits=%d", column_bits)) column_bits = 12;
        if (!$value$plusargs("access_bits=%d", access_bits)) access_bits = 2;
        if (!$value$plusargs("word_bits=%d", word_bits)) word_bits = 2;
        if (!$value$plusargs("word_clocks=%d", word_clocks)) word_clocks = 1;
        if (!$value$plusargs("cas_latency=%d", cas_latency)) cas_latency = 1;
        if (!$value$plusargs("rcd=%d", rcd)) rcd = 1;
        if (!$value$plusargs("rp=%d", rp)) rp = 1;
        if (!$value$plusargs("ras=%d", ras)) ras = 1;
        if (!$value$plusargs("rc=%d", rc)) rc = 1;
        if (!$value$plusargs("rrd=%d", rrd)) rrd = 1;
        if (!$value$plusargs("faw=%d", faw)) faw = 0;
        if (!$value$plusargs("read_to_write=%d", read_to_write)) read_to_write = 0;
        if (!$value$plusargs("write_to_read=%d", write_to_read)) write_to_read = 0;
        if (!$value$plusargs("write_to_precharge=%d", write_to_precharge)) write_to_precharge = 0;
        if (!$value$plusargs("refresh=%d", refresh)) refresh = 1;
        if (!$value$plusargs("refresh_interval=%d", refresh_interval)) refresh_interval = 1000;
        if (!$value$plusargs("look_ahead=%d", look_ahead)) look_ahead = 1;
    end

    reg [31:0] now, next;               // MC of this clock edge and of the next one
    reg [31:0] fraction;                // of MC, in ratio_div
    reg [31:0] errors, refreshes, activates;

    // Planning.
    reg [MAX_BANKS-1:0] open;
    reg [31:0] row_of         [0:MAX_BANKS-1];
    reg [31:0] precharge_from [0:MAX_BANKS-1];
    reg [31:0] activate_from  [0:MAX_BANKS-1];
    reg [31:0] column_from    [0:MAX_BANKS-1];
    reg [31:0] any_activate_from, read_from, write_from, last_command, refresh_due;
    reg [31:0] four_from [0:3];         // the fourth last activate + faw
    reg [1:0]  four;
    reg [31:0] column_at [0:MAX_LOOK_AHEAD-1];
    reg [31:0] column;                  // of column_at: the access look_ahead positions before
    reg        ready;

    reg [71:0] log [0:LOG-1];           // MC, command, bank, row, MC of data
    integer i;

    task restart;
        begin
            now = 1000000;              // no interval reaches back before it
            next = now;
            fraction = 0;
            errors = 0;
            refreshes = 0;
            activates = 0;
            open = 0;
            any_activate_from = 0;
            read_from = 0;
            write_from = 0;
            last_command = 0;
            refresh_due = now + refresh_interval;
            four = 0;
            column = 0;
            ready = 0;
            for (i = 0; i < MAX_BANKS; i = i + 1) begin
                row_of[i] = 0;
                precharge_from[i] = 0;
                activate_from[i] = 0;
                column_from[i] = 0;
                activated[i] = 0;
                precharged[i] = 0;
                bank_read[i] = 0;
                bank_written[i] = 0;
                open_row[i] = 0;
            end
            for (i = 0; i < 4; i = i + 1) begin
                four_from[i] = 0;
                last_activates[i] = 0;
            end
            for (i = 0; i < MAX_LOOK_AHEAD; i = i + 1)
                column_at[i] = 0;
            for (i = 0; i < LOG; i = i + 1)
                log[i] = 0;
            is_open = 0;
            last_read = 0;
            last_write = 0;
            refreshed = now - refresh;
            advance;
        end
    endtask

    // To the next clock edge of the corrector: check the commands of the time gone by, schedule a
    // refresh that is due.
    task step;
        begin
            for (i = now + 1; i <= next; i = i + 1)
                if (log[i % LOG][71:40] == i)
                    check(i, log[i % LOG][39:37], log[i % LOG][36:33], log[i % LOG][32:8],
                          log[i % LOG][7:0]);
            now = next;
            advance;
            if (now >= refresh_due) begin
                schedule_refresh;
                refresh_due = refresh_due + refresh_interval;
            end
            ready = column_at[column] <= now;
        end
    endtask

    task advance;
        begin
            fraction = fraction + ratio_mul;
            while (fraction >= ratio_div) begin
                fraction = fraction - ratio_div;
                next = next + 1;
            end
        end
    endtask

    // Words of the memory that hold the bytes from..upto.
    function [31:0] words(input [31:0] from, input [31:0] upto);
        words = ((upto - 1) >> word_bits) - (from >> word_bits) + 1;
    endfunction

    function [31:0] later(input [31:0] a, input [31:0] b);
        later = a > b ? a : b;
    endfunction

    reg [31:0] at;                      // MC of the command being scheduled

    // Put a command on the first free MC from `at` on.
    task issue(input [2:0] command, input [3:0] bank, input [24:0] row, input [7:0] length);
        begin
            while (log[at % LOG][71:40] == at)
                at = at + 1;
            log[at % LOG] = {at, command, bank, row, length};
            last_command = later(last_command, at);
        end
    endtask

    // Commands of the access to the bytes from..upto (which is the first one beyond); `start` is
    // the MC in which a read's data starts.
    task schedule(input write, input [31:0] from, input [31:0] upto, output [31:0] start);
        reg [3:0]  bank;
        reg [24:0] row;
        reg [7:0]  length;
        begin
            bank = (from >> column_bits) & ((1 << bank_bits) - 1);
            row = from >> (column_bits + bank_bits);
            length = words(from, upto) * word_clocks;
            if (!open[bank] || row_of[bank] != row) begin
                if (open[bank]) begin
                    at = later(now + 1, precharge_from[bank]);
                    issue(PRECHARGE, bank, 0, 0);
                    activate_from[bank] = later(activate_from[bank], at + rp);
                end
                at = later(later(now + 1, activate_from[bank]),
                           later(any_activate_from, four_from[four]));
                issue(ACTIVATE, bank, row, 0);
                activates = activates + 1;
                open[bank] = 1;
                row_of[bank] = row;
                any_activate_from = at + rrd;
                four_from[four] = at + faw;
                four = four + 1;
                activate_from[bank] = at + rc;
                precharge_from[bank] = at + ras;
                column_from[bank] = at + rcd;
            end
            at = later(later(now + 1, column_from[bank]), write ? write_from : read_from);
            issue(write ? WRITE : READ, bank, row, length);
            read_from = at + length + (write ? write_to_read : 0);
            write_from = at + length + (write ? 0 : read_to_write);
            precharge_from[bank] = later(precharge_from[bank],
                                         at + length + (write ? write_to_precharge : 0));
            column_at[column] = at;
            column = column + 1 == look_ahead ? 0 : column + 1;
            ready = column_at[column] <= now;
            start = at + cas_latency;
        end
    endtask

    task schedule_refresh;
        begin
            at = later(now, last_command) + 1;
            if (open != 0) begin
                for (i = 0; i < MAX_BANKS; i = i + 1)
                    if (open[i])
                        at = later(at, precharge_from[i]);
                issue(PRECHARGE_ALL, 0, 0, 0);
                at = at + rp;
            end                         // else all were closed by the refresh before
            issue(REFRESH, 0, 0, 0);
            refreshes = refreshes + 1;
            open = 0;
            for (i = 0; i < MAX_BANKS; i = i + 1)
                activate_from[i] = at + refresh;
        end
    endtask

    // The memory's own view of what reaches it, in order of time.
    reg [MAX_BANKS-1:0] is_open;
    reg [31:0] open_row     [0:MAX_BANKS-1];
    reg [31:0] activated    [0:MAX_BANKS-1];
    reg [31:0] precharged   [0:MAX_BANKS-1];
    reg [31:0] bank_read    [0:MAX_BANKS-1];    // ends of the data of its last column commands
    reg [31:0] bank_written [0:MAX_BANKS-1];
    reg [31:0] last_activates [0:3];    // newest first
    reg [31:0] last_read, last_write, refreshed;
    integer b;

    task violation(input [8*16-1:0] rule);
        begin
            if (errors < 20)
                $display("AVALON-ERROR memory %0s %0t", rule, $time);
            errors = errors + 1;
        end
    endtask

    task check_precharge(input [31:0] t, input [3:0] bank);
        begin
            if (t - activated[bank] < ras) violation("ras");
            if (t < bank_read[bank]) violation("read-precharge");
            if (t < bank_written[bank] + write_to_precharge) violation("write-precharge");
            is_open[bank] = 0;
            precharged[bank] = t;
        end
    endtask

    task check(input [31:0] t, input [2:0] command, input [3:0] bank, input [24:0] row,
               input [7:0] length);
        begin
            if (t - refreshed < refresh) violation("refresh");
            case (command)
                PRECHARGE:
                    check_precharge(t, bank);
                PRECHARGE_ALL:
                    for (b = 0; b < MAX_BANKS; b = b + 1)
                        if (is_open[b])
                            check_precharge(t, b);
                ACTIVATE: begin
                    if (is_open[bank]) violation("open");
                    if (t - precharged[bank] < rp) violation("rp");
                    if (t - activated[bank] < rc) violation("rc");
                    if (t - last_activates[0] < rrd) violation("rrd");
                    if (t - last_activates[3] < faw) violation("faw");
                    for (b = 3; b > 0; b = b - 1)
                        last_activates[b] = last_activates[b-1];
                    last_activates[0] = t;
                    activated[bank] = t;
                    is_open[bank] = 1;
                    open_row[bank] = row;
                end
                READ, WRITE: begin
                    if (!is_open[bank] || open_row[bank] != row) violation("row");
                    if (t - activated[bank] < rcd) violation("rcd");
                    if (t < last_read + (command == READ ? 0 : read_to_write)
                            || t < last_write + (command == READ ? write_to_read : 0))
                        violation("column");
                    if (command == READ) begin
                        last_read = t + length;
                        bank_read[bank] = t + length;
                    end else begin
                        last_write = t + length;
                        bank_written[bank] = t + length;
                    end
                end
                REFRESH: begin
                    if (is_open != 0) violation("refresh-open");
                    for (b = 0; b < MAX_BANKS; b = b + 1)
                        if (t - precharged[b] < rp) violation("rp");
                    if (t - refreshed > 2 * refresh_interval) violation("refresh-late");
                    refreshed = t;
                end
                default: violation("command");
            endcase
        end
    endtask
endmodule
