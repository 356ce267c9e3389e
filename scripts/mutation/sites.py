"""Finds in C++ sources, through libclang, what a mutant may change.

A site is a piece of a function's body that can be replaced as a whole behind a switch: a statement, a condition, or the
value that a variable begins with. In it are the places where an operator of mutation changes something. What the
compiler evaluates (labels of a switch, if constexpr, constexpr variables) is no site. A macro's call is left as it is,
with its arguments: as a statement or condition of its own it is a site, but nothing in it is changed.
"""

import bisect
import pathlib
import re
from typing import NamedTuple, Optional

from clang.cindex import Cursor, CursorKind, Index, StorageClass, TokenKind, TranslationUnit, TypeKind

# These functions print or describe something, and are no part of the machine.
SKIPPED_FUNCTIONS = {"trace", "sc_trace", "operator<<", "waiting_for"}

FUNCTIONS = {CursorKind.FUNCTION_DECL, CursorKind.CXX_METHOD, CursorKind.CONSTRUCTOR, CursorKind.DESTRUCTOR,
             CursorKind.CONVERSION_FUNCTION, CursorKind.FUNCTION_TEMPLATE}
SCOPES = {CursorKind.NAMESPACE, CursorKind.CLASS_DECL, CursorKind.STRUCT_DECL, CursorKind.UNION_DECL,
          CursorKind.CLASS_TEMPLATE, CursorKind.CLASS_TEMPLATE_PARTIAL_SPECIALIZATION, CursorKind.LINKAGE_SPEC,
          CursorKind.UNEXPOSED_DECL, CursorKind.FRIEND_DECL}
NAMES = {CursorKind.DECL_REF_EXPR, CursorKind.OVERLOADED_DECL_REF}
CALLABLE = {CursorKind.FUNCTION_DECL, CursorKind.CXX_METHOD, CursorKind.FUNCTION_TEMPLATE,
            CursorKind.OVERLOADED_DECL_REF}
NUMBERS = {TypeKind.BOOL, TypeKind.CHAR_U, TypeKind.UCHAR, TypeKind.USHORT, TypeKind.UINT, TypeKind.ULONG,
           TypeKind.ULONGLONG, TypeKind.CHAR_S, TypeKind.SCHAR, TypeKind.SHORT, TypeKind.INT, TypeKind.LONG,
           TypeKind.LONGLONG, TypeKind.FLOAT, TypeKind.DOUBLE}

SWAPPED = {"<": ("<=", "relational"), "<=": ("<", "relational"), ">": (">=", "relational"),
           ">=": (">", "relational"), "==": ("!=", "relational"), "!=": ("==", "relational"),
           "&&": ("||", "logical"), "||": ("&&", "logical"), "+": ("-", "arithmetic"), "-": ("+", "arithmetic"),
           "*": ("/", "arithmetic"), "/": ("*", "arithmetic"), "%": ("/", "arithmetic"),
           "+=": ("-=", "arithmetic"), "-=": ("+=", "arithmetic"), "<<": (">>", "arithmetic"),
           ">>": ("<<", "arithmetic"), "&": ("|", "arithmetic"), "|": ("&", "arithmetic"),
           "^": ("|", "arithmetic")}
STEPPED = {"++": "--", "--": "++"}
NEGATED_BOOLS = {"true": "false", "false": "true"}
RENAMED = {"min": ("max", "min/max"), "max": ("min", "min/max"), "all_of": ("any_of", "all/any"),
           "any_of": ("all_of", "all/any")}


class Change(NamedTuple):
    """What an operator of mutation does: this text replaces start..end of the file."""

    operator: str
    start: int
    end: int
    text: str


class Site(NamedTuple):
    """A piece of a source file that mutants replace; form is condition, value or statement."""

    start: int
    end: int
    form: str
    changes: tuple[Change, ...]


class Token(NamedTuple):
    start: int
    end: int
    text: str


class ParseError(Exception):
    """A source that does not compile has no sites."""


