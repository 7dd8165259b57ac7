"""What the vehicle is connected to, on the loopback: a base station that sends commands, a vehicle that takes torques.

The base station plays four scenes, each until the vehicle shows the torque that it should lead to: it commands full
ahead, with messages that are damaged in between; an obstacle comes near while it goes on commanding; the obstacle is
gone; and it falls silent.
"""

from __future__ import annotations

import itertools
import socket
import threading

AHEAD, BAD = "$x1.00y0.00z0.00t0.00$", ("$x1.0.0$", "$x1.00", "x1.00$", "$q1.00$", "$x--1$")


def _udp() -> socket.socket:
    found = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    found.bind(("127.0.0.1", 0))
    found.settimeout(0.1)
    return found


class World:
    """Both ends of the sockets."""

    def __init__(self) -> None:
        self.commands, self.torques, self._station = _udp(), _udp(), _udp()
        self.closed = threading.Event()
        self.near = False
        """Whether there is an obstacle near the vehicle."""
        self.seen: list[tuple[str, int]] = []
        """The scene, and the torque that the vehicle got in it."""
        self._scene = "ahead"
        self._threads = [threading.Thread(target=self._command), threading.Thread(target=self._vehicle)]

    def start(self, ended: threading.Event) -> None:
        """Begin; *ended* is set when the play is over."""
        self._ended = ended
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """Send and take no more."""
        self.closed.set()
        for thread in self._threads:
            thread.join()
        for one in (self.commands, self.torques, self._station):
            one.close()

    def receive(self) -> str | None:
        """The next message that the base station sends to the vehicle; None when the vehicle is being shut down."""
        while not self.closed.is_set():
            try:
                return self.commands.recv(100).decode("ascii", "replace")
            except TimeoutError:
                continue
        return None

    def send(self, torque: int) -> None:
        """Send a torque to the thrusters' controller."""
        self._station.sendto(f"$i{torque / 100:.2f}$".encode(), self.torques.getsockname())

    def _command(self) -> None:
        damaged = itertools.cycle(BAD)
        while not self.closed.wait(0.02):
            if self._scene == "silent":
                continue
            for message in (AHEAD, next(damaged)):
                self._station.sendto(message.encode(), self.commands.getsockname())

    def _vehicle(self) -> None:
        scenes = iter([("obstacle", 0), ("clear", 100), ("silent", 0), ("over", None)])
        wanted: int | None = 100
        while not self.closed.is_set():
            try:
                torque = round(100 * float(self.torques.recv(100).decode()[2:-1]))
            except TimeoutError:
                continue
            self.seen.append((self._scene, torque))
            if torque == wanted:
                self._scene, wanted = next(scenes)
                self.near = self._scene == "obstacle"
                if self._scene == "over":
                    self._ended.set()
                    return


world = World()
