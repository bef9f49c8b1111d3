"""Common parts of all boards with a camera and a screen, for any device and any pins."""
