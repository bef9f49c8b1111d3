"""A lot of synthetic units with known flaws: verdicts and figures compared with truth."""
