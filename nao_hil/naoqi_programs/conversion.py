"""Python 2 as syntax of this Python: lib2to3 converts it, and calls of `python2` keep its meaning."""

from __future__ import annotations

import ast
import builtins
import importlib.util
import io
import re
import tokenize
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from bridge.errors import ConfigurationError
from nao_hil.naoqi_programs.python2 import NAMES, to_str

_DIVISION: Final = re.compile(r"^from __future__ import .*\bdivision\b", re.MULTILINE)
_UNICODE: Final = re.compile(r"^from __future__ import .*\bunicode_literals\b", re.MULTILINE)
_NUMBERS: Final = re.compile(r"(?<=\[)[-+.,\s\[\]\deE]{200,}(?=\])")
"""Long lists of numbers, as in dances: lib2to3 is slow, and need not read them if none is octal."""
_OCTAL: Final = re.compile(r"(?<![\w.])0\d")
_SPARED: Final = {"lib2to3.fixes.fix_import", "lib2to3.fixes.fix_unicode"}
"""The first would make imports of a program's own files relative, the second forget which texts are unicode."""
_RENAMED: Final = (
    (r"\bImage\.fromstring\(", "Image.frombytes("),
    (r"(?m)^(\s*)import Image\b", r"\1from PIL import Image"),
    (r"\b(np|numpy)\.fromstring\(", r"\1.frombuffer("),
    (r"\b(?:np|numpy)\.(int|float|bool|object|str|complex)\b(?!_)", r"\1"),
    (r"\b[uU][rR](?=['\"])", "r"),
    (r"\.async\b", ".runAsync"),
    (r"\basync(?=\s*=[^=])", "async_"),
)
"""Names removed from PIL, numpy and qi, and their present names; words that are reserved now."""


def no_program(name: str, *errors: Any) -> ConfigurationError:
    """The error of a file: the message of the parser that read furthest, Python's or lib2to3's."""
    reasons = []
    for error in errors:
        reason, line = getattr(error, "msg", str(error)), getattr(error, "lineno", None)
        if hasattr(error, "context"):  # its parser
            line = error.context[1][0]
        elif line is None and len(error.args) == 2:  # its tokenizer
            reason, (line, _) = error.args
        reasons.append((line or 0, reason))
    line, reason = max(reasons, key=lambda item: item[0])
    place = f", line {line}" if line else ""
    return ConfigurationError(f"{name}{place}: {reason}; this is no Python program.")


def own_names(tree: ast.Module) -> set[str]:
    """Names that a program gives something to."""
    own = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            own.add(node.name)
        elif isinstance(node, ast.arg):
            own.add(node.arg)
        elif isinstance(node, ast.alias):
            own.add(node.asname or node.name)
    return own


@lru_cache
def _converter() -> Any:
    from lib2to3.refactor import RefactoringTool, get_fixers_from_package

    return RefactoringTool([f for f in get_fixers_from_package("lib2to3.fixes") if f not in _SPARED])


def from_python2(text: str, name: str, *errors: Exception) -> ast.Module:
    """The tree of a source in Python 2.

    Args:
        errors: those of Python 3's parser, if it is Python 2 only because Python 3 does not read it.

    Raises:
        ConfigurationError: it is no Python program, or this Python has no lib2to3.
    """
    lines = (line.expandtabs(8) if line[:1].isspace() else line for line in text.splitlines())
    numbers: list[str] = []

    def put_aside(found: re.Match[str]) -> str:
        if _OCTAL.search(found[0]):
            return found[0]
        numbers.append(found[0])
        return f"_numbers_{len(numbers) - 1}_" + "\n" * found[0].count("\n")

    try:
        short = _NUMBERS.sub(put_aside, "\n".join(lines) + "\n")
        converted = str(_converter().refactor_string(short, name))
    except ImportError:
        kind = f"cannot be read by Python 3 ({errors[0]})" if errors else "is written for Python 2"
        raise ConfigurationError(
            f"{name} {kind}, and this Python has no lib2to3, which converts Python 2; run `2to3 -w` of "
            "Python 3.12 or older on it first."
        ) from None
    except Exception as error:  # lib2to3's parser has errors of its own, without a common class
        raise no_program(name, *errors, error) from None
    for old, new in _RENAMED:
        converted = re.sub(old, new, converted)
    converted = re.sub(r"_numbers_(\d+)_\n*", lambda found: numbers[int(found[1])], converted)
    try:
        try:
            tree = ast.parse(converted, name)
        except SyntaxError as error:
            if "(unicode error)" not in str(error):  # as of "C:\\Users", which is a text of Python 2
                raise
            converted = _without_unicode_escapes(converted)
            tree = ast.parse(converted, name)
        meaning = _OldMeaning(converted, own_names(tree), text)
        meaning.visit(tree)
        return ast.fix_missing_locations(tree)
    except (SyntaxError, ValueError) as error:
        raise no_program(name, *errors, error) from None