class SourceTokens:
    """The tokens of a file as it is written. Offsets of the AST at which no token begins or ends come from macros."""

    def __init__(self, unit: TranslationUnit, path: str):
        file = unit.get_file(path)
        extent = unit.get_extent(path, (0, pathlib.Path(path).stat().st_size))
        self.tokens = [Token(token.extent.start.offset, token.extent.end.offset, token.spelling)
                       for token in unit.get_tokens(extent=extent)
                       if token.kind != TokenKind.COMMENT and token.location.file.name == file.name]
        self.starts = [token.start for token in self.tokens]

    def index_from(self, offset: int) -> int:
        """Index of the first token that begins at the offset or after it."""
        return bisect.bisect_left(self.starts, offset)

    def at(self, offset: int) -> Optional[Token]:
        index = self.index_from(offset)
        return self.tokens[index] if index < len(self.tokens) and self.starts[index] == offset else None

    def following(self, offset: int) -> Optional[Token]:
        index = self.index_from(offset)
        return self.tokens[index] if index < len(self.tokens) else None

    def before(self, offset: int) -> Token:
        return self.tokens[self.index_from(offset) - 1]

    def between(self, start: int, end: int) -> list[Token]:
        return self.tokens[self.index_from(start):self.index_from(end)]

    def ending(self, offset: int) -> Optional[Token]:
        """The token that ends at the offset."""
        index = self.index_from(offset) - 1
        return self.tokens[index] if index >= 0 and self.tokens[index].end == offset else None

    def head(self, start: int) -> Optional[tuple[int, int, list[int]]]:
        """The parentheses of an if, for, while or switch that begins at the offset: where they open and close, and
        where semicolons divide them."""
        depth, opening, semicolons = 0, 0, []
        for token in self.tokens[self.index_from(start):]:
            if token.text in ("(", "[", "{"):
                opening = opening or token.start
                depth += 1
            elif token.text in (")", "]", "}"):
                depth -= 1
                if depth == 0:
                    return opening, token.start, semicolons
            elif token.text == ";" and depth == 1:
                semicolons.append(token.start)
        return None


def start_of(cursor: Cursor) -> int:
    return cursor.extent.start.offset


def end_of(cursor: Cursor) -> int:
    return cursor.extent.end.offset


class Changes:
    """Collects what operators of mutation change in an expression or statement."""

    def __init__(self, tokens: SourceTokens, start: int, end: int, root: Cursor):
        self.tokens, self.start, self.end = tokens, start, end
        self.found: dict[Change, None] = {}  # in order, each once: some nodes are visited twice
        inside = [cursor for cursor in root.walk_preorder()
                  if start <= start_of(cursor) and end_of(cursor) <= end and start_of(cursor) < end_of(cursor)]
        # What a text says, and how it is put together, is not the machine's behaviour.
        self.message = any(cursor.kind == CursorKind.STRING_LITERAL for cursor in inside)
        for cursor in inside:
            self.visit(cursor)

    def visit(self, cursor: Cursor) -> None:
        kind = cursor.kind
        if kind in (CursorKind.BINARY_OPERATOR, CursorKind.COMPOUND_ASSIGNMENT_OPERATOR):
            self.binary(list(cursor.get_children()), of_numbers=True)
        elif kind == CursorKind.UNARY_OPERATOR:
            self.unary(cursor)
        elif kind == CursorKind.CALL_EXPR and cursor.spelling.startswith("operator"):
            self.overloaded(cursor)
        elif kind == CursorKind.ARRAY_SUBSCRIPT_EXPR:
            self.index(cursor)
        elif kind == CursorKind.INTEGER_LITERAL:
            self.number(cursor)
        elif kind == CursorKind.CXX_BOOL_LITERAL_EXPR:
            self.boolean(cursor)
        elif kind in NAMES:
            self.name(cursor)

    def add(self, operator: str, start: int, end: int, text: str) -> None:
        self.found[Change(operator, start, end, text)] = None

    def binary(self, operands: list[Cursor], of_numbers: bool) -> None:
        if len(operands) != 2:
            return
        between = self.tokens.between(end_of(operands[0]), start_of(operands[1]))
        if len(between) != 1 or between[0].text not in SWAPPED:
            return
        token = between[0]
        if (token.text in ("<<", ">>") and not of_numbers) or (token.text == "+" and self.message):
            return  # output, or a text
        text, operator = SWAPPED[token.text]
        self.add(operator, token.start, token.end, text)

    def unary(self, cursor: Cursor) -> None:
        first, last = self.tokens.at(start_of(cursor)), self.tokens.ending(end_of(cursor))
        if first is not None and first.text in ("!", "not"):
            self.add("negation", first.start, first.end, "")
        for token in (first, last):
            if token is not None and token.text in STEPPED:
                self.add("step", token.start, token.end, STEPPED[token.text])
                return

    def overloaded(self, cursor: Cursor) -> None:
        operands = list(cursor.get_arguments())
        if cursor.spelling == "operator[]":
            self.index(cursor)
        elif cursor.spelling in ("operator++", "operator--", "operator!"):
            self.unary(cursor)
        elif cursor.spelling != "operator()":
            self.binary(operands, of_numbers=False)

    def index(self, cursor: Cursor) -> None:
        closing = self.tokens.ending(end_of(cursor))
        if closing is not None and closing.text == "]":
            self.add("index", closing.start, closing.start, " + 1")

    def number(self, cursor: Cursor) -> None:
        token = self.tokens.at(start_of(cursor))
        if self.message or token is None or not re.fullmatch(r"0|[1-9]\d*", token.text):
            return
        value = int(token.text)
        self.add("constant", token.start, token.end, str(value + 1))
        if value > 0:
            self.add("constant", token.start, token.end, str(value - 1))

    def boolean(self, cursor: Cursor) -> None:
        token = self.tokens.at(start_of(cursor))
        if not self.message and token is not None and token.text in NEGATED_BOOLS:
            self.add("constant", token.start, token.end, NEGATED_BOOLS[token.text])

    def name(self, cursor: Cursor) -> None:
        token = self.tokens.at(cursor.location.offset)
        if self.message or token is None:
            return
        if token.text in RENAMED and (cursor.kind == CursorKind.OVERLOADED_DECL_REF or
                                      (cursor.referenced is not None and cursor.referenced.kind in CALLABLE)):
            text, operator = RENAMED[token.text]
            self.add(operator, token.start, token.end, text)
        elif re.fullmatch(r"k[A-Z]\w*", token.text) and cursor.type.get_canonical().kind in NUMBERS:
            self.add("constant", start_of(cursor), token.end, f"({self.written(start_of(cursor), token.end)} + 1)")

    def written(self, start: int, end: int) -> str:
        return "".join(token.text for token in self.tokens.between(start, end))


