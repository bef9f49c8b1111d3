// An SDR SDRAM chip, or several side by side, written from the data sheets: four banks, mode
// register, bursts of 1, 2, 4 or 8 columns, CAS latency 2 or 3, auto precharge, DQM, AUTO REFRESH;
// and a checker of what the data sheets ask of whoever drives it.
//
// DQ comes in three: `dq_i` and `dq_oe`, what the controller drives and whether it does; `dq_o` and
// `dq_drives` of the chip. All is sampled at the rising edge. With CAS latency n, data are there to
// be sampled n edges after the READ's.
//
// Times are in ps, and are compared with clocks times PERIOD, as the data sheet's are: nothing is
// rounded here. A command at one edge and one at the next are a period apart. Plusargs of the
// parameters' names replace them by other times, for tests.
//
// Each violation counts in `violations`; the first 20 print "SDRAM-VIOLATION <rule> <clock>":
//   tPAUSE       no command within the pause after power-up
//   init         before the first ACTIVE: all banks closed, REFRESHES refreshes, a mode set
//   mode         bursts of 1 to 8, sequential, and a CAS latency that the period allows
//   tMRD tRFC    no command so soon after LOAD MODE REGISTER, AUTO REFRESH
//   tRCD         READ or WRITE after its bank's ACTIVE
//   tRP          ACTIVE, AUTO REFRESH or LOAD MODE REGISTER after a PRECHARGE
//   tRC tRRD     ACTIVE after its bank's ACTIVE, another bank's
//   tRAS-min     PRECHARGE after its bank's ACTIVE
//   tRAS-max     a row is open for too long
//   tWR          PRECHARGE after the last data of its bank's WRITE
//   closed open  READ or WRITE of a bank without an open row; ACTIVE of one that has one; AUTO
//                REFRESH or LOAD MODE REGISTER with an open row
//   cut          PRECHARGE of a bank whose READ has data to come that it would cut off
//   refresh-gap  two refreshes are further than REFRESH_GAP apart
//   retention    REFRESH_CYCLES refreshes, which reach every row, took longer than RETENTION
//   contention   controller and chip drive DQ in the same clock, or with less than TURNAROUND
//                clocks between the chip and the controller
//   no-data      DQ is not driven when data are written
//   row          with COPIES: ACTIVE of a row whose bits above the stored ones are no copies of the
//                highest of these, other than the row after the last one without that bit
//   unsupported  a command that this model has not, or CKE is low
//   unknown      X or Z on a control pin (four states)
//
// Of a row's number only the lowest STORED bits count for what is stored. `refresh_most` is the
// longest time between two refreshes so far, in clocks; `beats_read` and `beats_written` count the
// clocks with data.

