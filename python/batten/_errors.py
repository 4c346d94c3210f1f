"""What goes wrong, by cause. Every message is one sentence that says what helps."""


class Error(RuntimeError):
    """Base of everything that batten raises by itself: the work failed."""


class InvalidInput(Error, ValueError):
    """An argument breaks what its description says; the caller can mend it."""


class FileError(Error, OSError):
    """A file cannot be read or written.

    Attributes
    ----------
    path : str
        The file.
    line : int or None
        The line that is to blame, counted from 1.
    """

    path = ""
    line = None


class SolverFailure(Error):
    """A linear system could not be factorised or solved; the message says which one."""


class Cancelled(Error):
    """`progress` returned False. Nothing has been changed."""
