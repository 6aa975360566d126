"""What is being done, for whoever waits at a terminal: one line of standard error, gone before anything is printed."""
import atexit
import os
import sys


def show(doing=""):
    """Nothing in a pipe, or on a terminal that only prints."""
    if sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb":
        sys.stderr.write(f"\r\033[K{doing}")
        sys.stderr.flush()


atexit.register(show)
