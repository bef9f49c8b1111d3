"""Whole boards in simulation: from the sensor's pins to the monitor's."""
