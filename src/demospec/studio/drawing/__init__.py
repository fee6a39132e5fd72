"""Drawing of scenes and contours as SVG."""
