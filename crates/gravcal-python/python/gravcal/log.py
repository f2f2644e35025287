"""What is logged, under the name `gravcal`: doubts as warnings, remarks of the program as information, progress for debugging.

Nothing of it is shown unless logging is set up, as by ``logging.basicConfig(level=logging.INFO)``.
"""

from __future__ import annotations

import logging

from .recording import Progress

__all__ = ["LOG", "logged"]

LOG = logging.getLogger("gravcal")
LOG.addHandler(logging.NullHandler())


def logged(progress: Progress) -> Progress:
    """The same, with its news logged, where somebody wants that."""
    if not LOG.isEnabledFor(logging.DEBUG):
        return progress

    def told(news: str) -> None:
        LOG.debug(news)
        if progress is not None:
            progress(news)

    return told
