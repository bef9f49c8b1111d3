// An Ethernet chip at RGMII, 1000 Mbit/s, as far as the firmware knows it, its registers by MDIO (IEEE
// 802.3, clause 22): a Marvell 88E1111, from Linux's driver of it and the pins' times from RGMII 1.3 and
// 2.0, or with `B50612D` a Broadcom B50612D, from its data sheet. The latter delays both clocks after its
// reset; here neither, so that it is seen whether the firmware sets them. What comes on the cable is in
// rx.bin, frames with their check sequence, each after four bytes with its microsecond and two with its
// length, big endian; what was sent goes to tx.bin, likewise, with its preamble.
//
// Until its reset pin is released and it is set to negotiate it is silent, and so is the 88E1111 before
// its software reset is over, and unless RGMII is its mode.

`timescale 1ps/1ps

module rgmii_chip #(parameter ADDRESS = 16, B50612D = 0) (
    input  wire       rst_n, mdc,
    inout  wire       mdio,
    input  wire       tx_clk, tx_ctl,
    input  wire [3:0] tx_data,
    output wire       rx_clk,
    output reg        rx_ctl,
    output reg  [3:0] rx_data
);
    localparam RESET_US = 20, LINK_US = 200;    // less than a chip takes
    localparam MDC_PS = 400000;                 // 2.5 MHz
    localparam SKEW_PS = 500;
    localparam HOLD_PS = 1000;                  // RGMII 1.3: setup and hold at a receiver

    // Registers. Those after "next" count from the software reset on.
    reg [15:0] offered = 16'h01e1, offered_1000 = 16'h0300, control = 16'h1140;
    reg [15:0] next_extended = 16'h0c60, extended = 16'h0c60;
    reg [15:0] next_mode = 16'h848f, mode = 16'h848f;      // GMII
    reg link = 0;
    wire [15:0] status = {2'b10, 1'b1, 1'b0, link, link, 10'b0};
    integer resets = 0;

    // Of a B50612D: what registers 24 and 28 show, and the two after them.
    reg [2:0]  shown = 0;
    reg [4:0]  shown_too = 0;
    reg [11:3] skew = 9'b0;
    reg [9:0]  alignment = 0;
    wire receive_late = B50612D ? skew[8] : extended[7];
    wire transmit_late = B50612D && alignment[9];

    function [15:0] broadcom(input [4:0] which);
        case (which)
            2: broadcom = 16'h0362;
            3: broadcom = 16'h5e62;
            24: broadcom = shown == 7 ? {1'b0, shown, skew, 3'b111} : 0;
            25: broadcom = {link, 4'b0, link ? 3'b111 : 3'b000, 5'b0, link, 2'b0};
            28: broadcom = {1'b0, shown_too, shown_too == 3 ? alignment : 10'b0};
            default: broadcom = 0;
        endcase
    endfunction

    function [15:0] value_of(input [4:0] which);
        if (B50612D && which != 0 && which != 4 && which != 9) value_of = broadcom(which);
        else case (which)
            0: value_of = control;
            2: value_of = 16'h0141;
            3: value_of = 16'h0cc2;
            4: value_of = offered;
            9: value_of = offered_1000;
            17: value_of = status;
            20: value_of = next_extended;
            27: value_of = next_mode;
            default: value_of = 0;
        endcase
    endfunction

    task write(input [4:0] which, input [15:0] value);
        if (B50612D && which == 24) begin
            if (!value[15]) shown = value[14:12];
            else if (value[2:0] == 7) skew = value[11:3];
        end else if (B50612D && which == 28) begin
            shown_too = value[14:10];
            if (value[15] && value[14:10] == 3) alignment = value[9:0];
        end else if (B50612D && which == 0) begin
            control = value & 16'h7dff;
            if (value[9]) restart;
        end else case (which)
            0: if (value[15]) restart; else control = value;
            4: offered = value;
            9: offered_1000 = value;
            20: if (!B50612D) next_extended = value;
            27: if (!B50612D) next_mode = value;
            default: $display("BOARD-ERROR the Ethernet chip's register %0d is written", which);
        endcase
    endtask

    task restart;
        fork begin
            if (!B50612D) control = 16'h9140;
            link = 0;
            resets = resets + 1;
            #(RESET_US * 1000000.0);
            extended = next_extended;
            mode = next_mode;
            control = 16'h1140;
            // Half duplex is not what the processor's side can do.
            if (offered[5] || offered[7] || offered_1000[8])
                $display("BOARD-ERROR half duplex is offered");
            #(LINK_US * 1000000.0) link = rst_n;
        end join_none
    endtask

    // MDIO: 32 ones, 01, operation, chip, register, turn, data.
    reg [31:0] in = 0;
    reg [15:0] out = 0;
    integer ones = 0, bits = -1;
    reg driven = 0, level = 0;
    assign mdio = driven ? level : 1'bz;
    reg reads = 0;
    real risen = 0;
    always @(posedge mdc) begin
        if ($realtime - risen < MDC_PS) $display("BOARD-ERROR MDC is too fast");
        risen = $realtime;
        in = {in[30:0], mdio};
        if (bits < 0) begin
            if (mdio !== 1'b0) ones = ones + 1;
            else begin
                if (ones >= 32 && rst_n) bits = 1;
                ones = 0;
            end
        end else begin
            bits = bits + 1;
            if (bits == 14 && in[11:10] == 2'b10 && in[9:5] == ADDRESS) out = value_of(in[4:0]);
            if (bits == 32) begin
                if (in[29:28] == 2'b01 && in[27:23] == ADDRESS && in[17:16] == 2'b10)
                    write(in[22:18], in[15:0]);
                bits = -1;
                driven <= #300000 0;
            end else if (bits >= 15 && reads) begin
                // The second bit of the turn is 0, then come the data.
                driven <= #300000 1;
                level <= #300000 (bits == 15 ? 1'b0 : out[31 - bits]);
            end
        end
        if (bits == 14) reads = in[11:10] == 2'b10 && in[9:5] == ADDRESS;
    end

    wire works = rst_n && link && (B50612D || mode[3:0] == 4'hb);

    // To the device: the clock 2 ns after the data, or with them, which may be half a nanosecond
    // before.
    reg clock = 0, late = 0;
    always #4000 clock = !clock;
    always @(clock) late <= #(SKEW_PS + 2000) clock;
    assign rx_clk = receive_late ? late : clock;

    integer file, us, length, k, frames = 0;
    reg [7:0] octet;
    task send(input [7:0] value);
        begin
            @(posedge clock) rx_data <= #SKEW_PS value[3:0];
            rx_ctl <= #SKEW_PS 1;
            @(negedge clock) rx_data <= #SKEW_PS value[7:4];
        end
    endtask
    initial begin
        rx_ctl = 0;
        rx_data = 0;
        file = $fopen("rx.bin", "rb");
        octet = $fgetc(file);
        while (!$feof(file)) begin
            us = octet;
            repeat (3) us = us << 8 | $fgetc(file);
            length = $fgetc(file);
            length = length << 8 | $fgetc(file);
            while ($time < us * 1000000.0) #1000000;
            repeat (7) send(8'h55);
            send(8'hd5);
            for (k = 0; k < length; k = k + 1) begin
                octet = $fgetc(file);
                send(octet);
            end
            // What comes while the chip does not listen is lost, as on a cable.
            @(posedge clock) rx_ctl <= #SKEW_PS 0;
            rx_data <= #SKEW_PS 4'b1101;                  // link, 1000 Mbit/s, full duplex
            frames = frames + 1;
            repeat (12) @(posedge clock);
            octet = $fgetc(file);
        end
    end

    // From the device: bytes of a frame are stored until it is over. What samples them is the clock that was
    // sent, or later.
    localparam DELAY_PS = 1900;
    reg tx_late = 0;
    always @(tx_clk) tx_late <= #DELAY_PS tx_clk;
    wire sampled = transmit_late ? tx_late : tx_clk;
    integer log, sent = 0, errors = 0;
    reg [7:0] frame [0:16383];
    reg [3:0] low;
    reg busy = 0;
    real changed = 0, edged = 0, begun = 0;
    initial begin
        log = $fopen("tx.bin", "wb");
        if (!log) $display("BOARD-ERROR tx.bin cannot be written");
    end
    integer n = 0;
    always @(tx_data or tx_ctl) begin
        changed = $realtime;
        if (works && busy && changed - edged < HOLD_PS) errors = errors + 1;
    end
    always @(sampled) begin
        edged = $realtime;
        if (works && busy && edged - changed < HOLD_PS) errors = errors + 1;
    end
    always @(posedge sampled) if (works) begin
        low <= tx_data;
        if (tx_ctl && !busy) begin
            begun = $realtime;
            n = 0;
        end
        if (!tx_ctl && busy) begin
            put(begun / 1000000.0, 4);
            put(n, 2);
            for (j = 0; j < n; j = j + 1) put(frame[j], 1);
            sent = sent + 1;
        end
        busy <= tx_ctl;
    end
    integer j;
    task put(input [31:0] value, input integer bytes);
        repeat (bytes) begin
            bytes = bytes - 1;
            $fwrite(log, "%c", value[8 * bytes +: 8]);
        end
    endtask
    task close; $fclose(log); endtask
    always @(negedge sampled) if (works && busy) begin
        frame[n] = {tx_data, low};
        n = n + 1;
        // Both halves of a byte: an error is signalled by a change between them.
        if (!tx_ctl) errors = errors + 1;
    end
endmodule
