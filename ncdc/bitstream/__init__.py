"""From a design for an ECP5 to its bitstream, by open tools."""
