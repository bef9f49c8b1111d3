"""What boards with a Lattice ECP5 have in common."""
