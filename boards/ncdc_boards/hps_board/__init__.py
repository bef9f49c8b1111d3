"""Boards whose memory is that of a hard processor: Platform Designer and Quartus."""
