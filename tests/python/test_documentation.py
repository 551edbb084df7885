"""What pages and comments cite is there: links between pages, `[shaders/README: HEADING]`, a heading of
framework/shaders/README.md, and files that the two pages of theory name."""

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
THEORY = ROOT / "framework/shaders/README.md"
SOURCES = {".cpp", ".h", ".glsl", ".comp", ".py", ".md"}


def tracked_sources():
    names = subprocess.run(["git", "-C", ROOT, "ls-files", "-z"], capture_output=True, text=True, check=True).stdout
    files = [ROOT / name for name in names.split("\0") if Path(name).suffix in SOURCES]
    return [file for file in files if file.is_file() and file != Path(__file__)]


def headings():
    return set(re.findall(r"^#+ (.+)$", THEORY.read_text(), re.MULTILINE))


def citations(text):
    """Headings cited, whether or not the citation is broken over two comment lines."""
    joined = re.sub(r"\n\s*(?:///|//|#)?\s*", " ", text)
    return re.findall(r"\[shaders/README: ([^\]]+)\]", joined)


def test_every_cited_heading_exists():
    known = headings()
    missing = [
        f"{file.relative_to(ROOT)}: {heading}"
        for file in tracked_sources()
        for heading in citations(file.read_text())
        if heading not in known
    ]
    assert not missing


def test_a_heading_that_is_not_there_would_be_found():
    assert citations("// see\n// [shaders/README: No such\n/// heading]") == ["No such heading"]
    assert "No such heading" not in headings()


def test_files_named_by_the_pages_exist():
    missing = []
    for page in (THEORY, ROOT / "framework/README.md"):
        for name in re.findall(r"`([\w/]+\.(?:glsl|comp|cpp|h|py|ocio))`", page.read_text()):
            places = [
                page.parent / name,
                ROOT / name,
                ROOT / "passes" / name,
                ROOT / "framework" / name,
                ROOT / "framework/shaders" / name,
            ]
            if not any(place.is_file() for place in places):
                missing.append(f"{page.relative_to(ROOT)}: {name}")
    assert not missing


def anchors(page):
    """The names by which a page's headings are linked to, as code hosts make them."""
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    names = [
        re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        for heading in re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    ]
    return set(names)


def broken_links(page, text):
    """Links of the page that lead to no file or no heading."""
    broken = []
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        name, _, heading = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if "://" not in target and (not file.exists() or heading and heading not in anchors(file)):
            broken.append(target)
    return broken


def test_links_between_pages_lead_somewhere():
    pages = [file for file in tracked_sources() if file.suffix == ".md"]
    found = [f"{page.relative_to(ROOT)}: {link}" for page in pages for link in broken_links(page, page.read_text())]
    assert not found


def test_a_broken_link_would_be_found():
    page = ROOT / "README.md"
    assert broken_links(page, "[a](no/such.md) [b](#what-it-finds) [c](tests/README.md#no-such-heading)") == [
        "no/such.md",
        "tests/README.md#no-such-heading",
    ]
