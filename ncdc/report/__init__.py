"""The report of a whole run: pictures side by side, figures, one HTML page."""
