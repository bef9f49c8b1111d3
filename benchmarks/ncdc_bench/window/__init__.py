"""The client's window under a stopwatch, and its pictures for the documentation."""
