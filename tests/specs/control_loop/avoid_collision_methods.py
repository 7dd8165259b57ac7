"""What AvoidCollision does by itself: it looks at the sonars."""

from __future__ import annotations

from .avoid_collision import AvoidCollisionData, AvoidCollisionMethods
from .data_types import STATUS
from .link import world


class Methods(AvoidCollisionMethods):
    """The methods of AvoidCollision."""

    def get_sonar_readings(self, data: AvoidCollisionData) -> STATUS:
        """Whether an obstacle is near."""
        return STATUS.alert if world.near else STATUS.normal
