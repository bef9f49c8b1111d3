"""An emulated device: what camera, corrector and network link will be, in Python."""
