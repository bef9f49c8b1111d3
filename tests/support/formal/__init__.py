"""Formal proofs: properties around the gateware, and the run of the tools."""
