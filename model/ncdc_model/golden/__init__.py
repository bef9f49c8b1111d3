"""The golden model: what the gateware must compute, bit for bit."""
