"""Open tools that make netlists, placements and bitstreams of Verilog."""
