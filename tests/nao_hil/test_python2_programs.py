"""Programs in Python 2 keep their meaning: text and bytes of one type, encodings, imports, names.

The expected values are what Python 2.7 gives, by its language reference and library.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from nao_hil.naoqi_programs.python2 import put_back
from nao_hil.naoqi_programs.source import compiled, is_old, program_code

pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # files left open
pytest.importorskip("lib2to3", reason="Python 3.13 has no lib2to3")


def run(source: str | bytes, **names: Any) -> dict[str, Any]:
    """The names of a program in Python 2 after its end."""
    data = source.encode() if isinstance(source, str) else source
    scope: dict[str, Any] = {"__name__": "program", **names}
    put_back()
    exec(compiled(data, "program.py", old=True), scope)
    return scope


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        (r'"Gr\xc3\xbc\xc3\x9fe".decode("utf-8")', "Grüße"),
        (r'u"Gr\xfc\xdfe".encode("utf-8") == "Gr\xc3\xbc\xc3\x9fe"', True),
        (r'repr(["\xff\x00"]), `"a"`', (r"['\xff\x00']", "'a'")),
        (r'len("\xff\x80"), ord("\xff"), chr(200) == "\xc8"', (2, 255, True)),
        ('len("Grüße"), len(u"Grüße")', (7, 5)),
        ('"6869".decode("hex"), "hi".encode("hex")', ("hi", "6869")),
        (r'"caf\xe9".decode("latin-1")', "café"),
        (r"'a\\u00e9'.decode('unicode-escape')", "aé"),
        (r'"C:\Users\nao".lower()', "c:\\users\nao"),
        (r'"C:\\Users\new"[3:8]', "Users"),
        ('unicode("x"), unicode("Grüße", "utf-8")', ("x", "Grüße")),
        ('isinstance("x", basestring), isinstance(u"x", unicode), isinstance(bytes("x"), str)', (True,) * 3),
        ("None < 0, 3 < 'a', max(2, 1) > None", (True, True, True)),
        ("round(2.5), round(-0.125, 2)", (3.0, -0.13)),
        ("sorted([3, 1, 2], lambda a, b: cmp(b, a))", [3, 2, 1]),
        ("7 / 2, 7 / 2.0, -7 / 2", (3, 3.5, -4)),
        ("{1: 2}.keys()[0], map(abs, [-1])[0], zip([1], [2])", (1, 1, [(1, 2)])),
    ],
)
def test_an_expression_has_the_value_of_python_2(expression: str, value: Any) -> None:
    assert run(f"x = {expression}\n")["x"] == value


def test_texts_go_to_and_come_from_functions_of_bytes() -> None:
    """A remote control's protocol: commands compared, binary numbers, a checksum, a table of commands."""
    scope = run(
        "import base64, binascii, hashlib, re, socket, struct, threading\n"
        "server = socket.socket(); server.bind(('127.0.0.1', 0)); server.listen(1)\n"
        "def pilot():\n"
        "    client = socket.create_connection(server.getsockname())\n"
        "    client.sendall('left,' + struct.pack('<f', -1.5))\n"
        "    client.shutdown(socket.SHUT_WR)\n"
        "thread = threading.Thread(target=pilot); thread.start()\n"
        "peer, _ = server.accept()\n"
        "data = ''\n"
        "while 1:\n"
        "    part = peer.recv(3)\n"
        "    if not part: break\n"
        "    data += part\n"
        "thread.join(); peer.close(); server.close()\n"
        "word, number = data.split(',', 1)\n"
        "turn = {'left': 1}[word] if word in ('left', 'right') else 0\n"
        "value = struct.unpack('<f', number)[0]\n"
        "matched = re.match('l.f', word).group()\n"
        "digest = hashlib.md5('a').hexdigest()\n"
        "coded = base64.b64encode('a') + binascii.hexlify('a')\n"
        "import json, urllib\n"
        "query = urllib.urlencode({'text': 'Gr\\xc3\\xbc'})\n"
        "told = json.dumps({'text': ['Gr\\xc3\\xbc']})\n"
        "import urllib2\n"
        "posted = urllib2.Request('http://nao.local/', 'a=b').get_method()\n"
        "from PIL import Image\n"
        "picture = Image.fromstring('RGB', (1, 1), '\\xff\\x00\\x00').getpixel((0, 0))\n"
    )
    assert scope["query"] == "text=Gr%C3%BC"  # RFC 3986
    assert (scope["told"], scope["posted"]) == (r'{"text": ["Gr\u00fc"]}', "POST")
    assert scope["picture"] == (255, 0, 0)
    assert (scope["word"], scope["turn"], scope["value"], scope["matched"]) == ("left", 1, -1.5, "lef")
    assert scope["digest"] == "0cc175b9c0f1b6a831c399e269772661"  # RFC 1321
    assert scope["coded"] == "YQ==61"


def test_a_function_may_import_all_names_of_a_module() -> None:
    source = "def area(r):\n    from math import *\n    return floor(pi * r), pi\n\nx = area(2)\n"
    assert run(source)["x"] == (6.0, math.pi)


def test_errors_and_names_are_those_of_python_2() -> None:
    scope = run(
        "import string, sys, time\n"
        "reload(sys); sys.setdefaultencoding('utf-8')\n"
        "try: raise ValueError('bad')\n"
        "except ValueError, e: said = e.message + e[0] + str(e.args)\n"
        "joined = string.join(string.split('a b'), '-') + string.letters[:2]\n"
        "values = [3, 1]; values.sort(lambda a, b: a - b)\n"
        "late = time.clock() >= 0\n"
        "exec 'y = 1'\n"
    )
    assert (scope["said"], scope["joined"]) == ("badbad('bad',)", "a-bab")
    assert (scope["values"], scope["late"], scope["y"]) == ([1, 3], True, 1)


@pytest.mark.parametrize(
    "source",
    [
        "# -*- coding: iso-8859-15 -*-\nx = u'Gr\xfc\xdfe \xa4'\nprint x\n".encode("latin-1"),
        "\ufeff# -*- coding: utf-8 -*-\r\nx = u'Grüße €'\r\n".encode(),
        "# vim: set fileencoding=cp1252 :\r\nx = u'Grüße €'\r\n".encode("cp1252"),
        "x = u'Grüße €'\nprint ''\n".encode(),
    ],
    ids=["iso-8859-15", "byte order mark", "cp1252", "utf-8 without a declaration"],
)
def test_a_source_is_read_in_its_encoding(source: bytes) -> None:
    assert run(source)["x"] == "Grüße €"


@pytest.mark.parametrize(
    ("source", "old"),
    [
        ("from naoqi import ALProxy\nx = 7 / 2\n", True),
        ("from naoqi import ALProxy\nprint('a', 1 / 2)\n", False),
        ("from naoqi import ALProxy\nname = f'{1}'\n", False),
        ("#!/usr/bin/env python3\nfrom naoqi import ALProxy\n", False),
        ("import qi\nx = 7 / 2\n", False),
        ("import qi\nprint 7 / 2\n", True),
        ("from robot import Hal\nh = Hal()\n", True),
        ("import qi\nqi.async(abs, 1)\n", True),
    ],
)
def test_the_python_of_a_program_is_recognized(tmp_path: Path, source: str, old: bool) -> None:
    program = tmp_path / "program.py"
    program.write_text(source)
    assert is_old(program_code(program)) is old
