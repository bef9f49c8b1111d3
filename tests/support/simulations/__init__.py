"""Simulations that only tests run; those of the commands and of the benches are ``ncdc_sim``."""

from pathlib import Path

__all__ = ["HDL"]

HDL = Path(__file__).parents[1] / "hdl"     # their Verilog and C++
