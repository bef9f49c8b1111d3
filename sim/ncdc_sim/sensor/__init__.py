"""Sensors in simulation: the Verilog model, its twin in NumPy, scenes that move."""
