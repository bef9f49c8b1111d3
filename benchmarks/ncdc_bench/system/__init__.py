"""``ncdc bench system``: a running camera, from a sensor's pins to corrected pictures."""
