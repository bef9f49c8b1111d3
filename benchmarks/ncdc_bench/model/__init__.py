"""Speed of the bit-exact models."""
