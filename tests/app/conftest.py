"""A running server, a browser, pages that fail on whatever a user would call broken, and a site."""

from pathlib import Path

import pytest

from app_pages import anchor, browser, page, server, watch
from latolato.app.site import write_site
from site_in_node import answers_in_node

__all__ = ["anchor", "browser", "page", "server", "watch"]


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The folder of a site, which no test changes."""
    folder = tmp_path_factory.mktemp("site")
    write_site(folder)
    return folder


@pytest.fixture(scope="session")
def ask_node(site, tmp_path_factory):
    """A function that returns what a program of this folder answers to requests, from a site."""

    def ask(program, requests, site=site):
        path = Path(__file__).with_name(program)
        return answers_in_node(path, site, requests, tmp_path_factory.mktemp("node"))

    return ask
