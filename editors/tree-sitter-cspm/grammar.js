/**
 * CSPm, and classes of CSP-OZ in the text notation, for editors: highlighting, folding, selection by structure.
 *
 * Trees are shallow on purpose: what a script means is cspcheck's own parser's to say. Line breaks are blanks here, and a
 * declaration ends where no expression goes on. Of classes the sections and words are told apart, not the predicates.
 *
 * `tree-sitter generate` writes src/parser.c from this; src/scanner.c has the comments, which nest.
 */

// How tight operators bind, from the loosest.
const PREC = {
  scope: 1, // if, let, lambda, replicated operators: as far as they can
  hide: 2,
  interleave: 3,
  parallel: 4,
  internal: 5,
  external: 6,
  interrupt: 7,
  timeout: 8,
  sequential: 9,
  prefix: 10,
  field: 11,
  dot: 12,
  or: 13,
  and: 14,
  not: 15,
  compare: 16,
  add: 17,
  multiply: 18,
  sign: 19,
  concat: 20,
  call: 21,
};

const commaSep1 = (rule) => seq(rule, repeat(seq(",", rule)));
const commaSep = (rule) => optional(commaSep1(rule));
const PARAGRAPHS = ["given", "reading", "const", "schema", "view", "retrieve"]; // words at the beginning of a paragraph only
const IDENTIFIER = /[\p{L}][\p{L}\p{N}_]*'*/;

