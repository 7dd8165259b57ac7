"""What a generated program runs on: tasks, synchronous channels, clocks and recorders. Standard library only.

>>> from cspcheck.codegen.runtime import Channel, Integers, Program, Task
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

from cspcheck.codegen.runtime.alternation import Choice, Fair, InOrder, NobodyDecides, Policy, Randomly
from cspcheck.codegen.runtime.channel import ANY, UNDECIDED, Channel, Offer, WrongOffer, one_of
from cspcheck.codegen.runtime.clock import Clock, MonotonicClock, VirtualClock
from cspcheck.codegen.runtime.command import command
from cspcheck.codegen.runtime.data import (
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
from cspcheck.codegen.runtime.operation import CannotList, ClassTask, Data, Operation, Outcome, Outcomes
from cspcheck.codegen.runtime.program import Program, Runner, Summary
from cspcheck.codegen.runtime.recorder import JsonLines, Memory, Record, Recorder, Several
from cspcheck.codegen.runtime.task import Next, Stopped, Task, go
from cspcheck.codegen.runtime.waiting import Deadlock, Waiting

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
    "Members",
    "Memory",
    "MonotonicClock",
    "Next",
    "NobodyDecides",
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
    "WrongOffer",
    "command",
    "go",
    "one_of",
]
