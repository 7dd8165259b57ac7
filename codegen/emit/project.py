"""The files of a program, as texts."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from cspcheck.codegen import quoting, runtime
from cspcheck.codegen.design.model import Design, MethodDesign, TaskDesign
from cspcheck.codegen.design.naming import camel
from cspcheck.codegen.design.timing import TaskTiming

WIDTH = 120
RUNTIME = "runtime"
"""The folder of the runtime in a program."""


@dataclass(frozen=True)
class ProjectFiles:
    """The texts by file name: ``generated`` are written each time, ``yours`` once.

    ``interfaces`` says for each file of ``yours`` which methods its class must have, with their signatures.
    """

    generated: dict[str, str]
    yours: dict[str, str]
    interfaces: dict[str, dict[str, str]]


def _quoted(value: object) -> object:
    """What a template writes, if it went through a function of ``codegen.quoting``.

    Raises:
        Unquoted: it did not.
    """
    if isinstance(value, quoting.Code):
        return value
    raise quoting.Unquoted(f"{value!r} reaches a template unquoted")


@cache
def environment() -> Any:
    """The templates, which take quoted values only."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader("cspcheck.codegen", "templates"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
        finalize=_quoted,
    )
    quotes = ("code", "literal", "literals", "markdown", "name", "names", "phrase", "project_name", "prose", "shell")
    made.filters.update({name: getattr(quoting, name) for name in quotes})
    made.filters["joined"] = lambda texts: quoting.code(", ".join(texts))
    made.filters["indented"] = lambda line, width: quoting.code(f"{' ' * width}{line}" if line else "")
    return made


@cache
def runtime_files() -> Mapping[str, str]:
    """The runtime, which goes with every program: its modules by their names in the program's folder."""
    files = resources.files(runtime)
    names = sorted(file.name for file in files.iterdir() if file.name.endswith(".py"))
    return {f"{RUNTIME}/{name}": files.joinpath(name).read_text(encoding="utf-8") for name in names}


def project(design: Design, folder: str) -> ProjectFiles:
    """The program of a design, to be put into *folder*."""
    return _Writer(design, os.path.basename(os.path.abspath(folder)) or "program").project()