module.exports = grammar({
  name: "cspm",

  externals: ($) => [$.block_comment, $._sequence_end, $._line_start, $._map_begin, $._z_set_begin, $._recovery],
  extras: ($) => [/\s/, $.line_comment, $.block_comment],
  word: ($) => $.identifier,
  conflicts: ($) => [
    [$._name, $._type],
    [$._name, $.constraint],
    [$._name, $.constants],
    [$.module, $.parenthesised],
    [$._name, $.z_definition],
    [$._claim],
    [$.option],
    [$._expression, $._type],
    [$._expression, $.field_input],
  ],

  rules: {
    source_file: ($) => optional($._declarations),
    _declarations: ($) => repeat1(choice($._declaration, $._line_start)),

    line_comment: (_) => token(seq("--", /[^\n]*/)),

    _declaration: ($) =>
      choice(
        $.definition,
        $.annotation,
        $.channel_declaration,
        $.datatype_declaration,
        $.nametype_declaration,
        $.function_import,
        $.include,
        $.print,
        $.assertion,
        $.module,
        $.instance,
        $.timed_section,
        $.class,
        $.z_definition,
        $.given,
        $.reading,
        $.constants,
        $.schema,
        $.view,
        $.retrieve
      ),

    definition: ($) => seq(field("head", $._expression), "=", field("body", $._expression)),
    annotation: ($) => seq(commaSep1($.identifier), "::", $._type),
    channel_declaration: ($) =>
      prec.right(seq("channel", commaSep1($.identifier), optional(seq(":", $._expression)))),
    datatype_declaration: ($) =>
      seq(choice("datatype", "subtype"), field("name", $.identifier), "=", $.constructor, repeat(seq("|", $.constructor))),
    constructor: ($) => prec.right(seq($.identifier, optional(seq(".", $._expression)))),
    nametype_declaration: ($) => seq("nametype", field("name", $.identifier), "=", $._expression),
    function_import: ($) => seq(choice("transparent", "external"), commaSep1($.identifier)),
    include: ($) => seq("include", $.string),
    print: ($) => seq("print", $._expression),
    module: ($) =>
      seq(
        "module",
        field("name", $.identifier),
        optional(seq("(", commaSep1($._expression), ")")),
        optional($._declarations),
        "exports",
        optional($._declarations),
        "endmodule"
      ),
    instance: ($) =>
      prec.right(seq("instance", field("name", $.identifier), "=", $._name, optional(seq("(", commaSep1($._expression), ")")))),
    timed_section: ($) =>
      seq("Timed", optional(seq("(", $._expression, ")")), "{", optional($._declarations), "}"),

    assertion: ($) => seq("assert", repeat("not"), $._expression, optional($._claim), repeat($.option)),
    _claim: ($) =>
      choice(
        seq($.refines, $._expression),
        seq($.property, optional(choice(seq(":", $._expression), $.sequence, prec.dynamic(-1, choice($.identifier, ":"))))),
        seq("[OZ=", $.identifier, optional(seq("via", $.identifier, optional($.property))))
      ),
    refines: (_) => choice("[T=", "[F=", "[FD=", "[V=", "[VD=", "[R=", "[RD=", "[="),
    property: ($) =>
      seq(
        $._property_begin,
        alias(/[a-z]+([ \t-]+[a-z]+)*/, $.property_name),
        optional(seq("[", alias(/T|F|FD|V|VD|R|RD/, $.model), "]")),
        "]"
      ),
    _property_begin: (_) => /:[ \t]*\[/,
    option: ($) =>
      choice(
        seq($._property_begin, alias(/tau[ \t]+priority([ \t]+over)?/, $.property_name), "]", ":", $._expression),
        seq($._property_begin, alias(/partial[ \t]+order[ \t]+reduce/, $.property_name), optional(seq("[", $.identifier, "]")), "]"),
        seq($._property_begin, alias(/symmetry[ \t]+reduce/, $.property_name), "]", optional(seq(":", optional(commaSep1($._expression)))))
      ),

    _expression: ($) =>
      choice(
        $._name,
        $.number,
        $.string,
        $.character,
        $.boolean,
        $.wildcard,
        $.parenthesised,
        $.set,
        $.productions,
        $.sequence,
        $.map,
        $.call,
        $.renaming,
        $.unary,
        $.binary,
        $.communication,
        $.prefix,
        $.guard,
        $.process_operation,
        $.replicated,
        $.conditional,
        $.let,
        $.lambda
      ),

    _name: ($) => choice($.identifier, $.qualified_name, alias(choice(...PARAGRAPHS), $.identifier)),
    qualified_name: (_) => /[\p{L}][\p{L}\p{N}_]*'*(::[\p{L}][\p{L}\p{N}_]*'*)+/,
    identifier: (_) => IDENTIFIER,
    number: (_) => /[0-9]+/,
    string: (_) => /"([^"\\\n]|\\.)*"/,
    character: (_) => /'([^'\\\n]|\\.)'/,
    boolean: (_) => choice("true", "false"),
    wildcard: (_) => "_",

    parenthesised: ($) => seq("(", commaSep1($._expression), ")"),
    _items: ($) => prec(30, choice(commaSep1(choice($.generator, $._expression)), seq($._expression, "..", optional($._expression)))),
    set: ($) => seq("{", optional($._items), optional(seq("|", $._statements)), "}"),
    productions: ($) => seq("{|", optional($._items), optional(seq("|", $._statements)), "|}"),
    sequence: ($) =>
      seq(choice("<", "⟨"), optional($._items), optional(seq("|", $._statements)), choice(alias($._sequence_end, ">"), "⟩")),
    map: ($) => seq(alias($._map_begin, "(|"), commaSep(seq($._expression, "=>", $._expression)), "|)"),
    _statements: ($) => prec(30, commaSep1(choice($.generator, $._expression))),
    generator: ($) => prec(31, seq($._expression, choice("<-", ":", "∈"), $._expression)),

    call: ($) => prec(PREC.call, seq(field("function", $._expression), "(", commaSep($._expression), ")")),
    renaming: ($) =>
      prec(
        PREC.call,
        seq($._expression, "[[", commaSep1(seq($._expression, "<-", $._expression)), optional(seq("|", $._statements)), "]]")
      ),

    unary: ($) =>
      choice(
        prec(PREC.not, seq("not", $._expression)),
        prec(PREC.sign, seq(choice("-", "#"), $._expression))
      ),
    binary: ($) =>
      choice(
        ...[
          [["^"], PREC.concat],
          [["*", "/", "%"], PREC.multiply],
          [["+", "-"], PREC.add],
          [["==", "!=", "<", "<=", ">", ">=", "≤", "≥", "≠"], PREC.compare],
          [["and"], PREC.and],
          [["or"], PREC.or],
          [["."], PREC.dot],
        ].map(([operators, level]) => prec.left(level, seq($._expression, field("operator", choice(...operators)), $._expression)))
      ),

    communication: ($) => prec.left(PREC.field, seq($._expression, repeat1(choice($.field_output, $.field_input)))),
    field_output: ($) => prec.left(PREC.field, seq("!", $._expression)),
    field_input: ($) =>
      prec.right(PREC.field, seq(choice("?", "$"), $._expression, optional(seq(":", $._expression)))),
    prefix: ($) => prec.right(PREC.prefix, seq($._expression, "->", $._expression)),
    guard: ($) => prec.right(PREC.prefix, seq($._expression, "&", $._expression)),

    process_operation: ($) =>
      choice(
        ...[
          [[";"], PREC.sequential],
          [["[>"], PREC.timeout],
          [["/\\"], PREC.interrupt],
          [["[]"], PREC.external],
          [["|~|"], PREC.internal],
          [["|||"], PREC.interleave],
          [["||"], PREC.parallel],
          [["\\", "|\\", "@@"], PREC.hide],
        ].map(([operators, level]) => prec.left(level, seq($._expression, field("operator", choice(...operators)), $._expression))),
        prec.left(PREC.timeout, seq($._expression, "/+", $._expression, "+\\", $._expression)),
        prec.left(PREC.external, seq($._expression, "[+", $._expression, "+]", $._expression)),
        prec.left(PREC.parallel, seq($._expression, "[|", $._expression, choice("|]", "|>"), $._expression)),
        prec.left(PREC.parallel, seq($._expression, "[", $._expression, "||", $._expression, "]", $._expression)),
        prec.left(PREC.parallel, seq($._expression, "[", $._links, "]", $._expression))
      ),
    _links: ($) => seq(commaSep1($.link), optional(seq("|", $._statements))),
    link: ($) => seq($._expression, "<->", $._expression),

    replicated: ($) =>
      prec.right(
        PREC.scope,
        choice(
          seq(
            choice("[]", "|~|", "|||", ";", seq("[|", $._expression, "|]"), seq("[+", $._expression, "+]"), seq("[", $._links, "]")),
            $._statements,
            "@",
            $._expression
          ),
          seq("||", $._statements, "@", "[", $._expression, "]", $._expression)
        )
      ),
    conditional: ($) =>
      prec.right(PREC.scope, seq("if", $._expression, "then", $._expression, "else", $._expression)),
    let: ($) => prec.right(PREC.scope, seq("let", optional($._declarations), "within", $._expression)),
    lambda: ($) => prec.right(PREC.scope, seq("\\", commaSep1($._expression), "@", $._expression)),

    _type: ($) =>
      choice(
        $._name,
        seq("(", commaSep($._type), ")"),
        seq("{", $._type, "}"),
        seq("<", $._type, alias($._sequence_end, ">")),
        seq(alias($._map_begin, "(|"), $._type, "=>", $._type, "|)"),
        prec.left(3, seq($._type, ".", $._type)),
        prec.right(2, seq($._type, choice("=>", "=>*"), $._type)),
        prec.right(1, seq($._type, "->", $._type)),
        prec.right(2, seq($.constraint, "=>", $._type)),
        prec.right(2, seq("(", commaSep1($.constraint), ")", "=>", $._type))
      ),

    constraint: ($) => seq($.identifier, $.identifier),

    // Paragraphs of CSP-OZ: their sections by name, and in them words.
    class: ($) => seq("class", field("name", $.identifier), repeat($._oz), "end"),
    z_definition: ($) =>
      prec.right(
        seq(field("name", $.identifier), choice("==", "::="), choice($._range, $.z_set), repeat(seq("|", $._expression)))
      ),
    z_set: ($) => seq(alias($._z_set_begin, "{"), repeat(choice($._oz, $._braces)), "}"),
    _braces: ($) => seq("{", repeat(choice($._oz, $._braces)), "}"),
    _range: ($) => prec.right(seq($._expression, optional(seq("..", $._expression)))),
    given: ($) => seq("given", commaSep1($.identifier)),
    reading: ($) => seq("reading", $.identifier, "=", $._range),
    constants: ($) => seq("const", repeat($._oz), "end"),
    schema: ($) => seq("schema", field("name", $.identifier), repeat($._oz), "end"),
    view: ($) => seq("view", choice("data", "control")),
    retrieve: ($) => seq("retrieve", field("name", $.identifier), repeat($._oz), "end"),
    section: (_) =>
      choice(
        "inherit",
        "visible",
        "chan",
        "method",
        "local_chan",
        "state",
        "init",
        "INIT",
        "op",
        "where",
        "Delta",
        "const",
        "main",
        "enable",
        "effect",
        "changes"
      ),
    _oz: ($) =>
      choice(
        $.section,
        $.identifier,
        $.number,
        $.string,
        $.boolean,
        alias(choice("if", "then", "else", "let", "within", "and", "or", "not", "forall", "exists", "exists1", "lambda", "mu"), $.keyword),
        alias($._symbol, $.operator)
      ),
    _symbol: (_) =>
      token(
        prec(
          -1,
          choice(
            ...["[|", "|]", "[[", "]]", "{|", "|}", "(|", "|)", "|~|", "|||", "||", "[]", "[>", "[+", "+]", "/\\", "\\/", "->"],
            ...["<-", "<->", "<=", ">=", "==", "!=", "::", "=>", "..", "++", "<|", "|>", "@@", "/+", "+\\", "[T=", "::="],
            /[^\s\p{L}0-9"]/
          )
        )
      ),
  },
});
