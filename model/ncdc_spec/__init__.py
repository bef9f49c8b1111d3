"""What all sides agree on: formats, registers, protocols, sensors and the descriptor. Needs NumPy
alone; nothing here knows how a value is computed or transported by either side."""