class _Writer:
    def __init__(self, design: Design, folder: str) -> None:
        self.design = design
        self.folder = folder

    def project(self) -> ProjectFiles:
        generated = {"__init__.py": self._render("init.py.j2"), "data_types.py": self._data_types()}
        generated["channels.py"] = self._channels()
        if self.design.functions:
            generated["functions.py"] = self._functions()
        yours: dict[str, str] = {}
        interfaces: dict[str, dict[str, str]] = {}
        for task in self.design.tasks:
            generated[f"{task.module}.py"] = self._task(task)
            if task.methods:
                name = f"{task.module}_methods.py"
                yours[name] = self._methods(task)
                interfaces[name] = {method.name: method.signature for method in task.methods}
        generated["main.py"] = self._main()
        generated["pyproject.toml"] = self._render("pyproject.toml.j2")
        generated["README.md"] = self._render("README.md.j2", yours=yours, remark=self._remark)
        return ProjectFiles(
            {name: _tidy(text) for name, text in generated.items()} | dict(runtime_files()),
            {name: _tidy(text) for name, text in yours.items()},
            interfaces,
        )

    def _render(self, template: str, **values: Any) -> str:
        script_name = os.path.basename(self.design.script)
        made = environment().get_template(template)
        text: str = made.render(design=self.design, script_name=script_name, folder=self.folder, **values)
        return text

    def _imports(
        self, *, data: Sequence[str] = (), runtime: Sequence[str] = (), modules: Sequence[str] = ()
    ) -> list[str]:
        """Imports from the modules of the program, as sorted imports stand."""
        rows = ((".", sorted(modules)), (".data_types", data), (".runtime", runtime))
        return [_import(module, names) for module, names in rows if names]

    def _data_types(self) -> str:
        data = self.design.data
        definitions = [f"\n\n{text}\n\n" if text.startswith("class ") else wrapped(text) for text in data.definitions]
        text = "\n".join(data.definitions)
        return self._render(
            "data_types.py.j2",
            definitions=definitions,
            uses_enum="(Enum)" in text,
            uses_final="Final" in text,
            runtime=used(text, runtime.__all__),
        )

    def _constants(self) -> list[str]:
        """What ``data_types`` defines."""
        return [re.match(r"(?:class )?(\w+)", text)[1] for text in self.design.data.definitions]  # type: ignore[index]

    def _channels(self) -> str:
        text = " ".join(
            [*[t for c in self.design.channels for t in c.types], *[c.parties for c in self.design.channels]]
        )
        return self._render(
            "channels.py.j2", runtime=used(f"{text} Channel", runtime.__all__), data=used(text, self._constants())
        )

    def _functions(self) -> str:
        text = "\n".join(self.design.functions)
        return self._render(
            "functions.py.j2",
            runtime=used(text, runtime.__all__),
            data=used(text, self._constants()),
            uses_any=bool(used(text, ["Any"])),
        )

    def _machine(self, task: TaskDesign) -> str:
        notes = [note for m in task.methods for note in (m.annotation, *[n for _, n in m.parameters])]
        text = "\n".join([*(task.table or ()), *notes])
        names = [*used(text, runtime.__all__), "MachineTask", "Row", *(["Channel"] if task.ports else [])]
        names += ["UNDECIDED"] if any(method.returns for method in task.methods) else []
        settings = _settings(task.timing)
        if task.timing.at is not None:
            settings += f", timed={quoting.literal(task.ports[task.timing.at][0])}"
        if task.clocked:
            settings += f", clocked=({quoting.literals(task.clocked)}), unit={self.design.tock}"
        return self._render(
            "machine.py.j2",
            task=task,
            methods_class=_methods_class(task),
            method_text=_method_text,
            imports=self._imports(
                data=used(text, self._constants()),
                runtime=sorted(set(names), key=_order),
                modules=["channels"] if task.ports else [],
            ),
            typing=[*used("\n".join(notes), ["Any"]), "ClassVar"],
            timing=settings,
        )

    def _task(self, task: TaskDesign) -> str:
        if task.table is not None:
            return self._machine(task)
        lines = [line for state in [*([task.loop] if task.loop else []), *task.states] for line in state.lines]
        annotations = [note for state in task.states for _, note in state.parameters]
        annotations += [note for _, note in task.parameters]
        annotations += [note for m in task.methods for note in (m.annotation, *[n for _, n in m.parameters])]
        text = "\n".join([*lines, *annotations])
        part = task.of_class
        if part is not None:
            text = "\n".join([text, *part.design.lines, *[f"{t} {n}" for _, t, n in part.design.variables]])
        names = [*used(text, runtime.__all__), "Task" if part is None else "ClassTask", "Channel"]
        if part is not None:
            names += ["Data", "DataType", "Operation", "Outcome", "Outcomes"]
            names = [name for name in names if name not in ("Outcome", "Outcomes") or name in text]
        if task.states:
            names.append("Next")
        if any(method.returns for method in task.methods):
            names.append("UNDECIDED")
        modules = [*(["channels"] if task.ports else []), *(["functions"] if uses_module(text, "functions") else [])]
        return self._render(
            "task.py.j2",
            task=task,
            methods_class=_methods_class(task),
            method_text=_method_text,
            imports=self._imports(
                data=used(text, self._constants()),
                runtime=sorted(set(names) - ({"Channel"} if not task.ports else set()), key=_order),
                modules=modules,
            ),
            typing=[*(["Any"] if used(text, ["Any"]) else []), *(["ClassVar"] if part is not None else [])],
            part=part,
            timing=_settings(task.timing),
            what="For ever." if task.loop else f"As the states have it, from `{task.start}` on.",
        )

    def _methods(self, task: TaskDesign) -> str:
        notes = " ".join(note for m in task.methods for note in (m.annotation, *[n for _, n in m.parameters]))
        imported = sorted([*([task.of_class.data_class] if task.of_class else []), _methods_class(task)])
        lines = self._imports(data=used(notes, self._constants()), runtime=used(notes, ["Tagged"]))
        return self._render(
            "methods.py.j2",
            task=task,
            methods_class=_methods_class(task),
            typing=used(notes, ["Any"]),
            imports=sorted([*lines, f"from .{task.module} import {', '.join(imported)}"], key=_module),
            method_text=_method_text,
            wanted=lambda method: _wanted(method, task.of_class is not None),
            call=lambda method: f"{method.name}({', '.join(name for name, _ in method.parameters)})",
        )

    def _main(self) -> str:
        tasks: list[str] = []
        for task in self.design.tasks:
            for one in task.instances:
                arguments = [str(quoting.literal(one.name))]
                if task.methods:
                    arguments.append(f"{task.module}_methods.Methods()")
                arguments += [_qualified(text, self._constants()) for text in one.arguments]
                arguments += [f"{attribute}=channels.{constant}" for attribute, constant in one.ports.items()]
                tasks.append(f"{task.class_name}({', '.join(arguments)})")
        text = "\n".join(tasks)
        modules = [name for name in ("channels", "data_types") if uses_module(text, name)]
        modules += [f"{task.module}_methods" for task in self.design.tasks if task.methods]
        lines = [f"from .{task.module} import {task.class_name}" for task in self.design.tasks]
        names = sorted(["Task", "command", *used(text, ["Tagged"])], key=_order)
        imports = sorted([*self._imports(modules=modules, runtime=names), *lines], key=_module)
        return self._render("main.py.j2", tasks=tasks, imports=imports)

    def _remark(self, task: TaskDesign) -> str:
        timing = task.timing
        parts = []
        if timing.period is not None:
            parts.append(f"every {timing.period} s, at {quoting.markdown(timing.at or '')}")
        if timing.priority:
            parts.append(f"priority {timing.priority}")
        return ", ".join(parts)


