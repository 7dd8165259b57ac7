"""Tokens: what depends on where a character stands."""

from __future__ import annotations

import pytest

from cspcheck.cspm.parsing.lexer import KEYWORDS, Form, tokenise
from cspcheck.cspm.source import Source


def kinds(text: str, *, form: Form = "script") -> str:
    """The kinds of a text's tokens, without the end."""
    tokens = tokenise(Source("<text>", text), form=form)
    assert not tokens.errors
    return " ".join(tokens.kinds[:-1])


def texts(text: str) -> list[str]:
    tokens = tokenise(Source("<text>", text))
    return [tokens.text(index) for index in range(len(tokens.kinds) - 1)]


class TestWords:
    def test_names_have_letters_digits_underscores_and_primes_at_the_end(self) -> None:
        assert texts("a A1 a_b x' x''") == ["a", "A1", "a_b", "x'", "x''"]

    def test_two_colons_without_blanks_join_the_parts_of_a_name(self) -> None:
        assert kinds("M::x A::B::x") == "QUALIFIED QUALIFIED"

    @pytest.mark.parametrize("text", ["x :: T", "x:: T", "x ::T"])
    def test_two_colons_with_a_blank_introduce_a_type(self, text: str) -> None:
        assert kinds(text) == "NAME :: NAME"

    def test_keywords_are_kinds_of_their_own(self) -> None:
        for word in KEYWORDS:
            assert tokenise(Source("", f"{word} ")).kinds[0] == word
            assert tokenise(Source("", word + "1")).kinds[0] == "NAME"

    def test_true_and_false_are_keywords_but_capitalised_they_are_names(self) -> None:
        assert kinds("true True false False") == "true NAME false NAME"


class TestComments:
    def test_line_comments_end_with_the_line(self) -> None:
        assert kinds("x -- y\n= 1") == "NAME = INT"

    def test_block_comments_nest(self) -> None:
        assert kinds("x {- a {- b -} c -} = 1") == "NAME = INT"

    def test_comments_are_kept_with_their_places(self) -> None:
        source = Source("", "-- one\nx = {- two\n{- three -} -} 1 -- four")
        found = [source.text[start:end] for start, end in tokenise(source).comments]
        assert found == ["-- one", "{- two\n{- three -} -}", "-- four"]

    def test_a_brace_and_a_minus_open_a_comment_even_in_a_set(self) -> None:
        assert kinds("{-1..1} -} x") == "NAME"
        assert kinds("{ -1..1}") == "{ - INT .. INT }"

    def test_a_minus_before_a_minus_begins_a_comment(self) -> None:
        assert kinds("x --1") == "NAME"
        assert kinds("x - -1") == "NAME - - INT"

    def test_quotes_in_comments_and_dashes_in_strings_mean_nothing(self) -> None:
        assert kinds('x -- don\'t\n= "-- {- "') == "NAME = STRING"


