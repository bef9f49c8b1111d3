"""The fetcher with a prefetching cache of tiles."""
