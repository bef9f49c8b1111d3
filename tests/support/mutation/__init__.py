"""Designs whose mutants the benches must find; tests run the same benches without a mutant."""
