"""The web server: pages, JSON end points, access control."""
