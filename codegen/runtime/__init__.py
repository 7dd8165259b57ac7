"""What a generated program runs on: tasks, synchronous channels, clocks and recorders. Standard library only.

These modules go with every program as they are, so they import each other and nothing else of this project.

>>> from program.runtime import Channel, Integers, Program, Task
>>> number = Channel("number", [Integers(0, 10)], parties=[("Producer", "Consumer")])
>>> class Producer(Task):
...     async def run(self):
...         for i in range(11):
...             await self.perform(number.put(i))
>>> class Consumer(Task):
...     async def run(self):
...         for _ in range(11):
...             (i,) = await self.perform(number.get())
>>> Program([Producer("Producer"), Consumer("Consumer")]).run().events
11
"""

from .alternation import Choice, Fair, InOrder, NobodyDecides, Policy, Randomly
from .channel import ANY, UNDECIDED, Channel, Offer, WrongOffer, one_of
from .clock import Clock, MonotonicClock, VirtualClock
from .command import command
from .data import (
    BOOLEANS,
    Anything,
    Constructed,
    DataType,
    Integers,
    Members,
    OutOfRange,
    Reals,
    Sequences,
    Sets,
    Tagged,
    Tuples,
    Variables,
)
from .machine import MachineTask, Move, Row
from .operation import CannotList, ClassTask, Data, Operation, Outcome, Outcomes
from .program import Program, Runner, Summary
from .recorder import JsonLines, Memory, Nothing, Record, Recorder, Several
from .task import Next, Stopped, Task, WrongMethods, go
from .waiting import Deadlock, Waiting

__all__ = [
    "ANY",
    "BOOLEANS",
    "UNDECIDED",
    "Anything",
    "CannotList",
    "Channel",
    "Choice",
    "ClassTask",
    "Clock",
    "Constructed",
    "Data",
    "DataType",
    "Deadlock",
    "Fair",
    "InOrder",
    "Integers",
    "JsonLines",
    "MachineTask",
    "Members",
    "Memory",
    "MonotonicClock",
    "Move",
    "Next",
    "NobodyDecides",
    "Nothing",
    "Offer",
    "Operation",
    "OutOfRange",
    "Outcome",
    "Outcomes",
    "Policy",
    "Program",
    "Randomly",
    "Reals",
    "Record",
    "Recorder",
    "Row",
    "Runner",
    "Sequences",
    "Sets",
    "Several",
    "Stopped",
    "Summary",
    "Tagged",
    "Task",
    "Tuples",
    "Variables",
    "VirtualClock",
    "Waiting",
    "WrongMethods",
    "WrongOffer",
    "command",
    "go",
    "one_of",
]
