"""Programs as code of this Python: their encoding, and whether they are in Python 2."""

from __future__ import annotations

import ast
import importlib.util
import warnings
from collections.abc import Iterator
from pathlib import Path
from types import CodeType
from typing import Final

from bridge.files import read_limited
from nao_hil.naoqi_programs.conversion import from_python2, no_program, own_names, with_imports

_UNCLOSED: Final = "unterminated"
"""Begins Python 3's error of a text without an end, which Python 2 does not read either."""
_OLD_NAMES: Final = {
    *("raw_input", "xrange", "unicode", "unichr", "basestring", "long", "execfile", "cmp", "reload")
}
_OLD_ATTRIBUTES: Final = {"has_key", "iteritems", "itervalues", "iterkeys", "setdefaultencoding"}
_OLD_MODULES: Final = {
    *("urllib2", "ConfigParser", "Queue", "Tkinter", "StringIO", "cPickle", "Image", "thread", "SocketServer"),
    *("SimpleHTTPServer", "BaseHTTPServer", "commands", "httplib", "HTMLParser", "tkMessageBox", "cStringIO"),
}
"""Names that Python 3 reads and does not have."""
_NEW_MODULES: Final = {
    *("asyncio", "builtins", "concurrent", "configparser", "dataclasses", "enum", "http", "pathlib", "queue"),
    *("socketserver", "tkinter", "typing"),
}
"""Modules that Python 2 does not have."""


MAX_PROGRAM: Final = 1 << 20
"""bytes of a program."""


def program_code(path: Path) -> CodeType:
    """The code of a program.

    Raises:
        ConfigurationError: it cannot be read, or is no Python program.
    """
    return compiled(read_source(path), str(path), old=None)


def read_source(path: Path) -> bytes:
    """The bytes of a program.

    Raises:
        ConfigurationError: it cannot be read, or is too long.
    """
    return read_limited(path, MAX_PROGRAM, f"give a Python program of at most {MAX_PROGRAM} bytes")


def compiled(source: bytes, name: str, *, old: bool | None = False, package: Path | None = None) -> CodeType:
    """The code of a source in Python 3 or 2.

    Args:
        source: in the encoding that it names (PEP 263), else UTF-8 or Latin-1.
        old: whether it is in Python 2 if both read it; None: unless it uses qi without the vendor's SDK.
        package: folder of the package that it is in; Python 2 looks there for imports first.

    Raises:
        ConfigurationError: it is no Python program.
    """
    text = _decoded(source, name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # invalid escapes are usual in Python 2
        tree = _parsed(text, name, old=old)
        try:
            return compile(with_imports(tree, package), name, "exec", dont_inherit=True)
        except SyntaxError as error:  # of a meaning, such as a `return` outside a function
            raise no_program(name, error) from None


def is_old(code: CodeType) -> bool:
    """Whether code is converted from Python 2."""
    return "_python2" in code.co_names


def _decoded(source: bytes, name: str) -> str:
    try:
        return importlib.util.decode_source(source)
    except UnicodeDecodeError:
        return importlib.util.decode_source(b"# coding: latin-1\n" + source).removeprefix("# coding: latin-1\n")
    except (SyntaxError, LookupError) as error:
        raise no_program(name, error) from None


def _parsed(text: str, name: str, *, old: bool | None) -> ast.Module:
    try:
        tree = ast.parse(text, name)
        compile(tree, name, "exec", dont_inherit=True)
    except (SyntaxError, ValueError) as error:
        if str(error).startswith(_UNCLOSED) or "\0" in text:
            raise no_program(name, error) from None
        return from_python2(text, name, error)
    if _is_old(tree):
        return from_python2(text, name)
    if old is None:
        old = _imports(tree, "naoqi") or not _imports(tree, "qi")  # the SDK is for Python 2 alone
    if _is_new(tree, text) or not old:
        return tree
    return from_python2(text, name) if importlib.util.find_spec("lib2to3") else tree


def _modules(tree: ast.Module) -> Iterator[str]:
    """Modules that a source imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module


def _imports(tree: ast.Module, module: str) -> bool:
    return any(name.partition(".")[0] == module for name in _modules(tree))


def _is_old(tree: ast.Module) -> bool:
    """Whether a source that Python 3 reads needs a feature of Python 2."""
    own = own_names(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id in _OLD_NAMES - own:
            return True
        bare = node.value if isinstance(node, ast.Expr) else node.left if isinstance(node, ast.BinOp) else None
        if isinstance(bare, ast.Name) and bare.id == "print":  # `print` alone, or `print >>file, ...`
            return True
        if isinstance(node, ast.Attribute) and node.attr in _OLD_ATTRIBUTES:
            return True
        literal = node.value if isinstance(node, ast.Attribute) and node.attr == "decode" else None
        if isinstance(literal, ast.Constant) and isinstance(literal.value, str):
            return True
    return any(name in _OLD_MODULES for name in _modules(tree))


_NEW_NODES: Final = (
    *(ast.JoinedStr, ast.AnnAssign, ast.Nonlocal, ast.AsyncFunctionDef, ast.YieldFrom, ast.NamedExpr),
    *(ast.Match, ast.MatMult),
)


def _is_new(tree: ast.Module, text: str) -> bool:
    """Whether a source has syntax of Python 3, or one with another meaning there: `print(a, b)`, `input()`."""
    if text.startswith("#!") and "python3" in text.partition("\n")[0]:
        return True
    for node in ast.walk(tree):
        if isinstance(node, _NEW_NODES):
            return True
        if isinstance(node, ast.FunctionDef):
            annotated = [*node.args.args, *node.args.kwonlyargs]
            if node.returns or node.args.kwonlyargs or any(each.annotation for each in annotated):
                return True
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            several = len(node.args) > 1 or bool(node.keywords)
            named = {keyword.arg for keyword in node.keywords}
            if (
                (node.func.id == "print" and several and "from __future__" not in text)
                or node.func.id == "input"
                or (node.func.id == "super" and not node.args)
                or (node.func.id == "open" and named & {"encoding", "errors", "newline"})
            ):
                return True
        if isinstance(node, ast.Raise) and node.cause is not None:
            return True
    return any(name.partition(".")[0] in _NEW_MODULES for name in _modules(tree))
