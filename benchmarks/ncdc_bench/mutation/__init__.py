"""Mutation score: which small changes no test notices."""
