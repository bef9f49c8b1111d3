// A host at a serial line of BAUD bits a second, eight bits, no parity, one stop bit: sends the bytes
// of the plusarg uart_bytes, in hexadecimal, at uart_at_us, and prints "UART <byte>" for each that
// comes, and "BOARD-ERROR" where a stop bit is low.

`timescale 1ps/1ps

module uart_host #(parameter BAUD = 1000000) (input wire receive, output reg send);
    localparam real BIT = 1e12 / BAUD;
    reg [255:0] bytes;
    integer at_us, count, k, n;
    reg [7:0] sent, come;
    initial begin
        send = 1;
        if ($value$plusargs("uart_at_us=%d", at_us) && $value$plusargs("uart_bytes=%h", bytes)
            && $value$plusargs("uart_count=%d", count)) begin
            #(at_us * 1000000.0);
            for (k = count - 1; k >= 0; k = k - 1) begin
                sent = bytes >> 8 * k;
                send = 0;
                #BIT;
                for (n = 0; n < 8; n = n + 1) begin
                    send = sent[n];
                    #BIT;
                end
                send = 1;
                #BIT;
            end
        end
    end

    integer b;
    initial forever begin
        @(negedge receive);
        #(1.5 * BIT);
        for (b = 0; b < 8; b = b + 1) begin
            come[b] = receive;
            #BIT;
        end
        if (!receive) $display("BOARD-ERROR a stop bit is low");
        $display("UART %02x", come);
    end
endmodule
