"""Random trees of the Object-Z part."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from fractions import Fraction

from hypothesis import strategies as st

from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.reading.operators import SPELLINGS
from cspcheck.cspm.oz.writing.printer import print_term
from cspcheck.cspm.parsing.reading import parse
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as s
from tests.cspm.syntax.strategies_syntax import deferred

NOWHERE = Source("nowhere", "").span(0, 0)


def make(form, /, **parts):
    return form(span=NOWHERE, **parts)


def node(form, /, **parts):
    return st.builds(lambda **values: form(span=NOWHERE, **values), **parts)


def some(strategy, least=0, most=3):
    return st.lists(strategy, min_size=least, max_size=most).map(tuple)


NAMES = ("x", "y", "items", "readings_1", "f", "g", "T", "MESSAGE", "head", "vTheta", "n0")
names = st.sampled_from(NAMES)
decorations = st.sampled_from(["", "", "", "'", "?", "!"])
declared_names = node(s.NameDeclaration, name=names)
references = node(z.Reference, name=st.one_of(names, st.sampled_from(["nat", "real", "id"])), decoration=decorations)
numbers = node(
    z.Number,
    value=st.one_of(st.integers(0, 200), st.integers(0, 1000).map(lambda n: Fraction(n, 8))),
)

INFIX = sorted({s.name for s in SPELLINGS if s.kind == "infix" and s.name != "cross"})
RELATIONS = [*sorted({s.name for s in SPELLINGS if s.kind == "relation"}), "inrel f", "inrel items'"]
UNARY = sorted({s.name for s in SPELLINGS if s.kind in ("prefix", "postfix")})


def declares(terms, least=1, most=2):
    declared = node(z.Declared, name=names, decoration=decorations)
    return some(node(z.Declare, names=some(declared, 1, 2), carrier=terms), least, most)


def lines(terms):
    """Predicates, none of which begins with a minus: a number is no predicate, and the parser says so."""
    return some(terms.filter(lambda term: not print_term(term).startswith("-")))


def definitions(terms):
    return some(st.tuples(declared_names, terms), 1, 2)


@deferred
def terms(depth: int):
    """Any terms, with brackets where they need not be and without where they need to be."""
    base = st.one_of(references, numbers, node(z.Truth, value=st.booleans()))
    if depth == 0:
        return base
    t = terms(depth - 1)
    maybe = st.one_of(st.none(), t)
    return st.one_of(
        base,
        node(z.Reference, name=names, decoration=st.just(""), arguments=some(t, 1, 2)),
        node(z.Grouped, inner=t),
        node(z.Operator, name=st.sampled_from(INFIX), operands=st.tuples(t, t)),
        node(z.Operator, name=st.sampled_from(INFIX), operands=st.tuples(t, t)),
        node(z.Operator, name=st.sampled_from(["and", "or", "minus"]), operands=st.tuples(t, t)),
        node(z.Operator, name=st.just("cross"), operands=some(t, 2, 3)),
        node(z.Operator, name=st.sampled_from(UNARY), operands=st.tuples(t)),
        node(z.Operator, name=st.just("image"), operands=st.tuples(t, t)),
        st.lists(st.tuples(st.sampled_from(RELATIONS), t), min_size=1, max_size=2).flatmap(
            lambda rest: t.map(
                lambda first: make(
                    z.Chain, relations=tuple(r for r, _ in rest), operands=(first, *[o for _, o in rest])
                )
            )
        ),
        node(z.Application, function=t, argument=t, bracketed=st.booleans()),
        node(z.Selection, record=t, field=names, decoration=st.sampled_from(["", "", "'"])),
        node(z.Display, kind=st.sampled_from(["set", "sequence", "bag"]), items=some(t)),
        node(z.Display, kind=st.just("tuple"), items=some(t, 2)),
        node(z.BindingDisplay, fields=definitions(t)),
        node(z.Binding, kind=st.sampled_from(["set", "mu"]), declarations=declares(t), condition=maybe, body=maybe),
        node(z.Binding, kind=st.just("lambda"), declarations=declares(t), condition=maybe, body=t),
        node(
            z.Quantified,
            kind=st.sampled_from(["forall", "exists", "exists1"]),
            declarations=declares(t),
            condition=maybe,
            body=t,
        ),
        node(z.Conditional, test=t, then=t, otherwise=t),
        node(z.Local, definitions=definitions(t), body=t),
    )


def equations():
    texts = ["main = a -> main", "main = a -> P(1) [] b?x!3 -> SKIP", "P(0) = STOP\nP(n) = a -> P(n - 1)", "Q = P(2)"]
    return st.lists(st.sampled_from(texts), unique=True, max_size=3).map(
        lambda chosen: tuple(parse(Source("equations", "\n".join(chosen))).declarations)
    )


@deferred
def operation_terms(depth: int):
    base = st.one_of(
        node(z.Reference, name=names),
        node(z.Selection, record=node(z.Reference, name=names), field=names),
    )
    if depth == 0:
        return base
    t = operation_terms(depth - 1)
    hidden = node(z.Display, kind=st.just("set"), items=some(references, 1, 2))
    text = node(
        z.OperationText,
        delta=st.one_of(st.none(), some(declared_names)),
        declarations=declares(references, 0),
        predicates=some(references, 1),
    )
    return st.one_of(
        base,
        text,
        node(z.Renamed, term=t, renamings=some(st.tuples(decorated_names, decorated_names), 1, 2)),
        node(
            z.Distributed,
            kind=st.sampled_from(["choice", "and", "compose", "parallel"]),
            declarations=declares(references, 1),
            condition=st.one_of(st.none(), references),
            body=t,
        ),
        node(z.Grouped, inner=t),
        node(
            z.Operator,
            name=st.sampled_from(["enrich", "parallel", "parallel_open", "choice", "or", "and", "compose"]),
            operands=st.tuples(t, t),
        ),
        node(z.Operator, name=st.just("hide"), operands=st.tuples(t, hidden)),
    )


plain_references = node(z.Reference, name=st.one_of(names, st.sampled_from(["nat", "real"])))
subjects = st.one_of(
    plain_references,
    node(z.Operator, name=st.sampled_from(["seq", "power", "bag"]), operands=st.tuples(plain_references)),
    node(z.Operator, name=st.just("cross"), operands=st.tuples(plain_references, plain_references)),
)


decorated_names = node(z.Declared, name=names, decoration=decorations)
inclusions = st.one_of(
    node(z.Reference, name=names, decoration=decorations),
    node(
        z.Application,
        function=st.builds(lambda word: make(z.Reference, name=word), st.sampled_from(["Delta", "Xi"])),
        argument=node(z.Reference, name=names),
        bracketed=st.just(False),
    ),
    node(
        z.Renamed,
        term=node(z.Reference, name=names),
        renamings=some(st.tuples(decorated_names, decorated_names), 1, 2),
    ),
)
schema_lines = some(
    st.one_of(
        node(z.Declare, names=st.just(()), carrier=inclusions),
        node(z.Declare, names=some(decorated_names, 1, 2), carrier=node(z.Reference, name=names)),
    ),
    1,
)


def paragraphs(terms, *, local: bool = False):
    types = [
        node(z.GivenTypes, names=some(declared_names, 1)),
        node(
            z.FreeType,
            name=names,
            branches=some(node(z.Branch, name=names, argument=st.one_of(st.none(), terms)), 1),
        ),
        node(z.Abbreviation, name=names, body=terms, generics=some(declared_names, 0, 2)),
        node(z.Axiom, declarations=declares(terms), predicates=lines(terms)),
        node(
            z.Schema,
            name=names,
            declarations=declares(terms),
            predicates=lines(terms),
            initial=st.one_of(st.none(), lines(terms)),
            generics=some(declared_names, 0, 2),
        ),
        node(
            z.Schema,
            name=names,
            declarations=some(node(z.Declare, names=st.just(()), carrier=inclusions), 1, 2),
        ),
        node(z.Abbreviation, name=names, body=node(z.SchemaText, declarations=schema_lines, predicates=some(terms))),
        node(z.Lemma, name=names, predicate=terms, generics=some(declared_names, 0, 2), hints=hints),
    ]
    if local:
        return st.one_of(*types)
    return st.one_of(
        *types,
        node(z.Reading, subject=subjects, carrier=terms),
        node(z.View, kind=st.sampled_from(["control", "data"])),
        node(z.Retrieve, name=names, abstract=declared_names, concrete=declared_names, predicates=lines(terms)),
        classes(terms),
        classes(terms),
    )


uses = node(z.LemmaUse, name=names, arguments=st.one_of(st.just(()), some(terms(1), 1, 2)))
hints = st.one_of(
    st.none(),
    node(z.Hints, using=some(uses, 1, 2), induction=st.one_of(st.none(), declared_names)),
    node(z.Hints, induction=declared_names),
)


def classes(terms):
    delta = st.one_of(st.none(), some(declared_names))
    return node(
        z.Class,
        name=names,
        generics=some(declared_names, 0, 2),
        visibility=st.one_of(st.none(), some(declared_names)),
        inherits=some(
            node(
                z.Inherit,
                name=names,
                arguments=some(terms, 0, 2),
                renamings=some(st.tuples(declared_names, declared_names), 0, 2),
            ),
            0,
            2,
        ),
        interface=some(
            node(
                z.Interface,
                kind=st.sampled_from(["chan", "method", "local_chan"]),
                names=some(declared_names, 1, 2),
                parameters=declares(terms, 0),
            )
        ),
        equations=equations(),
        paragraphs=some(paragraphs(terms, local=True), 0, 2),
        state=st.one_of(
            st.none(),
            node(z.State, primary=declares(terms, 0), secondary=declares(terms, 0), predicates=lines(terms)),
        ),
        initial=st.one_of(st.none(), node(z.Initial, predicates=lines(terms))),
        operations=some(
            st.one_of(
                node(
                    z.OperationSchema,
                    name=names,
                    delta=delta,
                    declarations=declares(terms, 0),
                    predicates=lines(terms),
                    using=some(uses, 0, 2),
                ),
                node(
                    z.OperationDefinition,
                    name=names,
                    body=operation_terms(2).filter(lambda body: not isinstance(body, z.OperationText)),
                    using=some(uses, 0, 2),
                ),
            )
        ),
    )


def plain(tree):
    """The tree without its ``Grouped`` nodes."""
    if isinstance(tree, z.Grouped):
        return plain(tree.inner)
    if isinstance(tree, tuple):
        return tuple(map(plain, tree))
    if is_dataclass(tree) and isinstance(tree, s.Node):
        return replace(tree, **{f.name: plain(getattr(tree, f.name)) for f in fields(tree) if f.name != "span"})
    return tree
