# SPDX-License-Identifier: BSD-3-Clause
"""Files, links, headings and words to which the pages of the documentation refer exist."""

import os
import re

import pytest

from test_floors import ROOT, git_files

PAGES = git_files("*.md")
LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)\s]+)\)|!\[[^\]]*\]\(([^)\s]+)\)")
FENCE = re.compile(r"^ *```.*?^ *```$", re.MULTILINE | re.DOTALL)
# A word within `...` is taken for a path of this repository if it begins with one of its folders.
FOLDERS = sorted({name.split("/")[0] for name in git_files("*/*")})
PATH = re.compile(r"`((?:%s)/[^`\s]*)`" % "|".join(re.escape(folder) for folder in FOLDERS))


def read(page):
    with open(os.path.join(ROOT, page), encoding="utf-8") as source:
        return source.read()


def anchors(page):
    """Returns the anchors that GitHub and the site make of the headings of a page."""
    headings = re.findall(r"^#+ (.*)$", FENCE.sub("", read(page)), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def exists(path):
    """Returns whether a file or folder of the repository exists.

    In the path, <name> stands for any name, {a,b} for both a and b, and * for any text.
    """
    if path.startswith("build/"):
        return True
    pattern = re.escape(path.rstrip("/")).replace(r"\*", "[^/]*")
    pattern = re.sub(r"<\w+>", "[^/]+", pattern.replace(r"\<", "<").replace(r"\>", ">"))
    pattern = re.sub(r"\\{(.*?)\\}", lambda match: "(%s)" % match.group(1).replace(",", "|"), pattern)
    return any(re.match(pattern + "(/|$)", name) for name in git_files())


def test_there_are_pages():
    assert {"README.md", "CONTRIBUTING.md", "docs/architecture.md", "docs/terminology.md"} <= set(PAGES)


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    broken = []
    for link, picture in LINK.findall(FENCE.sub("", read(page))):
        target, _, anchor = (link or picture).partition("#")
        if re.match(r"\w+:", target):
            continue
        path = os.path.normpath(os.path.join(os.path.dirname(page), target)) if target else page
        if not os.path.exists(os.path.join(ROOT, path)) or (anchor and anchor not in anchors(path)):
            broken.append(link or picture)
    assert not broken, "%s: %s" % (page, broken)


@pytest.mark.parametrize("page", PAGES)
def test_files_that_are_named_exist(page):
    broken = [path for path in PATH.findall(FENCE.sub("", read(page))) if not exists(path)]
    assert not broken, "%s: %s" % (page, broken)


def test_every_page_has_a_place_in_the_site():
    listed = set(read("docs/site/index.md").split())
    pages = [page for page in PAGES if page.startswith("docs/") and not page.startswith("docs/site/")]
    assert not [page for page in pages if page[:-len(".md")] not in listed]


@pytest.mark.parametrize("page", [page for page in PAGES if page.startswith("docs/maths/")])
def test_every_section_on_maths_names_its_source_and_its_file(page):
    sections = re.split(r"^## ", read(page), flags=re.MULTILINE)[1:]
    assert sections
    for section in sections:
        name = section.splitlines()[0]
        assert "\nSource: " in section, "%s: %s has no source" % (page, name)
        assert re.search(r"`(src|include)/[^`]*\.[ch]pp`", section), "%s: %s names no file" % (page, name)


def terms():
    """Returns (word, meaning, file) of every row of docs/terminology.md."""
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \| `([^`]+)` \|$", read("docs/terminology.md"), re.MULTILINE)
    return [row for row in rows if row[0] != "word"]


def test_every_row_of_the_terminology_is_read():
    rows = [line for line in read("docs/terminology.md").splitlines() if line.startswith("| ")]
    assert len(terms()) == len([line for line in rows if not line.startswith("| word |")]) > 40


def words_of(text):
    """Returns a text in lower case, with spaces between the words of names: "own surface" for OwnSurface."""
    return re.sub(r"[\s_-]+", " ", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text)).lower()


@pytest.mark.parametrize("word,meaning,path", terms(), ids=[row[0] for row in terms()])
def test_the_terminology_is_true(word, meaning, path):
    assert meaning.endswith("."), "%s: a meaning is a sentence" % word
    assert os.path.exists(os.path.join(ROOT, path)), "%s: %s does not exist" % (word, path)
    assert words_of(word) in words_of(path + "\n" + read(path)), "%s does not occur in %s" % (word, path)
