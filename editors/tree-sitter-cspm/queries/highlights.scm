; Names of the captures are those that Neovim, Helix and the tree-sitter command line know.

(line_comment) @comment
(block_comment) @comment
(string) @string
(character) @string
(number) @number
(boolean) @constant.builtin
(wildcard) @variable.builtin

[
  "channel" "datatype" "subtype" "nametype" "transparent" "external" "include" "print" "assert" "module" "exports"
  "endmodule" "instance" "Timed" "let" "within" "class" "end" "given" "reading" "schema" "view" "retrieve" "via" "const"
] @keyword
["if" "then" "else"] @keyword.conditional
["and" "or" "not"] @keyword.operator
(section) @keyword
(keyword) @keyword

(refines) @operator
(property_name) @attribute
(model) @type
(operator) @operator
(binary operator: _ @operator)
(process_operation operator: _ @operator)
["->" "&" "!" "?" "$" "@" "|~|" "|||" "||" "[]" "[|" "|]" "[[" "]]" "<->" "<-" "=" "==" "::="] @operator
["(" ")" "{" "}" "{|" "|}" "<" ">"] @punctuation.bracket
["," ":" ".."] @punctuation.delimiter

(definition head: (identifier) @function)
(definition head: (call function: (identifier) @function))
(call function: (identifier) @function.call)
(channel_declaration (identifier) @variable.parameter)
(constructor . (identifier) @constructor)
(datatype_declaration name: (identifier) @type)
(nametype_declaration name: (identifier) @type)
(z_definition name: (identifier) @type)
(class name: (identifier) @type)
(schema name: (identifier) @type)
((identifier) @constant.builtin
  (#any-of? @constant.builtin "STOP" "SKIP" "CHAOS" "DIV" "RUN" "WAIT" "Events"))
