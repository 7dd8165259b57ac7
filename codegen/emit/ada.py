"""A program in Ada 2012 under Ravenscar: a package a process, a protected object a channel, data with contracts."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from functools import cache
from importlib import resources

from cspcheck.codegen import messages, targets
from cspcheck.codegen.design.links import Link, links
from cspcheck.codegen.design.system import System, SystemState
from cspcheck.codegen.emit.ada_data import PROGRAM_DATA, AdaBeside, AdaClass, AdaData
from cspcheck.codegen.emit.ada_methods import METHODS_TABLE, AdaMethods, filled, tidy
from cspcheck.codegen.emit.ada_terms import NoCounterpart
from cspcheck.codegen.emit.project import ProjectFiles
from cspcheck.codegen.quoting import ada_name, ada_text, c_comment, markdown, shell
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.script import Script

MOST_TASKS = 64
"""A group of tasks is a word of so many bits."""


_RESERVED = (
    *("ada", "gnat", "interfaces", "standard", "system"),
    *("csp", "host", "links", "log", "main", "methods", "methods_table", "names", "patience", "processes"),
    *(
        "program_data",
        "data_types",
        "recorder",
        "tables",
        "state",
        "ending",
        "word",
        "bit",
        "integer",
        "natural",
        "positive",
        "boolean",
    ),
)
"""Library units of every program, of the language, and what they declare that is seen everywhere."""


@cache
def runtime_files() -> dict[str, str]:
    """The runtime, which goes with every program."""
    folder = resources.files(targets) / "ada"
    found = {file.name: file.read_text(encoding="utf-8") for file in folder.iterdir() if file.is_file()}
    desk = folder / "desk"
    return found | {f"desk/{file.name}": file.read_text(encoding="utf-8") for file in desk.iterdir() if file.is_file()}


def project(system: System, folder: str, script: Script) -> ProjectFiles:
    """The program of a system of a script, to be put into *folder*.

    Raises:
        ScriptError: it has more tasks than fit.
    """
    if len(system.tasks) > MOST_TASKS:
        raise ScriptError(messages.too_large(system.process, "tasks", MOST_TASKS, None))
    return _Writer(system, os.path.basename(os.path.abspath(folder)) or "program", script).project()


class _Writer:
    def __init__(self, system: System, folder: str, script: Script) -> None:
        self.system = system
        self.folder = folder
        self.taken: set[str] = set(_RESERVED)
        self.links = links(system)
        self.packages = {definition: self._unique(ada_name(definition)) for definition in self._definitions()}
        self.data = AdaData(script, self._unique)
        self.classes: dict[str, AdaClass] = {}
        self.reasons: dict[str, str] = {}
        for definition in self.packages:
            self._class(definition)
        self.methods = AdaMethods(system, self._unique)

    def _definitions(self) -> list[str]:
        return list(dict.fromkeys(task.definition for task in self.system.tasks))

    def _class(self, definition: str) -> None:
        """The data of a class, or the reason why it stays in the states of its tasks."""
        model = self.data.model(definition)
        if model is None:
            return
        machines = [self.system.machines[task.machine] for task in self.system.tasks if task.definition == definition]
        events = {event for one in machines for state in one.states for event, _ in state.moves}
        offered = {self.system.channels[self.system.events[event].channel].name for event in events}
        known = {c.name if c.kind == "chan" else f"{definition}::{c.name}" for c in model.channels.values()}
        try:
            if any(len(state.ways) > 1 or _forks(state.moves) for one in machines for state in one.states):
                raise NoCounterpart("an operation that leaves something open")
            if not offered <= known:
                raise NoCounterpart("channels by other names")
            self.classes[definition] = self.data.design(model)
        except NoCounterpart as reason:
            self.reasons[definition] = str(reason)

    def project(self) -> ProjectFiles:
        """All files."""
        beside = AdaBeside(self.system, self.classes, bool(self.data.types))
        generated = {
            "tables.ads": self._tables(),
            "names.ads": _NAMES,
            "names.adb": self._names(),
            "links.ads": self._links(),
            "links.adb": self._link_bodies(),
            "methods_table.ads": METHODS_TABLE,
            "methods_table.adb": self.methods.table(),
            "program_data.ads": PROGRAM_DATA,
            "program_data.adb": beside.body(),
            "processes.ads": self._processes(),
            "README.md": self._readme(),
        }
        for definition, package in self.packages.items():
            generated[f"{package.lower()}.ads"] = self._package(definition, package)
        if self.data.types:
            generated["data_types.ads"] = _DATA_TYPES.format("\n".join(self.data.types))
        for one in self.classes.values():
            generated[f"{one.package.lower()}.ads"] = one.spec
            generated[f"{one.package.lower()}.adb"] = one.body
        yours = {}
        if self.methods.names:
            generated["methods.ads"] = self.methods.declarations()
            yours["methods.adb"] = self.methods.bodies()
        generated = {name: tidy(text) if name.endswith((".ads", ".adb")) else text for name, text in generated.items()}
        return ProjectFiles(generated | runtime_files(), {name: tidy(text) for name, text in yours.items()}, {})

    def _unique(self, name: str) -> str:
        """A name that no other has, whatever its capitals."""
        candidate, count = name, 2
        while candidate.lower() in self.taken:
            candidate, count = f"{name}_{count}", count + 1
        self.taken.add(candidate.lower())
        return candidate

    # --- tables ----------------------------------------------------------------------------------------------

    def _tables(self) -> str:
        system = self.system
        states: list[str] = []
        moves: list[str] = ["(0, 0)"]  # numbered from 1: 0 says that there is none
        ways: list[str] = []
        firsts: list[int] = []
        # Tasks of one machine may play different parts: each has its states.
        parts: dict[tuple[int, tuple[tuple[str, int], ...]], int] = {}
        for number, task in enumerate(system.tasks):
            modes = tuple(self._mode(number, state) for state in system.machines[task.machine].states)
            if (task.machine, modes) not in parts:
                parts[task.machine, modes] = len(states)
                for state, (mode, link) in zip(system.machines[task.machine].states, modes, strict=True):
                    row = f"{len(moves)}, {len(state.moves)}, {len(state.ways)}, {len(ways)}"
                    states.append(f"({row}, {mode}, {link})")
                    moves += [f"({event}, {target})" for event, target in state.moves]
                    ways += [str(way) for way in state.ways]
            firsts.append(parts[task.machine, modes])
        members: list[str] = []
        places: dict[tuple[frozenset[int], ...], int] = {}
        groups = []
        for event in system.events:
            if event.groups not in places:
                places[event.groups] = len(members)
                members += [f"16#{sum(1 << task for task in group):X}#" for group in event.groups]
            groups.append(f"({places[event.groups]}, {len(event.groups)})")
        channels = [f"({channel.rank}, {channel.clocked})" for channel in system.channels]
        tasks = []
        for number, task in enumerate(system.tasks):
            period, offset = round((task.timing.period or 0) * 1000), round(task.timing.offset * 1000)
            timed = -1 if task.timed is None else task.timed
            tasks.append(f"({firsts[number]}, {task.start}, {period}, {offset}, {timed})")
        head = _TABLES.replace("@PROCESS@", c_comment(system.process))
        counts = {
            "@TASKS@": len(system.tasks), "@EVENTS@": len(system.events), "@CHANNELS@": len(system.channels),
            "@TOCK@": round(system.tock * 1000),
        }  # fmt: skip
        for mark, count in counts.items():
            head = head.replace(mark, str(count))
        texts = [head]
        for name, kind, items in (
            ("States", "State_Record", states),
            ("Moves", "Move_Record", moves),
            ("Ways", "State_Index", ways or ["0"]),
            ("Members", "Unsigned_64", members),
            ("Groups", "Group_Record", groups),
            ("Channels", "Channel_Record", channels),
            ("Channel_Of", "Channel_Index", [str(event.channel) for event in system.events]),
            ("Tasks", "Task_Record", tasks),
        ):
            rows = [f"{i} => {item}{',' if i + 1 < len(items) else ''}" for i, item in enumerate(items)]
            head = f"   {name} : constant array (0 .. {len(items) - 1}) of {kind} :="
            texts.append(f"{head}\n     ({filled(rows)});\n")
        return "\n".join([*texts, "end Tables;", ""])

    def _mode(self, task: int, state: SystemState) -> tuple[str, int]:
        """How a task in a state comes to its next event, and by which link."""
        if state.ends:
            return ("Ends", 0)
        channels = {self.system.events[event].channel for event, _ in state.moves}
        for number, link in enumerate(self.links):
            if channels and channels <= set(link.channels):
                return ("Receives" if task == link.receiver else "Sends", number)
        return ("Meets", 0)

    def _names(self) -> str:
        lines = ["--  Generated by cspcheck gen: do not edit.", "package body Names is", ""]
        lines += ["   function Line (Event : Event_Index) return String is", "     (case Event is"]
        rows = []
        for i, event in enumerate(self.system.events):
            channel = self.system.channels[event.channel]
            row: dict[str, object] = {"event": event.name}
            if channel.hidden:
                row["hidden"] = True
            if channel.inner:
                row["inner"] = True
            rows.append(f"         when {i} => {ada_text(json.dumps(row))}")
        return "\n".join([*lines, ",\n".join(rows) + ");", "", "end Names;", ""])

    def _processes(self) -> str:
        lines = ["--  All processes. Generated by cspcheck gen: do not edit."]
        for package in self.packages.values():
            lines += [f"with {package};", f"pragma Unreferenced ({package});"]
        return "\n".join([*lines, "", "package Processes is", "", "end Processes;", ""])

    def _package(self, definition: str, package: str) -> str:
        """A process: its text, and its tasks."""
        tasks = [(number, task) for number, task in enumerate(self.system.tasks) if task.definition == definition]
        text = self.system.machines[tasks[0][1].machine].text
        lines = [f"--  {c_comment(line)}" for line in text.splitlines() if line.strip()]
        if definition in self.classes:
            lines += ["--", f"--  Its data is in {self.classes[definition].package}."]
        elif definition in self.reasons:
            lines += [
                "--",
                f"--  Its data is in its states: there are no contracts for {c_comment(self.reasons[definition])}.",
            ]
        lines += ["--", "--  Generated by cspcheck gen: do not edit.", "", "with CSP;", "", f"package {package} is", ""]
        for number, task in tasks:
            name = f"{package}_Task" if len(tasks) == 1 else f"{package}_Task_{number}"
            urgency = 1 + max(0, task.timing.priority)
            lines.append(f"   --  {c_comment(task.name)}")
            lines.append(f"   {name} : CSP.Carrier (Index => {number}, Urgency => {urgency});")
            lines.append("")
        return "\n".join([*lines, f"end {package};", ""])

    # --- links -----------------------------------------------------------------------------------------------

    def _link_name(self, link: Link) -> str:
        names = [ada_name(self.system.channels[channel].label.rpartition("::")[2]) for channel in link.channels]
        return f"{'_'.join(names)[:60].rstrip('_')}_{self.links.index(link)}"

    def _links(self) -> str:
        lines = [
            "--  Channels with a slot for each sender. Generated by cspcheck gen: do not edit.",
            "with Tables; use Tables;",
            *(["with CSP;"] if self.links else []),
            "",
            "package Links is",
            "",
        ]
        for link in self.links:
            senders = ", ".join(self.system.tasks[task].name for task in link.senders)
            lines += [
                f"   --  from {c_comment(senders)} to {c_comment(self.system.tasks[link.receiver].name)}",
                f"   {self._link_name(link)} : CSP.Link (Senders => {len(link.senders)}, Receiver => {link.receiver});",
                "",
            ]
        return "\n".join(
            [
                *lines,
                *_LINK_HEADS,
                "end Links;",
                "",
            ]
        )

    def _link_bodies(self) -> str:
        lines = ["--  Generated by cspcheck gen: do not edit.", "package body Links is", ""]
        if not self.links:
            lines += ['   pragma Warnings (Off, "formal parameter * is not referenced");', ""]
        calls = {"Put": "Sender, Event", "Want": "Place, Found", "Get": "Event, Sender, Open"}
        for call, arguments in calls.items():
            lines += [f"   procedure {call} ({_LINK_PARAMETERS[call]}) is", "   begin", "      case Number is"]
            for number, link in enumerate(self.links):
                rest = arguments
                if call == "Put":
                    slots = [f"when {task} => {slot}" for slot, task in enumerate(link.senders[1:], 2)]
                    slot = f"(case Sender is {', '.join([*slots, 'when others => 1'])})" if slots else "1"
                    rest = f"{slot}, {arguments}"
                lines.append(f"         when {number} => {self._link_name(link)}.{call} ({rest});")
            lines += ["         when others => raise Program_Error;", "      end case;", f"   end {call};", ""]
        return "\n".join([*lines, "end Links;", ""])

    def _readme(self) -> str:
        script, process = os.path.basename(self.system.script), self.system.process
        data = [f"| {markdown(name)} | `{one.package.lower()}.ads` |" for name, one in self.classes.items()]
        data += [f"| {markdown(name)} | none: {markdown(reason)} |" for name, reason in self.reasons.items()]
        linked = [
            f"| {markdown(', '.join(self.system.channels[channel].label for channel in link.channels))} | "
            f"{markdown(', '.join(self.system.tasks[task].name for task in link.senders))} | "
            f"{markdown(self.system.tasks[link.receiver].name)} |"
            for link in self.links
        ]
        lines = [
            f"# {markdown(process)}",
            "",
            f"The program of {markdown(process)} of {markdown(script)} in Ada 2012, by `cspcheck gen`.",
            "",
            "```",
            "make host && ./host 10000 > run.jsonl",
            f"cspcheck trace {shell(script)} --process {shell(process)} run.jsonl",
            "make main    # under the Ravenscar profile, as for the target",
            "```",
            "",
            "Each process is a package with its task. `methods.adb` is yours: what the tasks do by themselves.",
            "`recorder.adb` is told every event; `desk/` keeps them in memory and prints them.",
            "",
        ]
        if linked:
            lines += ["Channels that are protected objects of their own, with a slot for each sender:", ""]
            lines += ["| channels | from | to |", "|---|---|---|", *linked, ""]
        if data:
            lines += ["Data with contracts:", "", "| class | package |", "|---|---|", *data, ""]
        return "\n".join(lines)


def _forks(moves: Sequence[tuple[int, int]]) -> bool:
    """Whether an event of a state leads to several."""
    return len({event for event, _ in moves}) < len(moves)


_TABLES = """--  The tables of @PROCESS@. Generated by cspcheck gen: do not edit.
with Interfaces; use Interfaces;

