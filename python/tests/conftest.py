"""What several tests need."""

import signal

import pytest


@pytest.fixture
def keyboard():
    """Ctrl-C as at a terminal: jobs in the background of a shell ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
