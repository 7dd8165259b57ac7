"""All tasks wait for ever: who offers what, and whom each one waits for."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from .alternation import Board


@dataclass(frozen=True, slots=True)
class Waiting:
    """A task that waits, what it offers, and the tasks that its offers lack."""

    task: str
    offers: tuple[str, ...]
    lacks: tuple[str, ...]

    def __str__(self) -> str:
        offers = ", ".join(self.offers) if self.offers else "nothing (it has stopped)"
        lacks = f"; it waits for {', '.join(self.lacks)}" if self.lacks else ""
        return f"{self.task} offers {offers}{lacks}"


class Deadlock(Exception):
    """No event is possible, and none will be: every task that has not ended waits for ever.

    ``waiting`` says of each task what it waits for, ``ended`` names the tasks that have ended, ``cycle`` is the
    shortest ring of tasks each of which waits for the next (empty if there is none).
    """

    def __init__(self, waiting: tuple[Waiting, ...], ended: tuple[str, ...], cycle: tuple[str, ...]) -> None:
        self.waiting = waiting
        self.ended = ended
        self.cycle = cycle
        lines = ["deadlock: every task waits for ever", *[f"  {one}" for one in waiting]]
        if ended:
            lines.append(f"  ended: {', '.join(ended)}")
        if cycle:
            lines.append(f"  {' -> '.join([*cycle, cycle[0]])}")
        super().__init__("\n".join(lines))


def deadlock(board: Board, ended: Iterable[str]) -> Deadlock:
    """What to say when nothing on the board is possible, now or later."""
    waiting = tuple([_waiting(board, task) for task in board.waiting])
    return Deadlock(waiting, tuple(ended), shortest_cycle({one.task: one.lacks for one in waiting}))


def _waiting(board: Board, task: str) -> Waiting:
    offers = [offer for offer in board.waiting[task] if offer is not None]
    lacks: dict[str, None] = {}
    for offer in offers:
        possible = offer.groups()
        for group, others in offer.channel.partners[task]:
            if possible is not None and group not in possible:
                continue
            absent = [other for other in others if not board.waits_on(other, offer.channel)]
            # Where all have offers on the channel, it is the values that do not agree.
            lacks.update(dict.fromkeys(absent or others))
    return Waiting(task, tuple([offer.text() for offer in offers]), tuple(lacks))


def shortest_cycle(waits_for: Mapping[str, Iterable[str]]) -> tuple[str, ...]:
    """The shortest ring of tasks each of which waits for the next; the first found of several; () if there is none."""
    best: tuple[str, ...] = ()
    for start in waits_for:
        paths: deque[tuple[str, ...]] = deque([(start,)])
        seen = {start}
        while paths and (not best or len(paths[0]) < len(best)):
            path = paths.popleft()
            for other in waits_for.get(path[-1], ()):
                if other == start:
                    if not best or len(path) < len(best):
                        best = path
                    paths.clear()
                    break
                if other not in seen:
                    seen.add(other)
                    paths.append((*path, other))
    return best