class Reader:
    """Finds the sites of one file in a translation unit."""

    def __init__(self, unit: TranslationUnit, path: str, source: str):
        self.path, self.source = path, source
        self.tokens = SourceTokens(unit, path)
        self.sites: list[Site] = []
        self.scope(unit.cursor)
        self.sites.sort()

    def scope(self, scope: Cursor) -> None:
        """Searches a namespace or class for the bodies of functions."""
        for cursor in scope.get_children():
            file = cursor.location.file
            if file is None or file.name != self.path:
                continue
            if cursor.kind in SCOPES:
                self.scope(cursor)
            elif cursor.kind in FUNCTIONS and cursor.is_definition() and cursor.spelling not in SKIPPED_FUNCTIONS:
                for child in cursor.get_children():
                    first = self.tokens.at(start_of(child))
                    if first is not None and first.text in ("{", "try") and child.kind.is_statement():
                        self.statement(child)  # not a body that a macro expands to

    def statement(self, cursor: Cursor) -> None:
        kind = cursor.kind
        children = list(cursor.get_children())
        first = self.tokens.at(start_of(cursor))
        if first is None:
            return
        if kind == CursorKind.COMPOUND_STMT and first.text == "{" or kind in (
                CursorKind.CXX_TRY_STMT, CursorKind.CXX_CATCH_STMT, CursorKind.UNEXPOSED_STMT):
            for child in children:
                self.statement(child)
        elif kind in (CursorKind.IF_STMT, CursorKind.WHILE_STMT, CursorKind.FOR_STMT, CursorKind.SWITCH_STMT,
                      CursorKind.CXX_FOR_RANGE_STMT):
            self.control(cursor, children)
        elif kind == CursorKind.DO_STMT:
            self.statement(children[0])
            self.expression(children[-1], start_of(children[-1]), end_of(children[-1]), "condition")
        elif kind in (CursorKind.CASE_STMT, CursorKind.DEFAULT_STMT, CursorKind.LABEL_STMT):
            self.statement(children[-1])
        elif kind == CursorKind.DECL_STMT:
            for child in children:
                self.declaration(child)
        elif kind != CursorKind.NULL_STMT and not kind.is_declaration():
            self.plain(cursor)

    def plain(self, cursor: Cursor) -> None:
        """A statement up to its semicolon, or a macro's call that expands to statements."""
        semicolon = self.tokens.following(end_of(cursor))
        if semicolon is not None and semicolon.text == ";":
            self.expression(cursor, start_of(cursor), semicolon.end, "statement")

    def control(self, cursor: Cursor, children: list[Cursor]) -> None:
        """if, while, for, switch: the condition, and what it controls."""
        head = self.tokens.head(start_of(cursor))
        if head is None:
            return
        opening, closing, semicolons = head
        parts = list(zip([opening, *semicolons], [*semicolons, closing]))
        condition = None
        if cursor.kind == CursorKind.FOR_STMT:
            condition = parts[1] if len(parts) == 3 else None
        elif cursor.kind in (CursorKind.IF_STMT, CursorKind.WHILE_STMT) and \
                self.tokens.before(opening).text != "constexpr":
            condition = parts[-1]
        for child in children:
            start, end = start_of(child), end_of(child)
            if start > closing:
                self.statement(child)
            elif condition is not None and child.kind == CursorKind.VAR_DECL:
                self.declaration(child)
                condition = None  # its name, which clang has as an expression of its own, cannot be replaced
            elif condition is not None and condition[0] < start and end <= condition[1] and child.kind.is_expression():
                self.expression(child, start, end, "condition")

    def declaration(self, cursor: Cursor) -> None:
        """The value of a variable that is declared with =, unless it is computed by the compiler or only once."""
        if cursor.kind in SCOPES and cursor.kind != CursorKind.UNEXPOSED_DECL:
            self.scope(cursor)  # a class inside a function
            return
        words = {token.text for token in self.tokens.between(start_of(cursor), cursor.location.offset)}
        if cursor.storage_class == StorageClass.STATIC or "constexpr" in words:
            return
        for value in [child for child in cursor.get_children() if child.kind.is_expression()][-1:]:
            before, first = self.tokens.before(start_of(value)), self.tokens.at(start_of(value))
            if before.text == "=" and first is not None and first.text != "{":
                self.expression(value, start_of(value), end_of(value), "value")
            else:
                self.lambdas(value)

    def expression(self, cursor: Cursor, start: int, end: int, form: str) -> None:
        """Adds a site. If it contains lambdas, only the statements of their bodies are sites."""
        if self.lambdas(cursor):
            return
        changes = list(Changes(self.tokens, start, end, cursor).found)
        text = self.source[start:end]
        if form == "condition":
            changes.append(Change("negated condition", start, end, f"!({text})"))
        if form == "statement" and not text.startswith(("return", "throw")):
            changes.append(Change("left out", start, end, ";"))
        self.sites.append(Site(start, end, form, tuple(changes)))

    def lambdas(self, cursor: Cursor) -> bool:
        found = False
        for child in [cursor] if cursor.kind == CursorKind.LAMBDA_EXPR else cursor.get_children():
            if child.kind == CursorKind.LAMBDA_EXPR:
                found = True
                for part in child.get_children():
                    if part.kind == CursorKind.COMPOUND_STMT:
                        self.statement(part)
            else:
                found = self.lambdas(child) or found
        return found


def parse(path: str, arguments: list[str]) -> TranslationUnit:
    unit = Index.create().parse(path, args=arguments)
    errors = [str(one) for one in unit.diagnostics if one.severity >= one.Error]
    if errors:
        raise ParseError(f"{path} cannot be read: {errors[0]}")
    return unit


def source_of(path: pathlib.Path) -> str:
    """A character for each byte, since bytes are what libclang counts."""
    return path.read_bytes().decode("latin-1")


def bytes_of(source: str) -> bytes:
    """The inverse of source_of."""
    return source.encode("latin-1")


def files_of(unit: TranslationUnit) -> set[str]:
    return {unit.spelling} | {one.include.name for one in unit.get_includes()}


def sites_of(unit: TranslationUnit, path: str) -> list[Site]:
    """The sites of a file that the unit holds."""
    return Reader(unit, path, source_of(pathlib.Path(path))).sites
