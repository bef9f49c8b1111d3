"""Boards with Intel's Cyclone IV E and Cyclone V, for Quartus: pins, constraints, project."""
