"""The page of a station: the newest verdict large, counts, last units that did not pass."""
