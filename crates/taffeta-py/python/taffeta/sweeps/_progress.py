"""How far a sweep is, for people."""

from __future__ import annotations

import sys
import time


class Progress:
    """A line on stderr: rewritten on a terminal, and a new one every few seconds elsewhere."""

    _PAUSE = {True: 0.1, False: 10.0}

    def __init__(self, already: int, everything: int) -> None:
        self._already = already
        self._start = time.monotonic()
        self._shown = 0.0
        if already:
            print(f"sweep: {already} of {everything} were done before", file=sys.stderr)

    def __call__(self, done: int, failed: int, everything: int) -> None:
        """Tells it, where the last time is long enough ago."""
        now, is_terminal = time.monotonic(), sys.stderr.isatty()
        if now - self._shown < self._PAUSE[is_terminal] and done < everything:
            return
        self._shown = now
        left = (now - self._start) / max(1, done - self._already) * (everything - done)
        line = f"sweep: {done} of {everything} done"
        line += f", {failed} failed" if failed else ""
        line += f", about {_duration(left)} left" if done < everything else ""
        end = "\n" if done == everything or not is_terminal else ""
        print(f"\r{line}\x1b[K" if is_terminal else line, end=end, file=sys.stderr, flush=True)


def _duration(seconds: float) -> str:
    """A duration that a person would say.

    >>> _duration(42.0), _duration(600.0), _duration(9000.0)
    ('42 s', '10 min', '2.5 h')
    """
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.1f} h"
