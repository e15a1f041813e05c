"""`python -m modallab_client.demo`: the beam of the 1992 thesis, its update, and a diagnosed effect."""

import argparse
import sys
import time
from importlib.util import find_spec
from pathlib import Path

from modallab_client import ModalLab, _tables
from modallab_client.demo import chapter_5, hidden
from modallab_client.demo.chapter_5 import Chapter5
from modallab_client.demo.hidden import Case


def main(arguments: list[str] | None = None) -> None:
    """Run the demo: results on the terminal, a page and a picture in a folder."""
    parser = argparse.ArgumentParser(prog="modallab demo", description=__doc__)
    parser.add_argument("--seed", type=int, default=4, help="draws the noise and the hidden effect")
    parser.add_argument("--out", type=Path, default=Path("demo-out"), help="folder for the page")
    options = parser.parse_args(arguments)
    if options.seed < 0:
        parser.error("--seed is not negative")
    if find_spec("matplotlib") is None:
        parser.error("the demo draws with matplotlib: pip install 'modallab[plot]'")
    run(options.seed, options.out)


def run(seed: int, folder: Path) -> None:
    """Run the demo with a service of its own."""
    begin = time.monotonic()

    def say(text: str) -> None:
        _write(f"[{time.monotonic() - begin:5.1f} s] {text}")

    say("starting the service beside this process")
    with ModalLab.embedded() as lab:
        chapter = chapter_5.run(lab, seed=seed, say=say)
        _write(*(f"\n{table.text()}" for table in chapter_5.tables(chapter)), "")
        secret = hidden.draw(seed)
        case = hidden.run(lab, chapter.model_id, chapter.rig_id, secret, seed=seed, say=say)
        _write("", _summary(case), "")
    say("the service is stopped; drawing")
    page = _write_page(chapter, case, seed, folder)
    say(f"done: open {page.resolve()}")
    say(f"the diagnosis alone: {page.with_name('report.html').resolve()}")


def _summary(case: Case) -> str:
    """Return the diagnosis and the hidden truth as text."""
    diagnosis = case.diagnosis
    rows = [
        (hidden.sized(step.effect), hidden.share(step), *hidden.closed(step)) for step in case.diagnosis.steps
    ]
    table = _tables.text(("named", "probability", "gap", "gap on held-out FRFs"), rows)
    verdict = (
        f"Verdict: {diagnosis.verdict.replace('_', ' ')}; a gap of 1 means that only random error is left."
    )
    words = [verdict, table, *diagnosis.left_open(), "", f"Now the truth. Hidden was: {case.hidden}."]
    return "\n".join(
        [*words, hidden.outcome(case.hidden, diagnosis), hidden.compared(case.hidden, diagnosis)]
    ).rstrip()


def _write_page(chapter: Chapter5, case: Case, seed: int, folder: Path) -> Path:
    """Write the page and the picture; return the path of the page."""
    import matplotlib as mpl  # only now: the terminal need not wait for it

    mpl.use("agg")
    mpl.rcParams["svg.hashsalt"] = "modallab"  # the same seed writes the same page
    from modallab_client.demo import figures
    from modallab_client.demo.page import page

    folder.mkdir(parents=True, exist_ok=True)
    place = folder / "demo.html"
    place.write_text(page(chapter, case, seed=seed), encoding="utf-8")
    (folder / "report.html").write_text(case.report, encoding="utf-8")
    heading = f"Hidden: {case.hidden}. {hidden.outcome(case.hidden, case.diagnosis)}"
    assert case.diagnosis.curves is not None
    picture = figures.overview(
        chapter.test, chapter.modes, chapter.update, case.diagnosis.curves, heading=heading
    )
    (folder / "demo.png").write_bytes(picture)
    return place


def _write(*lines: str) -> None:
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
