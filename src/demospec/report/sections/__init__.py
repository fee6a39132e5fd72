"""The sections of a report, one module for a few questions each."""