package Tables is

   pragma Style_Checks (Off);

   Task_Count : constant := @TASKS@;
   Tock_Ms    : constant := @TOCK@;

   subtype Task_Index is Natural range 0 .. Task_Count - 1;
   subtype Event_Index is Natural range 0 .. @EVENTS@ - 1;
   subtype Channel_Index is Natural range 0 .. @CHANNELS@ - 1;
   subtype State_Index is Natural;

   type Event_Array is array (Positive range <>) of Event_Index;
   type Task_Array is array (Positive range <>) of Task_Index;
   type Flag_Array is array (Positive range <>) of Boolean;

   --  How a task comes to its next event in a state
   type Mode_Kind is (Meets, Sends, Receives, Ends);

   type Move_Record is record
      Event : Event_Index;
      Next  : State_Index;
   end record;

   type State_Record is record
      First_Move : Natural;
      Moves      : Natural;
      Ways       : Natural;
      First_Way  : Natural;
      Mode       : Mode_Kind;
      Link       : Natural;
   end record;

   type Group_Record is record
      First : Natural;
      Count : Natural;
   end record;

   type Channel_Record is record
      Rank    : Natural;
      Clocked : Boolean;
   end record;

   type Task_Record is record
      First_State : Natural;
      Start       : State_Index;
      Period_Ms   : Natural;
      Offset_Ms   : Natural;
      Timed       : Integer;
   end record;
"""

_DATA_TYPES = """--  Types that several packages use. Generated by cspcheck gen: do not edit.
package Data_Types with Pure, SPARK_Mode is

{}

end Data_Types;
"""

_NAMES = """--  Generated by cspcheck gen: do not edit.
with Tables; use Tables;

package Names is

   --  An event as a recorded run has it
   function Line (Event : Event_Index) return String;

end Names;
"""

_LINK_PARAMETERS = {
    "Put": "Number : Natural; Sender : Task_Index; Event : Event_Index",
    "Want": "Number : Natural; Place : State_Index; Found : out Boolean",
    "Get": "Number : Natural; Event : out Event_Index; Sender : out Task_Index; Open : out Boolean",
}
_LINK_HEADS = [f"   procedure {name} ({parameters});\n" for name, parameters in _LINK_PARAMETERS.items()]
