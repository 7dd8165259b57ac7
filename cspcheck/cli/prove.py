"""``cspcheck prove FILE...``: the proof obligations of classes, one by one, and preconditions."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import click

from cspcheck.cli import finish
from cspcheck.cli.options import (
    DURATION,
    ConfiguredCommand,
    definitions,
    files_argument,
    manner_options,
    output_option,
    script_options,
)

if TYPE_CHECKING:
    from cspcheck.checker.proof.finding import Finding
    from cspcheck.cspm.oz import core
    from cspcheck.cspm.script import Script
    from cspcheck.report.prove import ProofListing

FORMATS = ("full", "json")


@click.command(cls=ConfiguredCommand, short_help="Prove the obligations of classes, or compute a precondition.")
@files_argument
@click.option("--class", "owner", metavar="CLASS", help="Only this class.")
@click.option("--obligation", metavar="NAME", help="Only this obligation, or this rule of refinement: `correctness`.")
@click.option("--operation", metavar="OP", help="Only this operation.")
@click.option("--precondition", metavar="OP", help="Say instead when this operation is possible.")
@click.option(
    "--timeout",
    type=DURATION,
    metavar="TIME",
    help="Give up an obligation after TIME.  [default: when the solver has worked for about 10 s]",
)
@click.option("--smtlib", metavar="FOLDER", type=click.Path(), help="Write every query of the solver to FOLDER.")
@click.option("--format", "form", type=click.Choice(FORMATS), default="full", show_default=True, help="Output form.")
@output_option
@script_options
@manner_options
def command(**options: Any) -> None:
    """Prove the obligations of every class of every script, and the refinements that the scripts assert.

    FILE is a script, a folder (the scripts below it), or `-` for standard input. Exit codes: 0 everything that counts
    is proved; 1 something is refuted; 3 something is not decided; 5 there is nothing to prove.
    """
    from cspcheck import checking
    from cspcheck.checker.proof.question import SolverSettings
    from cspcheck.cli.streams import output_to
    from cspcheck.report.prove import FullListing, ProofDocument
    from cspcheck.report.style import style_for
    from cspcheck.result import Exit
    from cspcheck.selection import EmptyFolder, targets

    smtlib: list[tuple[str, str]] | None = [] if options["smtlib"] is not None else None
    settings = SolverSettings(seconds=options["timeout"] or 10.0, limit=options["timeout"], smtlib=smtlib)
    settings.reasons = options["verbose"] > options["quiet"]
    loading = checking.Settings(definitions=definitions(options), include_roots=options["include_roots"])
    with output_to(options["output"]) as output:
        listing: ProofListing
        if options["form"] == "json":
            listing = ProofDocument(output.write)
        else:
            style = style_for(output.stream, options["color"])
            listing = FullListing(output.write, style, options["verbose"] - options["quiet"])
        for target in targets(options["files"]):
            if isinstance(target, EmptyFolder):
                continue
            script = checking.load(target.path, loading)
            if options["verbose"] >= options["quiet"]:
                _left_out(script, color=options["color"])
            if options["precondition"] is not None:
                _preconditions(script, options, settings, listing)
            else:
                listing.script(script.source.name)
                for finding in _findings(script, options, settings):
                    listing.finding(finding)
        code = listing.end(named=options["obligation"] not in (None, "obligations"))
    if smtlib is not None:
        _keep(options["smtlib"], smtlib)
    finish(int(Exit(code)))


def _left_out(script: Script, *, color: Any) -> None:
    """Say on standard error what of a document is typed alone, and why."""
    import sys

    from cspcheck.cspm.oz.objects.messages import NOT_RUN
    from cspcheck.report.diagnostics import render_diagnostics
    from cspcheck.report.style import style_for

    found = [warning for warning in script.warnings if warning.code == NOT_RUN]
    if found:
        sys.stderr.write(render_diagnostics(found, style_for(sys.stderr, color)))


def _classes(specification: core.Specification, options: dict[str, Any]) -> Iterator[core.ClassModel]:
    """The classes that are meant."""
    from cspcheck.checker.proof.answer import class_of, lemmas_alone, operation_of

    owner = options["owner"]
    if options["obligation"] == "lemma" or not (owner or specification.classes):
        yield from [class_of(specification, owner, None)] if owner else specification.classes.values()
        if specification.lemmas and not (owner or specification.classes):
            yield lemmas_alone()
        return
    wanted = options["operation"] or options["precondition"]
    models = [class_of(specification, owner, None)] if owner else list(specification.classes.values())
    if wanted and not owner:
        having = [model for model in models if wanted in model.operations]
        models = having or models[:1]
    for model in models:
        if wanted:
            operation_of(model, wanted, None)
        yield model


def _findings(script: Script, options: dict[str, Any], settings: Any) -> Iterator[Finding]:
    from cspcheck.checker.proof.answer import (
        obligation_names,
        operation_of,
        rule_of,
        specification_of,
        whole_refinement,
    )
    from cspcheck.checker.proof.obligations import discharge
    from cspcheck.checker.proof.prover import Prover

    specification = specification_of(script)
    rule = rule_of(options["obligation"])
    if rule is not None:
        # A rule of refinement: of all refinements that the script asserts, perhaps for one operation.
        for assertion in script.assertions:
            for finding in whole_refinement(assertion.node, specification, settings):
                if finding.obligation == rule and options["operation"] in (None, finding.operation):
                    yield finding
        return
    names = obligation_names(options["obligation"], None)
    for model in _classes(specification, options):
        operation = options["operation"]
        if operation and options["obligation"] != "lemma":
            operation = operation_of(model, operation, None).name
        yield from discharge(Prover(specification, model, settings), names, operation)
    if not (options["owner"] or options["operation"] or options["obligation"]):
        for assertion in script.assertions:
            yield from whole_refinement(assertion.node, specification, settings)


def _preconditions(script: Script, options: dict[str, Any], settings: Any, listing: ProofListing) -> None:
    from cspcheck.checker.proof.answer import operation_of, specification_of
    from cspcheck.checker.proof.precondition import precondition
    from cspcheck.checker.proof.prover import Prover

    specification = specification_of(script)
    for model in _classes(specification, options):
        operation = operation_of(model, options["precondition"], None)
        found = precondition(Prover(specification, model, settings), operation)
        listing.precondition(model.name, operation.name, found)


def _keep(folder: str, queries: Iterable[tuple[str, str]]) -> None:
    """Write the queries, a file each."""
    from cspcheck.cspm.diagnostics import ScriptError
    from cspcheck.messages import cannot_write

    try:
        os.makedirs(folder, exist_ok=True)
        for name, text in queries:
            with open(os.path.join(folder, f"{name}.smt2"), "w", encoding="utf-8") as file:
                file.write(text)
    except OSError as error:
        raise ScriptError(cannot_write(folder, error.strerror or str(error))) from None
