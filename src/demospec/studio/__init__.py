"""The studio: a local web page over the library's own functions."""

from demospec.studio.server._server import serve

__all__ = ["serve"]
