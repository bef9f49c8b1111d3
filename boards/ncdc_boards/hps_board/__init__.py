"""Boards whose memory is that of a hard processor beside the FPGA: Platform Designer and Quartus."""
