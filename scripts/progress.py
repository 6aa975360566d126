"""What is being done, for whoever waits at a terminal: one line of standard error, gone before anything is printed."""
import atexit
import os
import signal
import sys


def show(doing=""):
    """Nothing in a pipe, or on a terminal that only prints."""
    if sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb":
        sys.stderr.write(f"\r\033[K{doing}")
        sys.stderr.flush()


def end_with_the_pipe():
    """Behind `| head` a program ends without a word, as others do."""
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)


atexit.register(show)
