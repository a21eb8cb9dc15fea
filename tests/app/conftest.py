"""A running server, a browser, and pages that fail on whatever a user would call broken."""

from app_pages import anchor, browser, page, server, watch

__all__ = ["anchor", "browser", "page", "server", "watch"]
