"""The whole system on a network, seen by programs of others."""
