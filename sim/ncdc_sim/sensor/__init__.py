"""Sensors in simulation: the Verilog model, its reference model in NumPy, scenes that move."""
