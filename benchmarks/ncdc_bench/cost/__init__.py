"""``ncdc bench cost``: what a corrector costs as the picture and the lens's view grow."""
