"""Queries, answered at a limited rate by a payload or by an error reply of one sentence."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import Any, Final

import zenoh

from bridge.errors import NaoHilError
from bridge.link.seal import Seal


class RateLimit:
    """Token bucket: bursts pass, a lasting flood does not. Not thread-safe.

    Args:
        rate: events per second in the long run.
        burst: events at once, after a pause.
    """

    def __init__(self, rate: float, burst: int) -> None:
        self._rate, self._burst = rate, float(burst)
        self._tokens, self._last = float(burst), 0.0

    def admits(self, now: float) -> bool:
        """Whether an event at `now` (monotonic, s) is within the bound; it then counts."""
        self._tokens = min(self._burst, self._tokens + self._rate * max(0.0, now - self._last))
        self._last = now
        if self._tokens < 1.0:
            return False
        self._tokens -= 1.0
        return True


QUERY_RATE: Final = 1000.0
"""1/s; queries of one key answered in the long run, and at once."""

logger = logging.getLogger(__name__)


def serve_query(session: zenoh.Session, key: str, answer: Callable[[bytes, bytes], bytes]) -> Any:
    """Answer queries on a key; an error of `answer` becomes an error reply with one sentence.

    Args:
        session: of the side that answers.
        key: whole.
        answer: called in a thread of its own with the query's payload and its attachment (empty when there
            is none).

    Returns:
        The queryable; keep it for as long as queries are to be answered.
    """
    limit = RateLimit(QUERY_RATE, int(QUERY_RATE))

    def on_query(query: zenoh.Query) -> None:
        """Answer one query, or refuse it in one sentence."""
        with query:
            if not limit.admits(time.monotonic()):
                query.reply_err(
                    f"Queries of `{key}` come faster than {QUERY_RATE:g} per second; ask less often.".encode()
                )
                return
            try:
                parts = (part.to_bytes() if part else b"" for part in (query.payload, query.attachment))
                reply = answer(*parts)
            except NaoHilError as error:
                query.reply_err(str(error).encode())
            except Exception as error:  # one query's fault must neither hang its sender nor end the thread
                logger.exception("query `%s` failed", key)
                query.reply_err(f"`{key}` failed: {error!r}.".encode())
            else:
                query.reply(key, reply)

    return session.declare_queryable(key, on_query)


def ask(
    session: zenoh.Session,
    key: str,
    payload: bytes,
    timeout: float,
    refused: type[NaoHilError],
    seal: Seal | None = None,
) -> bytes | None:
    """The first answer to a query; None: no answer.

    Args:
        session: of the side that asks.
        key: whole.
        payload: of the query.
        timeout: s to wait.
        refused: raised with the sentence of an error reply.
        seal: the query is sealed with.

    Raises:
        NaoHilError: `refused`.
    """

    def send(attachment: bytes | None) -> Any:
        return session.get(key, payload=payload, timeout=timeout, attachment=attachment)

    for reply in send(None) if seal is None else seal.send(key, payload, send):
        if reply.ok is not None:
            return bytes(reply.ok.payload.to_bytes())
        if reply.err is not None:
            text = reply.err.payload.to_bytes().decode(errors="replace")
            if text and text != "Timeout":  # Zenoh's own word for no answer
                raise refused(text)
    return None
