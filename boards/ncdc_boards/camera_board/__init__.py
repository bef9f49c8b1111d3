"""What every board with a camera and a screen has in common, whatever its device and its pins."""
