"""A production lot: every unit calibrated, trained, compared with limits, and recorded."""
