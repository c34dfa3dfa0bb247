"""Puts a page together: one HTML file with its styles, its modules and its data, that needs nothing else."""

from __future__ import annotations

import base64
import gzip
import html
import json
import re
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from .packing import pack

MODULES = (
    "unpack",
    "model",
    "colors",
    "camera",
    "world",
    "lanes",
    "machine",
    "sheets",
    "panels",
    "timeline",
    "player",
    "live",
    "main",
)
"""The page's modules, each after those that it imports."""
_IMPORT = re.compile(r"^import [^;]*;\n", re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(const|let|function|async|class) )", re.MULTILINE)


def make_page(content: Mapping[str, Any]) -> str:
    """The whole page of a run or a map. The same content gives the same page."""
    packed = gzip.compress(pack(content), mtime=0)
    title = str(content["about"]["title"])
    return _filled(title, {"mode": "file"}, base64.b64encode(packed).decode())


def make_live_page(title: str) -> str:
    """The page that asks the server it came from for what happens."""
    return _filled(title, {"mode": "live"}, "")


def _filled(title: str, settings: Mapping[str, str], data: str) -> str:
    parts = {
        "TITLE": html.escape(title),
        "STYLE": _asset("page.css"),
        "SETTINGS": json.dumps(settings),
        "DATA": data,
        "SCRIPT": script(),
    }
    return re.sub(r"\{\{([A-Z]+)\}\}", lambda found: parts[found[1]], _asset("page.html"))


def script() -> str:
    """All modules as one: what they import of one another stands before them, so imports are left out."""
    return "\n".join(f"// --- {name}.js\n{_inlined(_asset(f'{name}.js'))}" for name in MODULES)


def _inlined(module: str) -> str:
    return _EXPORT.sub("", _IMPORT.sub("", module))


def _asset(name: str) -> str:
    return files(__package__).joinpath("assets", name).read_text(encoding="utf-8")