class TestSequenceBrackets:
    @pytest.mark.parametrize("before", ["(", "=", ",", "[", "not", "then", "x ^", "->", "&", "<-", ""])
    def test_less_opens_a_sequence_where_an_operand_is_due(self, before: str) -> None:
        assert kinds(f"{before} <", form="expression").endswith("SEQUENCE_OPEN")

    @pytest.mark.parametrize("before", ["x", "1", "'c'", '"s"', ")", "}", "|}", "|)", "]]", "_", "true", "<>"])
    def test_less_compares_behind_an_operand(self, before: str) -> None:
        assert kinds(f"{before} <", form="expression").endswith("LESS")

    def test_the_first_greater_closes_an_open_sequence(self) -> None:
        assert kinds("<x>2>", form="expression") == "SEQUENCE_OPEN NAME SEQUENCE_CLOSE INT >"

    def test_brackets_inside_a_sequence_start_afresh(self) -> None:
        assert kinds("<(x>2)>", form="expression") == "SEQUENCE_OPEN ( NAME > INT ) SEQUENCE_CLOSE"
        assert kinds("<{x>2}, [|a>b|>", form="expression").count("SEQUENCE_CLOSE") == 0

    def test_a_let_inside_a_sequence_starts_afresh(self) -> None:
        assert kinds("<let x = 1>2 within x>", form="expression").endswith("> INT within NAME SEQUENCE_CLOSE")

    def test_without_an_open_sequence_greater_compares(self) -> None:
        assert kinds("x > y", form="expression") == "NAME > NAME"
        assert kinds("<1> > <2>", form="expression").split().count(">") == 1

    def test_closing_comes_before_longer_signs(self) -> None:
        assert kinds("<a>==<b>", form="expression").split()[2:4] == ["SEQUENCE_CLOSE", "=="]
        assert kinds("(| <a>=>1 |)", form="expression").split()[3:5] == ["SEQUENCE_CLOSE", "=>"]
        assert kinds("<x>=2", form="expression").split() == ["SEQUENCE_OPEN", "NAME", ">=", "INT"]

    def test_an_opening_less_is_never_part_of_a_longer_sign(self) -> None:
        assert kinds("= <-1>") == "= SEQUENCE_OPEN - INT SEQUENCE_CLOSE"

    def test_blanks_between_the_brackets_of_the_empty_sequence(self) -> None:
        assert kinds("x = <   > > <>") == "NAME = SEQUENCE_OPEN SEQUENCE_CLOSE > SEQUENCE_OPEN SEQUENCE_CLOSE"


class TestLineBreaks:
    @pytest.mark.parametrize("start", ["x", "1", "'c'", '"s"', "true", "(", "{", "{|", "(| ", "<", "-", "#", "_"])
    def test_count_before_what_can_begin_an_expression(self, start: str) -> None:
        assert kinds(f"x = y\n{start}").split()[3] == "_NEWLINE"

    @pytest.mark.parametrize(
        "word", ["channel", "datatype", "assert", "print", "let", "if", "not", "external", "exports"]
    )
    def test_count_before_words_that_begin_something(self, word: str) -> None:
        assert kinds(f"x = y\n{word} ").split()[3] == "_NEWLINE"

    def test_print_is_a_word_before_a_blank_only(self) -> None:
        assert kinds("print x") == "print NAME"
        assert kinds("print!x") == "NAME ! NAME"
        assert kinds("channel print:T") == "channel NAME : NAME"

    @pytest.mark.parametrize(
        "sign",
        [
            *("[]", "|~|", "|||", ";", "[>", "/\\", "[|", "[+", "/+", "[", "\\", "|\\", "[[", "->", "&", "?", "!", "$"),
            *(
                "+",
                "*",
                "/",
                "%",
                "^",
                "==",
                "!=",
                "<=",
                ">",
                ">=",
                ".",
                "and",
                "or",
                "=",
                ":",
                "::",
                ",",
                "|",
                "@",
                "@@",
            ),
            *("then", "else", "within", ")", "}", "|}", "]", "]]", "|]", "|>", "+]", "+\\", "<-", "<->", "[T= ", ".."),
        ],
    )
    def test_do_not_count_before_what_cannot_begin_a_declaration(self, sign: str) -> None:
        assert "_NEWLINE" not in kinds(f"x = y\n  {sign}")

    @pytest.mark.parametrize("sign", ["=", "+", "-", "->", "[]", "(", ",", "then", "let", "|~|", "@", "not", "<"])
    def test_do_not_count_behind_what_cannot_end_a_declaration(self, sign: str) -> None:
        assert "_NEWLINE" not in kinds(f"x {sign}\n  y")

    def test_do_not_count_in_brackets(self) -> None:
        for opener in ("(", "{", "<", "{|", "[|", "[[", "[", "(| "):
            assert "_NEWLINE" not in kinds(f"x = {opener} y\nz\n-1")

    def test_count_in_a_let_even_in_brackets(self) -> None:
        assert kinds("(let x = 1\ny = 2\nwithin x\ny)").count("_NEWLINE") == 1

    def test_count_in_timed_sections_but_not_in_their_header(self) -> None:
        assert kinds("Timed (\nf\n) { x = 1\ny = 2\n}\nz").split().count("_NEWLINE") == 2

    def test_many_count_as_one_and_comments_as_none(self) -> None:
        assert kinds("x = 1\n\n-- a\n\n{- b\n -}\n\ny = 2").split().count("_NEWLINE") == 1

    def test_inside_a_block_comment_do_not_count(self) -> None:
        assert "_NEWLINE" not in kinds("x {- \n -} y")

    def test_a_declaration_word_ends_the_brackets_that_were_forgotten(self) -> None:
        # The parser says that they were; here it matters that line breaks count again from there on.
        assert kinds("x = (1\nchannel c\ny") == "NAME = ( INT channel NAME _NEWLINE NAME"