`timescale 1ns/1ps

module sdram_chip #(
    parameter DATA = 16,
    parameter ROW = 13,
    parameter COLUMN = 9,
    parameter STORED = ROW,
    parameter COPIES = 0,
    parameter PERIOD = 10000,
    parameter RCD = 20000,
    parameter RP = 20000,
    parameter RAS = 42000,
    parameter RAS_MAX = 100000000,
    parameter RC = 60000,
    parameter RFC = 60000,
    parameter WR = 14000,
    parameter WR_CLOCKS = 1,
    parameter RRD = 14000,
    parameter MRD = 14000,
    parameter MRD_CLOCKS = 2,
    parameter CAS2 = 10000,             // shortest period with CAS latency 2, and 3
    parameter CAS3 = 7000,
    parameter PAUSE = 200000000,
    parameter REFRESHES = 2,
    parameter REFRESH_GAP = 7812500,
    parameter REFRESH_CYCLES = 8192,
    parameter [63:0] RETENTION = 64'd64000000000,
    parameter TURNAROUND = 1,
    parameter ADDRESS = ROW > 11 ? ROW : 11
) (
    input  wire               clk,
    input  wire               controller_rst,   // the time without a refresh begins anew
    input  wire               cke,
    input  wire               cs_n,
    input  wire               ras_n,
    input  wire               cas_n,
    input  wire               we_n,
    input  wire [1:0]         ba,
    input  wire [ADDRESS-1:0] a,
    input  wire [DATA/8-1:0]  dqm,
    input  wire [DATA-1:0]    dq_i,
    input  wire               dq_oe,
    output reg  [DATA-1:0]    dq_o,
    output reg                dq_drives,
    output reg  [31:0]        violations,
    output reg  [31:0]        refreshes,
    output reg  [31:0]        refresh_most,
    output reg  [31:0]        beats_read,
    output reg  [31:0]        beats_written
);
    localparam BYTES = DATA / 8;

    reg [DATA-1:0] store [0:(4 << (STORED + COLUMN)) - 1];

    reg [63:0] now;
    reg        moded;                   // a mode has been set
    reg        closed_all;              // all banks have been closed once
    reg [2:0]  length_code;
    reg [1:0]  latency;

    reg [3:0]      opened;
    reg [ROW-1:0]  row [0:3];
    reg [63:0]     activated [0:3];     // when, in clocks
    reg [63:0]     precharged [0:3];
    reg [63:0]     written [0:3];       // the last data
    reg [3:0]      ever_activated, ever_precharged, ever_written;
    reg [3:0]      too_long;            // has been reported
    reg [3:0]      closing;             // auto precharge comes
    reg [63:0]     closes [0:3];        // and when
    reg [63:0]     last_refresh, last_mode;
    reg            ever_refreshed, ever_mode, gap_counts;
    reg [63:0]     times [0:REFRESH_CYCLES-1];     // of the last refreshes

    // The burst under way.
    reg            bursting, burst_write;
    reg [1:0]      burst_bank;
    reg [COLUMN-1:0] burst_column, burst_first;
    reg [3:0]      burst_left;
    reg [DATA-1:0] pipe, pipe3;         // read data, a clock before DQ, and two if the latency is 3
    reg            pipe_valid, pipe3_valid;
    reg [BYTES-1:0] mask;               // DQM of the clock before
    reg [7:0]      since_drive;         // clocks since the chip has driven

    reg [DATA-1:0] fresh;               // read in this clock
    reg            fresh_valid;
    reg [DATA-1:0] shown;
    reg            shown_valid;
    reg [31:0]     index;
    reg            precharge_now;
    integer        b, k;

    // The times in use: the parameters, or the plusargs of the same name.
    reg [63:0] t_rcd, t_rp, t_ras, t_ras_max, t_rc, t_rfc, t_wr;
    reg [63:0] t_rrd, t_mrd, t_pause, t_refresh_gap, t_cas3, t_retention;

    wire [2:0] command = {ras_n, cas_n, we_n};
    wire       any = !cs_n && command != 3'b111;

    task violation(input [8*12-1:0] rule);
        begin
            if (violations < 20)
                $display("SDRAM-VIOLATION %0s %0d", rule, now);
            violations = violations + 1;
        end
    endtask

    function early(input ever, input [63:0] since, input [63:0] time_ps);
        early = ever && (now - since) * PERIOD < time_ps;
    endfunction

    // Where a column of the burst is.
    function [31:0] index_of(input [1:0] bank, input [COLUMN-1:0] column);
        index_of = ((({30'd0, bank} << STORED)
                     | ({{(32-ROW){1'b0}}, row[bank]} & ((1 << STORED) - 1)))
                    << COLUMN) | {{(32-COLUMN){1'b0}}, column};
    endfunction

    // Close a bank for a PRECHARGE, or by itself.
    task close(input integer bank, input by_itself);
        begin
            if (opened[bank]) begin
                if (early(ever_activated[bank], activated[bank], t_ras)) violation("tRAS-min");
                if (early(ever_written[bank], written[bank], t_wr)
                        || (ever_written[bank] && now - written[bank] < WR_CLOCKS)
                        || (bursting && burst_write && burst_bank == bank[1:0] && burst_left != 0))
                    violation("tWR");
                if (bursting && !burst_write && burst_bank == bank[1:0] && burst_left != 0
                        && !by_itself)
                    violation("cut");
                opened[bank] = 0;
                precharged[bank] = now;
                ever_precharged[bank] = 1;
            end else if (!by_itself && !ever_precharged[bank]) begin
                precharged[bank] = now;
                ever_precharged[bank] = 1;
            end
            closing[bank] = 0;
            too_long[bank] = 0;
        end
    endtask

    task closed_for(input integer unused);      // REFRESH and MODE
        begin
            if (opened != 0) violation("open");
            for (b = 0; b < 4; b = b + 1)
                if (early(ever_precharged[b], precharged[b], t_rp)) violation("tRP");
        end
    endtask

    initial begin
        if (!$value$plusargs("RCD=%d", t_rcd)) t_rcd = RCD;
        if (!$value$plusargs("RP=%d", t_rp)) t_rp = RP;
        if (!$value$plusargs("RAS=%d", t_ras)) t_ras = RAS;
        if (!$value$plusargs("RAS_MAX=%d", t_ras_max)) t_ras_max = RAS_MAX;
        if (!$value$plusargs("RC=%d", t_rc)) t_rc = RC;
        if (!$value$plusargs("RFC=%d", t_rfc)) t_rfc = RFC;
        if (!$value$plusargs("WR=%d", t_wr)) t_wr = WR;
        if (!$value$plusargs("RRD=%d", t_rrd)) t_rrd = RRD;
        if (!$value$plusargs("MRD=%d", t_mrd)) t_mrd = MRD;
        if (!$value$plusargs("PAUSE=%d", t_pause)) t_pause = PAUSE;
        if (!$value$plusargs("REFRESH_GAP=%d", t_refresh_gap)) t_refresh_gap = REFRESH_GAP;
        if (!$value$plusargs("CAS3=%d", t_cas3)) t_cas3 = CAS3;
        if (!$value$plusargs("RETENTION=%d", t_retention)) t_retention = RETENTION;
        now = 0; violations = 0; refreshes = 0; refresh_most = 0; beats_read = 0; beats_written = 0;
        moded = 0; closed_all = 0; length_code = 0; latency = 3;
        opened = 0; ever_activated = 0; ever_precharged = 0; ever_written = 0; too_long = 0;
        closing = 0; ever_refreshed = 0; ever_mode = 0; gap_counts = 0; last_refresh = 0;
        last_mode = 0;
        bursting = 0; burst_write = 0; burst_left = 0; burst_bank = 0;
        pipe_valid = 0; pipe3_valid = 0; dq_drives = 0; dq_o = 0; mask = 0; since_drive = 255;
        for (k = 0; k < 4; k = k + 1) begin
            activated[k] = 0; precharged[k] = 0; written[k] = 0; closes[k] = 0; row[k] = 0;
        end
    end

    always @(posedge clk) begin
        if (^{cke, cs_n, ras_n, cas_n, we_n, dq_oe} === 1'bx
                || (any && ^{ba, dqm} === 1'bx))
            violation("unknown");
        if (any && !cke) violation("unsupported");

        // What has been on DQ until this edge.
        if (dq_oe && (dq_drives || {24'd0, since_drive} + 1 <= TURNAROUND)) violation("contention");
        since_drive = dq_drives ? 0 : since_drive == 255 ? 255 : since_drive + 1;

        for (b = 0; b < 4; b = b + 1) begin
            if (closing[b] && now >= closes[b]) close(b, 1);
            if (opened[b] && (now - activated[b]) * PERIOD > t_ras_max && !too_long[b]) begin
                violation("tRAS-max");
                too_long[b] = 1;
            end
        end

        if (any) begin
            if (now * PERIOD < t_pause) violation("tPAUSE");
            if (early(ever_refreshed, last_refresh, t_rfc)) violation("tRFC");
            if (early(ever_mode, last_mode, t_mrd) || (ever_mode && now - last_mode < MRD_CLOCKS))
                violation("tMRD");
            case (command)
                3'b011: begin                                                   // ACTIVE
                    if (!moded || !closed_all || refreshes < REFRESHES) violation("init");
                    if (opened[ba]) violation("open");
                    if (COPIES != 0 && a[ROW-1:STORED-1] != {(ROW-STORED+1){a[STORED-1]}}
                            && a[ROW-1:0] != 1 << (STORED - 1))
                        violation("row");
                    if (early(ever_precharged[ba], precharged[ba], t_rp)) violation("tRP");
                    if (early(ever_activated[ba], activated[ba], t_rc)) violation("tRC");
                    for (b = 0; b < 4; b = b + 1)
                        if (b[1:0] != ba && early(ever_activated[b], activated[b], t_rrd))
                            violation("tRRD");
                    opened[ba] = 1;
                    row[ba] = a[ROW-1:0];
                    activated[ba] = now;
                    ever_activated[ba] = 1;
                    ever_written[ba] = 0;
                end
                3'b101, 3'b100: begin                                           // READ, WRITE
                    if (!opened[ba] || closing[ba]) violation("closed");
                    if (early(ever_activated[ba], activated[ba], t_rcd)) violation("tRCD");
                    bursting = 1;
                    burst_write = !we_n;
                    burst_bank = ba;
                    burst_first = a[COLUMN-1:0];
                    burst_column = a[COLUMN-1:0];
                    burst_left = 4'd1 << length_code;
                    if (a[10]) begin
                        closing[ba] = 1;
                        closes[ba] = now + (64'd1 << length_code);
                        if (!we_n)
                            closes[ba] = now + (64'd1 << length_code) - 1
                                         + (t_wr + PERIOD - 1) / PERIOD;
                        if ((closes[ba] - activated[ba]) * PERIOD < t_ras)
                            closes[ba] = activated[ba] + (t_ras + PERIOD - 1) / PERIOD;
                    end
                end
                3'b010: begin                                                   // PRECHARGE
                    for (b = 0; b < 4; b = b + 1)
                        if (a[10] || b[1:0] == ba) close(b, 0);
                    if (a[10]) closed_all = 1;
                end
                3'b001: begin                                                   // AUTO REFRESH
                    closed_for(0);
                    if (gap_counts && now - last_refresh > {32'd0, refresh_most})
                        refresh_most = now[31:0] - last_refresh[31:0];
                    if (gap_counts && (now - last_refresh) * PERIOD > t_refresh_gap)
                        violation("refresh-gap");
                    gap_counts = 1;
                    if (refreshes >= REFRESH_CYCLES
                            && (now - times[refreshes % REFRESH_CYCLES]) * PERIOD > t_retention)
                        violation("retention");
                    times[refreshes % REFRESH_CYCLES] = now;
                    refreshes = refreshes + 1;
                    last_refresh = now;
                    ever_refreshed = 1;
                end
                3'b000: begin                                                   // LOAD MODE
                    closed_for(0);
                    if (a[2:0] > 3 || a[3] || a[9:7] != 0
                            || !(a[6:4] == 2 && PERIOD >= CAS2 || a[6:4] == 3 && PERIOD >= t_cas3))
                        violation("mode");
                    length_code = a[2:0];
                    latency = a[5:4];
                    moded = 1;
                    last_mode = now;
                    ever_mode = 1;
                end
                default: violation("unsupported");
            endcase
        end

        // A beat of the burst: written now, or read to be on DQ in time.
        fresh_valid = 0;
        fresh = 0;
        if (bursting && burst_left != 0) begin
            index = index_of(burst_bank, burst_column);
            if (burst_write) begin
                if (!dq_oe && !(&dqm)) violation("no-data");
                for (b = 0; b < BYTES; b = b + 1)
                    if (!dqm[b])
                        store[index][8*b +: 8] = dq_i[8*b +: 8];
                written[burst_bank] = now;
                ever_written[burst_bank] = 1;
                beats_written = beats_written + 1;
            end else begin
                fresh = store[index];
                fresh_valid = 1;
                beats_read = beats_read + 1;
            end
            // The column counts within its burst.
            for (k = 0; k < 3; k = k + 1)
                if (k[2:0] < length_code)
                    burst_column[k] = burst_column[k] ^ (k == 0 ? 1'b1
                                      : k == 1 ? !burst_column[0] : burst_column[1:0] == 0);
            burst_left = burst_left - 1;
            if (burst_left == 0) bursting = 0;
        end

        shown = pipe;
        shown_valid = pipe_valid;
        // Bytes whose DQM was high two edges before they would be sampled are not driven.
        for (b = 0; b < BYTES; b = b + 1)
            if (mask[b])
                shown[8*b +: 8] = 8'hA5;
        dq_o <= shown;
        dq_drives <= shown_valid && !(&mask);
        pipe <= latency == 3 ? pipe3 : fresh;
        pipe_valid <= latency == 3 ? pipe3_valid : fresh_valid;
        pipe3 <= fresh;
        pipe3_valid <= fresh_valid;
        mask <= dqm;
        if (controller_rst) gap_counts = 0;
        now = now + 1;
    end

    // Content, for benches: bank, row and column from the top.
    task put(input [31:0] at, input [DATA-1:0] value);
        store[at] = value;
    endtask

    function [DATA-1:0] get(input [31:0] at);
        get = store[at];
    endfunction
endmodule
