// Connections of a module under test to the buses of bench_buses.vh; NCDC_WRITES: it writes frames.
        .csr_address(csr_address), .csr_read(csr_read), .csr_write(csr_write),
        .csr_writedata(csr_writedata), .csr_readdata(csr_readdata),
        .csr_readdatavalid(csr_readdatavalid), .csr_waitrequest(csr_waitrequest),
        `NCDC_READ_PORT(0),
`ifdef NCDC_THREE_READ_PORTS
        `NCDC_READ_PORT(1),
        `NCDC_READ_PORT(2),
`endif
`ifdef NCDC_STREAM
        .stream_valid(stream_valid), .stream_ready(stream_ready), .stream_data(stream_data),
        .stream_startofpacket(stream_startofpacket), .stream_endofpacket(stream_endofpacket),
`endif
`ifdef NCDC_WRITES
        .write_address(write_address), .write_write(write_write),
        .write_burstcount(write_burstcount), .write_writedata(write_writedata),
        .write_byteenable(write_byteenable), .write_waitrequest(write_waitrequest),
`endif
        .irq(irq)