class TestAssertions:
    @pytest.mark.parametrize("model", ["T", "F", "FD", "V", "VD", "R", "RD"])
    def test_refinement_is_one_token(self, model: str) -> None:
        assert kinds(f"assert P[{model}=Q") == "assert NAME REFINES NAME"

    def test_not_negates_refinements_and_properties(self) -> None:
        assert kinds("assert not P [T= Q") == "assert ASSERT_NOT NAME REFINES NAME"
        assert kinds("assert not not P :[deadlock free]") == "assert ASSERT_NOT ASSERT_NOT NAME PROPERTY"

    def test_not_is_an_operator_in_boolean_assertions(self) -> None:
        assert kinds("assert not x\nassert P [T= Q").split()[:3] == ["assert", "not", "NAME"]
        assert kinds("assert (not x) [T= Q").split()[2] == "not"

    @pytest.mark.parametrize(
        ("text", "kind"),
        [
            (":[deadlock free]", "PROPERTY"),
            (":[deadlock-free [F]]", "PROPERTY"),
            (" : [ livelock  free [FD] ]:", "PROPERTY"),
            (":[has trace]:", "TRACE_PROPERTY"),
            (":[has trace [F]]", "TRACE_PROPERTY"),
            (":[tau priority over]:", "PRIORITY_OPTION"),
            (":[partial order reduce [hybrid]]", "REDUCE_OPTION"),
        ],
    )
    def test_properties_and_options_are_one_token(self, text: str, kind: str) -> None:
        assert kinds(f"assert P {text}") == f"assert NAME {kind}"

    def test_a_colon_before_other_brackets_is_a_colon(self) -> None:
        assert kinds("[] x : [] y : s").split()[:4] == ["[]", "NAME", ":", "[]"]


class TestMaps:
    def test_the_opener_needs_a_blank(self) -> None:
        assert kinds("(| 1").split()[0] == "(|"
        assert kinds("(|\n1").split()[0] == "(|"
        assert kinds("(|1").split()[:2] == ["(", "|"]

    def test_bracketed_replicated_operators(self) -> None:
        assert kinds("(|~| x").split()[:2] == ["(", "|~|"]
        assert kinds("(||| x").split()[:2] == ["(", "|||"]
        assert kinds("(|| x").split()[:2] == ["(", "||"]


def test_every_token_lies_where_its_text_is() -> None:
    text = "P(x) = c?y:{1}!'a' -> STOP -- end\n  [] <x | x <- \"s\"> == M::n\n"
    tokens = tokenise(Source("", text))
    rebuilt = list(" " * len(text))
    for start, end in [*zip(tokens.starts, tokens.ends, strict=True), *tokens.comments]:
        rebuilt[start:end] = text[start:end]
    assert "".join(rebuilt).split() == text.split()


def test_tokens_from_the_middle_of_a_text() -> None:
    source = Source("", "P = (\nQ = 1")
    assert tokenise(source, start=6).kinds == ["NAME", "=", "INT", "$END"]
