"""Other maps fitted to the same points, to judge the network by."""
