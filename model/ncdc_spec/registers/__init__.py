"""Registers of the corrector, the camera system and the serial link, and the values they take."""
