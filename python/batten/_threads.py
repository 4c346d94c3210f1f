"""How many threads work."""

import operator
import os

from . import _batten
from ._errors import InvalidInput


def set_threads(n):
    """Set the most threads that the work runs on, for the whole process. Results never depend on it.

    Parameters
    ----------
    n : int or str
        1 to 1024, or "all" processors that the process may use.

    Raises
    ------
    InvalidInput
    """
    try:
        number = 0 if isinstance(n, str) and n == "all" else operator.index(n)
    except TypeError:
        number = -1
    if isinstance(n, bool) or not (1 <= number <= 1024 or (number == 0 and isinstance(n, str))):
        raise InvalidInput(f"threads must be all or a whole number from 1 to 1024, got {n!r}")
    _batten.set_threads(number)


def threads():
    """The most threads that the work runs on: BATTEN_THREADS where that is set, else all processors."""
    return _batten.threads()


def _choose():
    text = os.environ.get("BATTEN_THREADS", "")
    if text:
        set_threads(int(text) if text.isdecimal() else text)


_choose()
