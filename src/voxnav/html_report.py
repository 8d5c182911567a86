# SPDX-License-Identifier: BSD-3-Clause
"""The parts of reports in HTML: single files that contain their pictures, so that they can be sent to somebody."""

from __future__ import annotations

import base64
import html
import io
from typing import Any, Iterable, Sequence

from voxnav.plotting import pyplot

_STYLE = """body{font-family:sans-serif;max-width:1100px;margin:2em auto;color:#222}
table{border-collapse:collapse}td,th{padding:.2em .8em;text-align:right;border-bottom:1px solid #ddd}
pre{white-space:pre-wrap}td:first-child,th:first-child{text-align:left}img{max-width:100%}"""


def head(title: str) -> str:
    """Returns the beginning of a page, with its title as heading."""
    return "<!doctype html><meta charset='utf-8'><title>%s</title><style>%s</style>\n<h1>%s</h1>" % (
        html.escape(title), _STYLE, html.escape(title))


def section(title: str) -> str:
    return "<h2>%s</h2>" % html.escape(title)


def paragraph(text: str) -> str:
    return "<p>%s</p>" % html.escape(text)


def preformatted(text: str) -> str:
    return "<pre>%s</pre>" % html.escape(text)


def bullets(lines: Iterable[str]) -> str:
    return "<ul>%s</ul>" % "".join("<li>%s</li>" % html.escape(line) for line in lines)


def table(rows: Iterable[Sequence[Any]], header: Iterable[str]) -> str:
    cells = "".join("<th>%s</th>" % html.escape(name) for name in header)
    body = "".join("<tr>%s</tr>" % "".join("<td>%s</td>" % html.escape(str(cell)) for cell in row) for row in rows)
    return "<table><tr>%s</tr>%s</table>" % (cells, body)


def png(data: bytes) -> str:
    """Returns the element of a picture, given as the content of a PNG file."""
    return '<img src="data:image/png;base64,%s">' % base64.b64encode(data).decode("ascii")


def image(figure: Any) -> str:
    """Returns the element of a Matplotlib figure, which is closed."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100, bbox_inches="tight")
    pyplot().close(figure)
    return png(buffer.getvalue())
