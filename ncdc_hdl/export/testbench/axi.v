
// AXI4 reads and writes on the memories above; a write is answered some clocks after its words.
module ncdc_tb_axi_writer #(
    parameter WIDTH = 32
) (
    input  wire        clk,
    input  wire        rst,
    input  wire        awvalid,
    output wire        awready,
    input  wire        wvalid,
    input  wire        wlast,
    output wire        wready,
    output reg         bvalid,
    input  wire        bready,
    output wire        write,
    input  wire        waitrequest
);
    // The address is held until the last word, and accepted with it.
    reg [7:0] later, due;                   // answers to come, clocks to the next one
    assign write = awvalid && wvalid;
    assign wready = write && !waitrequest;
    assign awready = wready && wlast;
    initial bvalid = 0;
    always @(posedge clk)
        if (rst) begin
            bvalid <= 0;
            later <= 0;
            due <= 0;
        end else begin
            if (bvalid && bready) bvalid <= 0;
            due <= due == 0 ? 0 : due - 1;
            if (awready && awvalid && due == 0) due <= 9;
            later <= later + awready - (later != 0 && due == 0 && !bvalid);
            if (later != 0 && due == 0 && !bvalid) bvalid <= 1;
        end
endmodule
