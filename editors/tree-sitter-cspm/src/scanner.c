// What the generated lexer cannot see: comments between {- and -}, which nest; the `>` that ends the innermost sequence;
// lines that begin with a bracket, which do not go on with the expression of the line before; and sets by predicates.
#include "tree_sitter/parser.h"

enum TokenType { BLOCK_COMMENT, SEQUENCE_END, LINE_START, MAP_BEGIN, Z_SET_BEGIN, RECOVERY };

void *tree_sitter_cspm_external_scanner_create(void) { return NULL; }
void tree_sitter_cspm_external_scanner_destroy(void *payload) { (void)payload; }
unsigned tree_sitter_cspm_external_scanner_serialize(void *payload, char *buffer) {
  (void)payload;
  (void)buffer;
  return 0;
}
void tree_sitter_cspm_external_scanner_deserialize(void *payload, const char *buffer, unsigned length) {
  (void)payload;
  (void)buffer;
  (void)length;
}

// Whether a declaration stands behind the bracket: `{x : T | x > 0}`, and not `{x | x <- S}`, `{0..2}` or `{M::x}`.
static bool declares(TSLexer *lexer) {
  lexer->mark_end(lexer);
  lexer->result_symbol = Z_SET_BEGIN;
  while (!lexer->eof(lexer)) {
    int32_t now = lexer->lookahead;
    if (now == '|' || now == '}' || now == '{' || now == '"') return false;
    lexer->advance(lexer, false);
    if (now != ':') continue;
    if (lexer->lookahead != ':') return true;
    lexer->advance(lexer, false);
  }
  return false;
}

bool tree_sitter_cspm_external_scanner_scan(void *payload, TSLexer *lexer, const bool *valid_symbols) {
  (void)payload;
  bool line_start = false;
  while (lexer->lookahead == ' ' || lexer->lookahead == '\t' || lexer->lookahead == '\n' || lexer->lookahead == '\r') {
    line_start = line_start || lexer->lookahead == '\n';
    lexer->advance(lexer, true);
  }
  bool recovers = valid_symbols[RECOVERY];  // after a mistake everything is valid, and this too
  if (lexer->lookahead == '>' && valid_symbols[SEQUENCE_END] && !recovers) {
    lexer->advance(lexer, false);
    lexer->mark_end(lexer);
    lexer->result_symbol = SEQUENCE_END;
    if (lexer->lookahead != '=') return true;
    lexer->advance(lexer, false);
    return lexer->lookahead == '=';  // `<1>==s`, and not `x >= 1`
  }
  lexer->mark_end(lexer);
  int32_t first = lexer->lookahead;
  bool begins = line_start && valid_symbols[LINE_START] && !recovers;
  if (begins && (first == '(' || first == '<')) {
    lexer->result_symbol = LINE_START;
    return true;
  }
  if (first == '(' && valid_symbols[MAP_BEGIN] && !recovers) {
    lexer->advance(lexer, false);
    if (lexer->lookahead != '|') return false;
    lexer->advance(lexer, false);
    lexer->mark_end(lexer);
    lexer->result_symbol = MAP_BEGIN;
    return lexer->lookahead != '~' && lexer->lookahead != '|';  // `(|~| x : S @ P(x))` is a process in brackets
  }
  if (first != '{') return false;
  lexer->advance(lexer, false);
  if (lexer->lookahead != '-') return valid_symbols[Z_SET_BEGIN] && !recovers && declares(lexer);
  if (!valid_symbols[BLOCK_COMMENT]) return false;
  lexer->advance(lexer, false);
  unsigned depth = 1;
  int32_t before = 0;
  while (depth > 0) {
    if (lexer->eof(lexer)) return false;
    int32_t now = lexer->lookahead;
    lexer->advance(lexer, false);
    if (before == '{' && now == '-') {
      depth++;
      before = 0;
    } else if (before == '-' && now == '}') {
      depth--;
      before = 0;
    } else {
      before = now;
    }
  }
  lexer->mark_end(lexer);
  lexer->result_symbol = BLOCK_COMMENT;
  return true;
}
