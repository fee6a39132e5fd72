"""The clearance family: measured distances, version space, posterior over rules, estimates."""
