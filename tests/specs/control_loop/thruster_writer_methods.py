"""What ThrusterWriter does by itself: it sends the torque to the controller of the thrusters."""

from __future__ import annotations

from .link import world
from .thruster_writer import ThrusterWriterData, ThrusterWriterMethods


class Methods(ThrusterWriterMethods):
    """The methods of ThrusterWriter."""

    def send_message(self, data: ThrusterWriterData, value: int) -> None:
        """Send the torque."""
        world.send(value)
