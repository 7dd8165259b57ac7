"""What a generated program runs on: tasks, synchronous channels, clocks and recorders. Standard library only.

>>> from codegen.runtime import Channel, Integers, Program, Task
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

from codegen.runtime.alternation import Choice, Fair, InOrder, NobodyDecides, Policy, Randomly
from codegen.runtime.channel import ANY, UNDECIDED, Channel, Offer, WrongOffer, one_of
from codegen.runtime.clock import Clock, MonotonicClock, VirtualClock
from codegen.runtime.command import command
from codegen.runtime.data import (
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
from codegen.runtime.operation import CannotList, ClassTask, Data, Operation, Outcome, Outcomes
from codegen.runtime.program import Program, Runner, Summary
from codegen.runtime.recorder import JsonLines, Memory, Record, Recorder, Several
from codegen.runtime.task import Next, Stopped, Task, go
from codegen.runtime.waiting import Deadlock, Waiting

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
