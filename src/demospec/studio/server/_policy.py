"""What a browser may do with the studio's pages: scripts of the studio only, nothing elsewhere."""

from __future__ import annotations

import re
import secrets
from typing import Any

from demospec.studio.server._guard import Receive, Scope, Send

_POLICY = (
    "default-src 'none'; script-src 'self' 'nonce-{nonce}' 'unsafe-eval'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; media-src 'self'; "
    "font-src 'self' data:; connect-src 'self' {sockets}; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'; object-src 'none'"
)
"""``unsafe-eval``: nicegui runs what the server sends over the socket that way. An inline handler
or script that came with somebody's text has no nonce and does not run."""

_SCRIPT = re.compile(rb"<script(?=[\s>])")


class Policy:
    """ASGI middleware: a Content-Security-Policy for every page, and a nonce for its own scripts.

    The pages of nicegui hold data as JSON without ``<``, so that every ``<script`` in them is one
    of the page itself.
    """

    def __init__(self, app: Any) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        nonce = secrets.token_urlsafe(16)
        host = dict(scope["headers"]).get(b"host", b"").decode("latin-1")
        sockets = f"ws://{host} wss://{host}" if re.fullmatch(r"[\w.:\[\]-]+", host) else ""
        begun: dict[str, Any] | None = None
        body = bytearray()

        async def sending(message: Any) -> None:
            nonlocal begun
            if message["type"] == "http.response.start":
                headers = [*message.get("headers", []), (b"x-content-type-options", b"nosniff")]
                message = {**message, "headers": headers}
                kind = dict(headers).get(b"content-type", b"")
                if kind.startswith(b"text/html"):
                    begun = message  # its length changes with the nonces
                    return
            elif begun is not None and message["type"] == "http.response.body":
                body.extend(message.get("body", b""))
                if message.get("more_body"):
                    return
                page = _SCRIPT.sub(b'<script nonce="' + nonce.encode() + b'"', bytes(body))
                policy = _POLICY.format(nonce=nonce, sockets=sockets).encode()
                kept = [h for h in begun["headers"] if h[0].lower() != b"content-length"]
                length = (b"content-length", str(len(page)).encode())
                kept += [length, (b"content-security-policy", policy)]
                await send({**begun, "headers": kept})
                message, begun = {"type": "http.response.body", "body": page}, None
            await send(message)

        await self.app(scope, receive, sending)
