"""What classes become in the tree of a script: expressions of CSPm that only the Object-Z part can make.

They stand in ordinary declarations (:mod:`cspcheck.cspm.oz.processes.desugaring`), so that names, types and
evaluation treat what a class brings like everything else in the script.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from cspcheck.cspm.oz import core
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.tree import ModuleDeclaration, Name

if TYPE_CHECKING:
    from cspcheck.cspm.oz.processes.context import ClassContext

WIDE = "%"
"""Behind the name of a given set without a reading: the datatype that its elements would be of."""
OBJECTS = "%objects"
"""Behind the name of a class: the datatype that its objects are of."""


def given_name(datatype: str) -> str:
    """The given or free type whose datatype has a name."""
    return datatype.removesuffix(OBJECTS).removesuffix(WIDE)


@dataclass(frozen=True, kw_only=True)
class ClassExpression(syntax.Foreign):
    """An expression whose value comes from the Object-Z part.

    ``owner`` is the class whose constants it may use, None for none. ``datatypes`` name the datatypes that its values
    may be of, so that they are known before it.
    """

    context: ClassContext = field(compare=False, repr=False)
    owner: str | None = None
    datatypes: tuple[Name, ...] = ()

    @property
    def names(self) -> tuple[Name, ...]:
        """The names of the script that its value depends on."""
        return self.datatypes


@dataclass(frozen=True, kw_only=True)
class CarrierSet(ClassExpression):
    """The values of some carriers of one type, as far as the finite readings go, or an infinite set."""

    carriers: tuple[core.Term, ...] = field(compare=False, repr=False)
    element: core.Type


@dataclass(frozen=True, kw_only=True)
class ConstantValue(ClassExpression):
    """A constant that axioms determine."""

    name: str
    type: core.Type


@dataclass(frozen=True, kw_only=True)
class ClassProcess(ClassExpression):
    """The process of a class with its methods visible.

    ``channels`` are all its channels and methods, ``mains`` the ``main`` of each of its process parts; ``done`` is
    the private event by which its data part agrees to terminate. ``wider`` are the channels without schema that may
    carry more than the class declares for them. ``kept`` are, for each channel, the positions of the parameters that
    are fields of its events.
    """

    model: core.ClassModel = field(compare=False, repr=False)
    channels: tuple[Name, ...]
    mains: tuple[Name, ...]
    done: Name
    wider: tuple[str, ...] = ()
    kept: Mapping[str, Sequence[int]] = field(compare=False, repr=False)

    @property
    def names(self) -> tuple[Name, ...]:
        """The names of the script that its value depends on."""
        return (*self.datatypes, *self.channels, *self.mains, self.done)


@dataclass(frozen=True, kw_only=True)
class ClassModule(ModuleDeclaration):
    """The members of a class: ``C::push`` is a method of C, ``C::visible`` its process with the methods visible
    (``C::visible'`` where the class has a member ``visible`` of its own).

    The name of the class itself is that of its process; the module is found only behind it.
    """

    @property
    def key(self) -> str:
        """What it is called in the scope around it: something that no script can write."""
        return f"{self.name}%"
