"""The design of a program as values: channels, tasks and their instances, methods, data."""

from __future__ import annotations

from dataclasses import dataclass, field

from cspcheck.codegen.design.classes import ClassDesign
from cspcheck.codegen.design.data import DataDesigner
from cspcheck.codegen.design.pieces import StateMethod
from cspcheck.codegen.design.timing import TaskTiming


@dataclass
class ChannelDesign:
    """A channel of the program: ``parties`` is the text of its parties, ``tasks`` who offers it."""

    name: str
    constant: str
    types: list[str]
    parties: str
    never: list[str]
    hidden: bool
    inner: bool = False
    members: tuple[str, ...] = ()
    """The tasks that can take part."""
    rank: int | None = None


@dataclass
class Instance:
    """A task: its name, its arguments, and the channels that it has other than by their own names."""

    name: str
    variable: str
    arguments: list[str]
    ports: dict[str, str]


@dataclass
class TaskDesign:
    """A module: one definition of the script that runs as one or more tasks.

    ``states`` is empty where the task is a loop, ``loop`` None where it is states; ``start`` is the first state with
    its values.
    """

    definition: str
    module: str
    class_name: str
    text: str
    parameters: list[tuple[str, str]]
    loop: StateMethod | None
    states: list[StateMethod]
    start: str
    methods: list[MethodDesign]
    ports: dict[str, tuple[str, str | None]]
    """For each channel the attribute of the task, and the constant that it is unless another is given."""
    timing: TaskTiming
    instances: list[Instance] = field(default_factory=list)
    from_data: set[str] = field(default_factory=set)
    functions: set[str] = field(default_factory=set)
    of_class: ClassPart | None = None
    table: list[str] | None = None
    """The rows of its machine, if the task is one."""
    why: str = ""
    """Why it is one."""
    clocked: tuple[str, ...] = ()
    """The attributes of the channels that count time, for a machine."""


@dataclass(frozen=True)
class ClassPart:
    """What the task of a class has beside that of a process: its data, and an operation for each channel."""

    data_class: str
    design: ClassDesign
    operations: tuple[tuple[str, str], ...]
    """Attributes of the task with the arguments of their ``Operation``."""


@dataclass(frozen=True)
class MethodDesign:
    """A method to be written by hand."""

    name: str
    channel: str
    parameters: tuple[tuple[str, str], ...]
    returns: tuple[tuple[str, str], ...]
    """Type constants (or names of variables) with annotations of what it gives."""
    about: str | None = None
    """What there is to be said of it, beside its name."""
    afterwards: bool = False
    """Whether what it gives are after-values."""

    @property
    def annotation(self) -> str:
        """What it returns."""
        if not self.returns:
            return "None"
        if len(self.returns) == 1:
            return self.returns[0][1]
        return f"tuple[{', '.join(annotation for _, annotation in self.returns)}]"

    @property
    def signature(self) -> str:
        """Its head, without ``def``."""
        parameters = "".join(f", {name}: {annotation}" for name, annotation in self.parameters)
        return f"{self.name}(self{parameters}) -> {self.annotation}"


@dataclass
class Design:
    """A program."""

    script: str
    process: str
    data: DataDesigner
    channels: list[ChannelDesign]
    tasks: list[TaskDesign]
    functions: list[str]
    functions_from_data: set[str]
    tock: float | None = None
    """How many seconds an event of `tock` stands for, if there is one."""
