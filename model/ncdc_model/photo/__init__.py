"""Photos and raw frames in files of many formats, as the sensor sent them."""
