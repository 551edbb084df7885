"""What comments cite is there: `[shaders/README: HEADING]` names a heading of framework/shaders/README.md, and files that
the two pages of theory name exist."""

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
    missing = [f"{file.relative_to(ROOT)}: {heading}" for file in tracked_sources()
               for heading in citations(file.read_text()) if heading not in known]
    assert not missing


def test_a_heading_that_is_not_there_would_be_found():
    assert citations("// see\n// [shaders/README: No such\n/// heading]") == ["No such heading"]
    assert "No such heading" not in headings()


def test_files_named_by_the_pages_exist():
    missing = []
    for page in (THEORY, ROOT / "framework/README.md"):
        for name in re.findall(r"`([\w/]+\.(?:glsl|comp|cpp|h|py|ocio))`", page.read_text()):
            places = [page.parent / name, ROOT / name, ROOT / "passes" / name, ROOT / "framework" / name,
                      ROOT / "framework/shaders" / name]
            if not any(place.is_file() for place in places):
                missing.append(f"{page.relative_to(ROOT)}: {name}")
    assert not missing