def _import(module: str, names: Sequence[str]) -> str:
    """An import of some names, a name a line if they are many."""
    line = f"from {module} import {', '.join(names)}"
    if len(line) <= WIDTH:
        return line
    return "\n".join([f"from {module} import (", *[f"    {name}," for name in names], ")"])


def _module(line: str) -> tuple[bool, str]:
    """What imports are sorted by: the module, the package itself first."""
    module = line.split()[1]
    return (module != ".", module)


_TEXTS = re.compile(r'"""(?:[^\\]|\\.)*?"""|"(?:[^"\\\n]|\\.)*"', re.DOTALL)
"""The texts among what the generator made of Python."""


def uses_module(text: str, name: str) -> bool:
    """Whether lines of Python use something of a module."""
    return re.search(rf"(?<![.\w]){name}\.", _TEXTS.sub('""', text)) is not None


def used(text: str, names: Iterable[str]) -> list[str]:
    """Those of *names* that occur in lines of Python as words, in the order of an import."""
    words = set(re.findall(r"(?<![.\w])[^\W\d]\w*", _TEXTS.sub('""', text)))
    return sorted({name for name in names if name in words}, key=_order)


def _order(name: str) -> tuple[int, str]:
    """Constants, classes, functions: the order in which sorted imports stand."""
    if name.isupper() and len(name) > 1:
        return (0, name)
    return (1, name) if name[0].isupper() else (2, name)


def wrapped(statement: str) -> str:
    """A long assignment of a display, an item a line."""
    if len(statement) <= WIDTH or not statement.endswith(")"):
        return statement
    head, _, rest = statement.partition("(")
    return f"{head}(\n    {rest[:-1]}\n)"


def _settings(timing: TaskTiming) -> str:
    """The arguments that say how a task is run."""
    settings = ""
    if timing.priority:
        settings += f", priority={timing.priority}"
    if timing.period is not None:
        settings += f", period={timing.period}"
    if timing.offset:
        settings += f", offset={timing.offset}"
    return settings


def _methods_class(task: TaskDesign) -> str:
    return f"{camel(task.definition)}Methods"


def _wanted(method: MethodDesign, of_class: bool) -> str:
    if of_class:
        return " and ".join(f"`{name}`" for name, _ in method.returns) + (" afterwards" if method.afterwards else "")
    return " and ".join(f"a value of {_plain(text)}" for text, _ in method.returns)


def _method_text(method: MethodDesign) -> str:
    if method.about is not None or (method.parameters and method.parameters[0][0] == "data"):
        what = f": {method.about}" if method.about else ""
        after = " afterwards" if method.afterwards else ""
        gives = f"; gives {', '.join(f'`{name}`' for name, _ in method.returns)}{after}" if method.returns else ""
        return f"`{method.channel}`{what}{gives}."
    fields = "".join(f", with `{name}`" for name, _ in method.parameters)
    gives = "; gives " + " and ".join(f"a value of {_plain(t)}" for t, _ in method.returns) if method.returns else ""
    return f"`{method.channel}`{fields}{gives}."


def _plain(text: str) -> str:
    match = re.fullmatch(r"Integers\((-?\d+), (-?\d+)\)", text)
    return f"{match[1]}..{match[2]}" if match else text


def _qualified(text: str, constants: Sequence[str]) -> str:
    """An expression with the constants of ``data_types`` by their full names; its texts stay as they are."""
    known = set(constants)

    def full(match: re.Match[str]) -> str:
        return f"data_types.{match[0]}" if match[0] in known else match[0]

    word = re.compile(r"(?<![.\w])[^\W\d]\w*")
    pieces, texts = _TEXTS.split(text), _TEXTS.findall(text)
    return "".join(word.sub(full, piece) + quoted for piece, quoted in zip(pieces, [*texts, ""], strict=True))


def _tidy(text: str) -> str:
    """No blanks at the ends of lines, at most two empty lines, one line break at the end."""
    lines = [line.rstrip() for line in text.split("\n")]
    return re.sub(r"\n{4,}", "\n\n\n", "\n".join(lines)).strip("\n") + "\n"
