"""Progress by tqdm, where it is installed."""

from __future__ import annotations

import contextlib
from typing import Any, Callable, Iterator, Optional

Told = Callable[[str, float, float], None]


class _Bars:
    """One bar for each piece of work."""

    def __init__(self, tqdm: Any) -> None:
        self._tqdm = tqdm
        self._bar: Any = None

    def __call__(self, what: str, done: float, total: float) -> None:
        if self._bar is None or self._bar.desc != what:
            self.close()
            self._bar = self._tqdm(total=total, desc=what, bar_format="{desc}: {percentage:3.0f}%|{bar}| {elapsed}")
            self._bar.desc = what
        if done > self._bar.n:
            self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None


@contextlib.contextmanager
def told(progress: bool) -> Iterator[Optional[Told]]:
    """What long work tells its progress; None where it is not wanted or there is no tqdm."""
    if not progress:
        yield None
        return
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped]
    except ImportError:
        yield None
        return
    bars = _Bars(tqdm)
    try:
        yield bars
    finally:
        bars.close()
