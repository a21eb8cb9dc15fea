"""A running server, a browser, and pages that fail on whatever a user would call broken."""

from app_pages import browser, page, server, watch

__all__ = ["browser", "page", "server", "watch"]