def _without_unicode_escapes(text: str) -> str:
    r"""A source whose texts without `u` have no `\u`, `\U` and `\N`: Python 2 leaves them as they are."""
    lines = text.splitlines(keepends=True)
    for token in reversed(list(tokenize.generate_tokens(io.StringIO(text).readline))):
        if token.type != tokenize.STRING or re.match("b?[uUrR]", token.string):
            continue
        (first, begin), (last, end) = token.start, token.end
        plain = re.sub(r"(?<!\\)((?:\\\\)*)\\(?=[uUN])", r"\1\\\\", token.string)
        lines[first - 1 : last] = [lines[first - 1][:begin] + plain + lines[last - 1][end:]]
    return "".join(lines)


class _OldMeaning(ast.NodeTransformer):
    """The meaning of Python 2 that lib2to3 leaves out: calls of `python2`, and `global` anywhere.

    Args:
        original: its source in Python 2.
    """

    def __init__(self, text: str, own: set[str], original: str) -> None:
        self._lines = text.splitlines(keepends=True)
        self._own = own
        self._floor = not _DIVISION.search(original)
        self._unicode = bool(_UNICODE.search(original))
        self._errors: list[str] = []
        """Names of exceptions around the present node."""
        self._functions = 0
        """Around the present node."""

    def _python2(
        self, function: str, *arguments: ast.expr, at: ast.AST, named: list[ast.keyword] | None = None
    ) -> ast.expr:
        of = ast.Attribute(ast.Name("_python2", ast.Load()), function, ast.Load())
        return ast.copy_location(ast.Call(of, list(arguments), named or []) if arguments else of, at)

    def visit_Module(self, node: ast.Module) -> ast.AST:
        """No `global` in the module's own block; the import of `python2` behind the docstring."""
        self.generic_visit(node)
        node.body = [statement for statement in node.body if not isinstance(statement, ast.Global)]
        _clear_globals(node)
        place = int(ast.get_docstring(node) is not None)
        node.body.insert(place, ast.ImportFrom(__package__, [ast.alias("python2", "_python2")], 0))
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        """A text without `u` has bytes."""
        if not isinstance(node.value, str | bytes) or self._unicode or node.kind == "u":
            return node
        if isinstance(node.value, bytes):
            return ast.copy_location(ast.Constant(to_str(node.value)), node)
        if node.value.isascii():
            return node
        segment = ast.get_source_segment("".join(self._lines), node) or ""
        only_escapes = segment.isascii() and all(ord(letter) < 256 for letter in node.value)
        data = node.value.encode("latin-1" if only_escapes else "utf-8", "surrogateescape")
        return ast.copy_location(ast.Constant(to_str(data)), node)

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.AST:
        """Not Python 2: as it is."""
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        """A built-in function with the meaning of Python 2."""
        if node.id == "bytes" and node.id not in self._own:
            return ast.copy_location(ast.Name("str", node.ctx), node)
        if node.id in NAMES and node.id not in self._own and isinstance(node.ctx, ast.Load):
            return self._python2(NAMES[node.id], at=node)
        return node

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        """`error.message`."""
        self.generic_visit(node)
        of = node.value
        if node.attr == "message" and isinstance(of, ast.Name) and of.id in self._errors:
            return self._python2("message", of, at=node)
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        """`error[0]`."""
        self.generic_visit(node)
        if isinstance(node.value, ast.Name) and node.value.id in self._errors:
            node.value = ast.copy_location(ast.Attribute(node.value, "args", ast.Load()), node)
        return node

    def visit_ExceptHandler(self, node: ast.ExceptHandler) -> ast.AST:
        """Its error's name means an error within."""
        self._errors.append(node.name or "")
        self.generic_visit(node)
        self._errors.pop()
        return node

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """Calls of methods, and of functions that are imported."""
        self.generic_visit(node)
        function = node.func
        if isinstance(function, ast.Attribute) and function.attr in ("decode", "encode"):
            return self._python2(function.attr, function.value, *node.args, at=node, named=node.keywords)
        if isinstance(function, ast.Name):
            called = not hasattr(builtins, function.id) or function.id in ("bytearray", "memoryview")
        else:
            of = function.value if isinstance(function, ast.Attribute) else None
            called = of is not None and not (isinstance(of, ast.Name) and of.id == "_python2")
        return self._python2("call", function, *node.args, at=node, named=node.keywords) if called else node

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        """`a < b` of any two things."""
        self.generic_visit(node)
        order = _ORDERS.get(type(node.ops[0]))
        if len(node.ops) > 1 or order is None:
            return node
        return self._python2("less", ast.Constant(order), node.left, node.comparators[0], at=node)

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        """One with `__cmp__` has an order; its docstring remains a text, since Python 3 encodes it."""
        first = node.body[0]
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
            first.value.kind = "u"
        self.generic_visit(node)
        if any(isinstance(part, ast.FunctionDef) and part.name == "__cmp__" for part in node.body):
            node.decorator_list.insert(0, self._python2("ordered", at=node))
        return node

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.AST:
        """`from module import *` within a function: the names are the module's, as Python 3 has no others."""
        if not self._functions or node.names[0].name != "*":
            return node
        module = ast.Constant("." * node.level + (node.module or ""))
        names = ast.Call(ast.Name("globals", ast.Load()), [], [])
        return ast.copy_location(ast.Expr(self._python2("import_all", module, names, at=node)), node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Its `global` first."""
        self._functions += 1
        self.generic_visit(node)
        self._functions -= 1
        names = _clear_globals(node)
        if names:
            node.body.insert(0, ast.Global(names))
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """A quotient of integers is an integer."""
        self.generic_visit(node)
        if not (self._floor and isinstance(node.op, ast.Div)):
            return node
        return self._python2("divide", node.left, node.right, at=node)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.AST:
        """`a /= b` of a name."""
        self.generic_visit(node)
        if not (self._floor and isinstance(node.op, ast.Div) and isinstance(node.target, ast.Name)):
            return node
        of = ast.copy_location(ast.Name(node.target.id, ast.Load()), node)
        quotient = self._python2("divide", of, node.value, at=node)
        return ast.copy_location(ast.Assign([node.target], quotient), node)


_ORDERS: Final[dict[type, str]] = {ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge"}


def _clear_globals(block: ast.AST) -> list[str]:
    """Take the `global` statements out of a block, but not of functions within it; their names."""
    names: list[str] = []
    for node in ast.iter_child_nodes(block):
        if isinstance(node, ast.Global):
            names += node.names
            node.names = []
        elif not isinstance(node, ast.FunctionDef | ast.ClassDef | ast.expr):
            names += _clear_globals(node)
    for field, value in ast.iter_fields(block):
        if isinstance(value, list) and any(isinstance(one, ast.Global) for one in value):
            kept = [one for one in value if not (isinstance(one, ast.Global) and not one.names)]
            setattr(block, field, kept or [ast.Pass()])
    return names


def with_imports(tree: ast.Module, package: Path | None) -> ast.Module:
    """Make imports of modules of the same package relative; in Python 3 those not found alone."""
    if package is None:
        return tree
    old = any(isinstance(node, ast.ImportFrom) and node.module == __package__ for node in tree.body[:2])

    def beside(name: str) -> bool:
        """Whether a name means a module of the package."""
        top = name.partition(".")[0]
        there = (package / f"{top}.py").is_file() or (package / top / "__init__.py").is_file()
        return there and (old or importlib.util.find_spec(top) is None)

    class Relative(ast.NodeTransformer):
        """Imports."""

        def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.AST:
            """`from module import name`."""
            if not node.level and node.module and beside(node.module):
                node.level = 1
            return node

        def visit_Import(self, node: ast.Import) -> list[ast.stmt]:
            """`import module`."""
            relative = [alias for alias in node.names if beside(alias.name)]
            node.names = [alias for alias in node.names if alias not in relative]
            statements: list[ast.stmt] = [node] if node.names else []
            for alias in relative:
                top, _, rest = alias.name.partition(".")
                if rest:
                    inner, _, last = alias.name.rpartition(".")
                    statements.append(ast.ImportFrom(inner, [ast.alias(last, alias.asname or f"_{last}")], 1))
                if not (rest and alias.asname):
                    statements.append(ast.ImportFrom(None, [ast.alias(top, alias.asname)], 1))
            return [ast.copy_location(statement, node) for statement in statements]

    Relative().visit(tree)
    return ast.fix_missing_locations(tree)
