"""Progress by tqdm, where it is installed."""

from __future__ import annotations

import contextlib
from typing import Any, Callable, Iterator, Optional

Told = Callable[[str, float, float], None]


@contextlib.contextmanager
def told(progress: bool) -> Iterator[Optional[Told]]:
    """What long work tells its progress, with a bar for each piece of it; None where it is not wanted or there is no
    tqdm."""
    tqdm: Any = None
    with contextlib.suppress(ImportError):
        if progress:
            from tqdm.auto import tqdm  # type: ignore[import-untyped,no-redef]
    if tqdm is None:
        yield None
        return
    bar: Any = None
    with contextlib.ExitStack() as bars:

        def tell(what: str, done: float, total: float) -> None:
            nonlocal bar
            if bar is None or bar.desc != what:
                bars.close()
                bar = tqdm(total=total, desc=what, bar_format="{desc}: {percentage:3.0f}%|{bar}| {elapsed}")
                bar.desc = what
                bars.callback(bar.close)
            if done > bar.n:
                bar.update(done - bar.n)

        yield tell
