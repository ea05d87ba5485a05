"""Thread that works through a generator and can be stopped between two items."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Worker(Generic[Item]):
    """Draws from a generator in a thread of its own, so that the caller stays free.

    The generator must not touch Blender's data: only the main thread may.

    Attributes
    ----------
    is_stopping
        Whether a stop was asked for.
    """

    def __init__(self, items: Iterator[Item]) -> None:
        self._items = items
        self._lock = threading.Lock()
        self._news: list[Item] = []
        self._error: BaseException | None = None
        self._stop = threading.Event()
        # A daemon: Blender may quit while a step is being computed.
        self._thread = threading.Thread(target=self._work, name="Adaptive Fairing", daemon=True)
        self._thread.start()

    @property
    def is_stopping(self) -> bool:
        return self._stop.is_set()

    def stop(self) -> None:
        """Ask to stop after the item that is being computed."""
        self._stop.set()

    def poll(self) -> tuple[list[Item], bool]:
        """Return the new items, and whether they are the last.

        Raises
        ------
        BaseException
            Raised by the generator; raised here again in the caller's thread.
        """
        is_last = not self._thread.is_alive()  # asked first: the thread may end meanwhile
        with self._lock:
            news, self._news = self._news, []
        if is_last and self._error is not None:
            raise self._error
        return news, is_last

    def join(self, timeout: float) -> None:
        """Wait for the thread to end, at most `timeout` seconds."""
        self._thread.join(timeout)

    def _work(self) -> None:
        try:
            for item in self._items:
                with self._lock:
                    self._news.append(item)
                if self._stop.is_set():
                    return
        except BaseException as error:  # raised again in the main thread by poll
            self._error = error
