"""Programs as code of this Python: those in Python 2 are converted by lib2to3, with Python 2's division."""

from __future__ import annotations

import ast
import re
import warnings
from functools import cache
from pathlib import Path
from types import CodeType
from typing import Any, Final

from bridge.config import read_limited
from bridge.errors import ConfigurationError

_OLD: Final = (
    re.compile(r"(^|[;:])\s*print\s+[^(\s=]", re.MULTILINE),
    re.compile(r"(^|[;:])\s*print\s*$", re.MULTILINE),
    re.compile(r"^\s*except\s+[\w.()\s,]+,\s*\w+\s*:", re.MULTILINE),
    re.compile(r"(^|[;:])\s*raise\s+\w+\s*,", re.MULTILINE),
    re.compile(r"(^|[;:])\s*exec\s+[\"'\w]", re.MULTILINE),
    re.compile(r"<>"),
    re.compile(r"\bur['\"]"),
    re.compile(r"[=(,\s]0[0-7]+\b"),
    re.compile(r"^\s*global\s", re.MULTILINE),
)
"""What Python 3 no longer reads."""
_UNCLOSED: Final = "unterminated"
"""Begins Python 3's error of a text without an end, which Python 2 does not read either."""
_OLD_NAMES: Final = {"raw_input", "xrange", "unicode", "unichr", "basestring", "long", "execfile"}
_OLD_ATTRIBUTES: Final = {"has_key", "iteritems", "itervalues", "iterkeys"}
_OLD_MODULES: Final = {"urllib2", "ConfigParser", "Queue", "Tkinter", "StringIO", "cPickle", "Image"}
"""What Python 3 reads and does not have."""
_DIVISION: Final = re.compile(r"^from __future__ import .*\bdivision\b", re.MULTILINE)
_SPARED: Final = {"lib2to3.fixes.fix_import"}
"""It would make imports of a program's own files relative."""
_RENAMED: Final = (
    (r"\bImage\.fromstring\(", "Image.frombytes("),
    (r"(?m)^import Image\b", "from PIL import Image"),
    (r"\b(np|numpy)\.fromstring\(\s*(?:str\((\w+)\)|(\w+))", r"\1.frombuffer(\2\3"),
)
"""Names of PIL and numpy that have gone, and what they are called now."""


MAX_PROGRAM: Final = 1 << 20
"""bytes of a program."""


def program_code(path: Path) -> CodeType:
    """The code of a program.

    Raises:
        ConfigurationError: it cannot be read, or is no Python program.
    """
    source = read_limited(path, MAX_PROGRAM, f"give a Python program of at most {MAX_PROGRAM} bytes")
    return compiled(source, str(path))


def compiled(source: bytes, name: str) -> CodeType:
    """The code of a source in Python 3 or 2.

    Args:
        source: in UTF-8.
        name: of the file, for errors.

    Raises:
        ConfigurationError: it is no Python program.
    """
    text = source.decode("utf-8", "replace")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # escapes that are none were usual
        try:
            code = compile(text, name, "exec", dont_inherit=True)
        except (SyntaxError, ValueError) as error:
            old = isinstance(error, TabError) or any(pattern.search(text) for pattern in _OLD)
            if old and not str(error).startswith(_UNCLOSED):
                return _from_python2(text, name)
            raise _no_program(name, error) from None
        return _from_python2(text, name) if _is_old(ast.parse(text)) else code


def _no_program(name: str, error: Any) -> ConfigurationError:
    """The error of a file, with what Python's parser said, or one of lib2to3's two."""
    reason, line = getattr(error, "msg", str(error)), getattr(error, "lineno", None)
    if hasattr(error, "context"):  # its parser
        line = error.context[1][0]
    elif line is None and len(error.args) == 2:  # its tokenizer
        reason, (line, _) = error.args
    place = f", line {line}" if line else ""
    return ConfigurationError(f"{name}{place}: {reason}; this is no Python program.")


