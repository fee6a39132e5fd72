"""Who may ask the studio: this machine's own pages and programs, or who brings the token."""

from __future__ import annotations

import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

COOKIE = "demospec_token"
MAX_BODY_BYTES = 12 * 1024 * 1024
"""Largest body of any request: a picture of a table."""

OWN_NAMES = ("127.0.0.1", "localhost", "[::1]")

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Any]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]


class Guard:
    """ASGI middleware before every page, file, end point and socket.

    Without a token the request must name this machine (a foreign name that resolves to
    127.0.0.1 is refused: DNS rebinding). A browser page of another origin is always refused.
    With a token every request must bring it as ``?token=``, cookie or ``Authorization: Bearer``.
    """

    def __init__(self, app: Any, token: str | None = None) -> None:
        self.app = app
        self.token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = {k.decode("latin-1"): v.decode("latin-1") for k, v in scope["headers"]}
        refusal = self._refusal(scope, headers)
        if refusal is not None:
            await _refuse(scope, receive, send, *refusal)
            return
        if self.token and self._asked_token(scope) is not None:
            send = _with_cookie(send, self.token)
        await self.app(scope, receive, send)

    def _refusal(self, scope: Scope, headers: dict[str, str]) -> tuple[int, str] | None:
        host = headers.get("host", "")
        name = host if host.endswith("]") else host.rsplit(":", 1)[0]
        if self.token is None and name not in OWN_NAMES:
            return 421, "this studio answers to 127.0.0.1 and localhost only"
        origin = headers.get("origin")
        if origin is not None and _place(origin) != host:
            return 403, "pages of other origins may not ask the studio"
        if self.token is not None and not self._brings_token(scope, headers):
            return 401, "open the address with ?token=… as the studio printed it"
        try:
            length = int(headers.get("content-length", "0"))
        except ValueError:
            return 400, "the content-length is no number"
        if length > MAX_BODY_BYTES:
            return 413, f"at most {MAX_BODY_BYTES} bytes"
        if "transfer-encoding" in headers:
            return 411, "say the length of the body"
        return None

    def _asked_token(self, scope: Scope) -> str | None:
        query = parse_qs(scope.get("query_string", b"").decode("latin-1"))
        return query["token"][0] if "token" in query else None

    def _brings_token(self, scope: Scope, headers: dict[str, str]) -> bool:
        assert self.token is not None
        brought = [self._asked_token(scope)]
        kind, _, value = headers.get("authorization", "").partition(" ")
        if kind.lower() == "bearer":
            brought.append(value)
        try:
            cookie = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
        except CookieError:
            cookie = None
        brought.append(None if cookie is None else cookie.value)
        mine = self.token.encode()
        return any(secrets.compare_digest(b.encode(), mine) for b in brought if b is not None)


def _place(origin: str) -> str | None:
    """Host and port of an origin; None where it is none."""
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return None


async def _refuse(scope: Scope, receive: Receive, send: Send, status: int, words: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": (words + "\n").encode()})


def _with_cookie(send: Send, token: str) -> Send:
    from urllib.parse import quote

    async def sending(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            cookie = f"{COOKIE}={quote(token, safe='')}; HttpOnly; SameSite=Strict; Path=/"
            message["headers"] = [*message.get("headers", []), (b"set-cookie", cookie.encode())]
            # The address holds the token: it must not travel on to other sites.
            message["headers"].append((b"referrer-policy", b"no-referrer"))
        await send(message)

    return sending
