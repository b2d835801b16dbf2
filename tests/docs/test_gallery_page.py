"""The gallery's page shows what figures.json lists, says how to make what is not there, and warns
of a lost file.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

EXTENSIONS = Path(__file__).parents[2] / "docs" / "_extensions"
KEYS = ("name", "title", "source", "caption")


def entry(*words, file, measured=None):
    return dict(zip(KEYS, words, strict=True)) | {"file": file, "measured": measured}


MOVING = ("It moves", "not in the paper", "Round and round.")
PICTURE = ("first-look", "A first look", "figure 1", "It shows 3 mm.")


@pytest.fixture
def sources(tmp_path) -> Path:
    """A site of one page with the gallery, and one with a single picture."""
    folder = tmp_path / "source"
    (folder / "gallery").mkdir(parents=True)
    conf = f"import sys\nsys.path.insert(0, {str(EXTENSIONS)!r})\n"
    (folder / "conf.py").write_text(f"{conf}extensions = ['gallery']\nhtml_theme = 'basic'\n")
    page = "Gallery\n=======\n\n.. gallery-picture:: moving.gif\n\n.. gallery::\n"
    (folder / "index.rst").write_text(page)
    return folder


def listed(folder: Path, *lines: dict) -> None:
    (folder / "gallery" / "figures.json").write_text(json.dumps({"figures": lines}))


def told(page: str) -> str:
    """The words of a page."""
    return re.sub(r"<[^>]+>", "", page)


def built(folder: Path) -> tuple[str, str]:
    """The page, and what Sphinx had to say."""
    out = folder.parent / "html"
    command = [sys.executable, "-m", "sphinx", "-q", str(folder), str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return (out / "index.html").read_text(encoding="utf-8"), done.stderr


@pytest.mark.slow
def test_what_is_there_is_shown_with_source_caption_and_anchor_and_what_is_lost_is_a_warning(
    sources,
):
    Image.new("RGB", (4, 4)).save(sources / "gallery" / "first-look.png")
    Image.new("RGB", (4, 4)).save(sources / "gallery" / "moving.gif")
    (sources / "gallery" / "numbers.csv").write_text('surface,mean\nplywood,"0.25"\n')
    listed(
        sources,
        entry(*PICTURE, file="first-look.png", measured="turns.csv"),
        entry("numbers", "Some numbers", "Table I", "Two rows.", file="numbers.csv"),
        entry("moving", *MOVING, file="moving.gif"),
        entry("lost", *MOVING, file="lost.png"),
    )
    page, words = built(sources)
    assert words.count("WARNING") == 1 and "names lost.png, which is not there" in words
    assert 'id="figure-first-look"' in page and 'id="figure-numbers"' in page
    assert "_images/first-look.png" in page and page.count("_images/moving.gif") >= 2
    assert page.count('alt="It moves"') == 2
    assert "It shows 3 mm." in page and "Measured data: turns.csv." in page
    assert page.count("<tr") == 2 and "<th" in page and "0.25" in page
    assert "Figure 1. Made by cyclemap figures first-look." in told(page)


@pytest.mark.slow
def test_an_empty_gallery_says_how_to_make_it(sources):
    page, words = built(sources)
    assert words == ""
    assert told(page).count("cyclemap figures all --out docs/gallery") == 2
