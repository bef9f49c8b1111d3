"""Networks for tests and benches: namespaces of their own, peers in them."""
