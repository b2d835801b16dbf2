"""The notebooks run from the first cell to the last, as their page lists them."""

import json
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs" / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_draws(path: Path, tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.chdir(tmp_path)
    pyplot = pytest.importorskip("matplotlib.pyplot")
    names: dict[str, object] = {"__name__": "__main__"}
    written = json.loads(path.read_text(encoding="utf-8"))["cells"]
    cells = [cell for cell in written if cell["cell_type"] == "code"]
    assert len(cells) >= 3
    for number, cell in enumerate(cells):
        assert cell["outputs"] == [], "notebooks are kept without outputs"
        exec(compile("".join(cell["source"]), f"{path.name}, code cell {number}", "exec"), names)
    figures = [pyplot.figure(number) for number in pyplot.get_fignums()]
    try:
        assert figures and all(axes.has_data() for figure in figures for axes in figure.axes)
        for figure in figures:
            figure.canvas.draw()
    finally:
        pyplot.close("all")


def test_the_page_of_notebooks_gives_each_of_them() -> None:
    page = (NOTEBOOKS[0].parent / "index.md").read_text(encoding="utf-8")
    assert [path.name for path in NOTEBOOKS if path.name not in page] == []
    assert len(NOTEBOOKS) == 3