def _is_old(tree: ast.Module) -> bool:
    """Whether a source that Python 3 reads needs what only Python 2 has."""
    own = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id in _OLD_NAMES - own:
            return True
        bare = node.value if isinstance(node, ast.Expr) else node.left if isinstance(node, ast.BinOp) else None
        if isinstance(bare, ast.Name) and bare.id == "print":  # `print` alone, or `print >>file, ...`
            return True
        if isinstance(node, ast.Attribute) and node.attr in _OLD_ATTRIBUTES:
            return True
        if isinstance(node, ast.Import) and any(alias.name in _OLD_MODULES for alias in node.names):
            return True
        if isinstance(node, ast.ImportFrom) and node.module in _OLD_MODULES:
            return True
    return False


@cache
def _converter() -> Any:
    from lib2to3.refactor import RefactoringTool, get_fixers_from_package

    return RefactoringTool([f for f in get_fixers_from_package("lib2to3.fixes") if f not in _SPARED])


def _from_python2(text: str, name: str) -> CodeType:
    lines = (line.expandtabs(8) if line[:1].isspace() else line for line in text.splitlines())
    try:
        converted = str(_converter().refactor_string("\n".join(lines) + "\n", name))
    except ImportError:
        raise ConfigurationError(
            f"{name} is written for Python 2, and this Python has no lib2to3 to convert it; run `2to3 -w` of "
            "Python 3.12 or older on it first."
        ) from None
    except Exception as error:  # lib2to3's parser has errors of its own, without a common class
        raise _no_program(name, error) from None
    for old, new in _RENAMED:
        converted = re.sub(old, new, converted)
    try:
        tree = ast.parse(converted, name)
        tree = _OldMeaning(floor=not _DIVISION.search(text)).visit(tree)
        return compile(ast.fix_missing_locations(tree), name, "exec", dont_inherit=True)
    except (SyntaxError, ValueError) as error:
        raise _no_program(name, error) from None


class _OldMeaning(ast.NodeTransformer):
    """What Python 2 meant and lib2to3 leaves: integers divided, letters that are bytes, `global` anywhere.

    Args:
        floor: a quotient of integers is an integer.
    """

    def __init__(self, *, floor: bool) -> None:
        self._floor = floor

    def visit_Module(self, node: ast.Module) -> ast.AST:
        """No `global` in the module's own block; the helper's import behind the docstring."""
        self.generic_visit(node)
        node.body = [statement for statement in node.body if not isinstance(statement, ast.Global)]
        _clear_globals(node)
        place = int(ast.get_docstring(node) is not None)
        helpers = [ast.alias(name, f"_python2_{name}") for name in ("divide", "ordinal")]
        node.body.insert(place, ast.ImportFrom(f"{__package__}.source", helpers, 0))
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        """`ord` takes a byte of a picture, too, which was a letter."""
        if node.id == "ord" and isinstance(node.ctx, ast.Load):
            return ast.copy_location(ast.Name("_python2_ordinal", ast.Load()), node)
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Its `global` first."""
        self.generic_visit(node)
        names = _clear_globals(node)
        if names:
            node.body.insert(0, ast.Global(names))
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """A quotient of integers is an integer."""
        self.generic_visit(node)
        if not (self._floor and isinstance(node.op, ast.Div)):
            return node
        function = ast.Name("_python2_divide", ast.Load())
        return ast.copy_location(ast.Call(function, [node.left, node.right], []), node)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.AST:
        """`a /= b` of a name."""
        self.generic_visit(node)
        if not (self._floor and isinstance(node.op, ast.Div) and isinstance(node.target, ast.Name)):
            return node
        value = ast.BinOp(ast.Name(node.target.id, ast.Load()), ast.Div(), node.value)
        return ast.copy_location(ast.Assign([node.target], self.visit_BinOp(value)), node)


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


def ordinal(value: Any) -> int:
    """The number of a letter, or of a byte."""
    return value if isinstance(value, int) else ord(value)


def divide(a: Any, b: Any) -> Any:
    """A quotient as Python 2 gives it: of two integers the integer below."""
    return a // b if isinstance(a, int) and isinstance(b, int) else a / b
