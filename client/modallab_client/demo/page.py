"""The demo's page: one self-contained HTML file."""

from base64 import b64encode
from html import escape
from typing import TYPE_CHECKING, cast

from modallab_client import _tables
from modallab_client.demo import chapter_5, figures, hidden
from modallab_client.demo.chapter_5 import Chapter5
from modallab_client.demo.hidden import Case

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.55 system-ui, sans-serif; color: #1c2230; background: #fff; max-width: 860px;
  margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: .3rem; } h2 { font-size: 1.15rem; margin-top: 2.2rem; }
caption, figcaption, .soft { color: #667085; font-size: .88rem; text-align: left; }
table { border-collapse: collapse; margin: 1rem 0; width: 100%; font-size: .9rem; }
th, td { text-align: right; padding: .15rem .45rem; border-bottom: 1px solid #e1e4ea;
  font-variant-numeric: tabular-nums; }
th:first-child, td:first-child { text-align: left; }
figure { margin: 1rem 0; } img { width: 100%; height: auto; }
.two { display: grid; grid-template-columns: 1fr 1fr; gap: 1rem; }
.named { border-left: 4px solid #1d63c4; padding: .4rem 1rem; background: #f3f6fb; }
iframe { width: 100%; height: 75vh; border: 1px solid #d8dce4; }
"""


def page(chapter: Chapter5, case: Case, *, seed: int) -> str:
    """Return the demo's page, which loads nothing from elsewhere."""
    body = [
        "<h1>A beam, its test, its model</h1>",
        "<p class='soft'>Made by <code>modallab demo</code> over HTTP, "
        f"seed {seed}; the same seed makes the same page.</p>",
        *_test(chapter),
        *_update(chapter),
        *_diagnosis(case),
    ]
    head = f"<meta charset='utf-8'><title>modallab demo</title><style>{STYLE}</style>"
    return f"<!DOCTYPE html>\n<html lang='en'><head>{head}</head>\n<body>{''.join(body)}</body></html>\n"


def _test(chapter: Chapter5) -> list[str]:
    upper, _ = chapter.test.plot()
    last = len(chapter.modes.modes) - 1
    circle = figures.single_plot(
        lambda axes: figures.nyquist(axes, chapter.test, chapter.modes, mode=last, output=0), (6, 4.5)
    )
    return [
        "<h2>The test</h2>",
        "<p>A free steel beam of 20 elements, driven at node 1 by a shaker with an armature of 20 g through "
        "a force transducer of 10 g, heard by one accelerometer of 20 g that roves over 11 nodes. Hidden in "
        "it: elements 1 and 2 are twice as dense as the model has them, 11 and 12 twice as stiff.</p>",
        _figure(cast("Figure", upper.figure), "FRFs, and their coherence below"),
        _figure(circle, "A resonance as a circle: measured lines, and the mode fitted to them (Dobson)"),
        chapter_5.tables(chapter)[0].html(),
    ]


def _update(chapter: Chapter5) -> list[str]:
    _, before_update, location, after_update = chapter_5.tables(chapter)
    pictures = (
        (cast("Figure", chapter.before_update.plot().figure), "MAC of the model as given"),
        (cast("Figure", chapter.after_update.plot().figure), "MAC of the updated model"),
    )
    drawings = [
        figures.single_plot(lambda axes, part=part: figures.coefficients(axes, chapter.update, part))  # type: ignore[misc]
        for part in figures.WRONG
    ]
    words = (
        "Location moves macro elements of four elements each; those that move are suspected, and updating "
        "moves their elements one by one. The measured beam carries transducers that the model does not "
        "have, so that the coefficients cannot all come out at 2 and 1."
    )
    return [
        "<h2>Test and model compared, and the model updated</h2>",
        f"<div class='two'>{''.join(_figure(*picture) for picture in pictures)}</div>",
        before_update.html(),
        f"<p>{words}</p>",
        _figure(drawings[0], "Mass coefficients by iteration"),
        _figure(drawings[1], "Stiffness coefficients by iteration"),
        location.html(),
        after_update.html(),
    ]


def _diagnosis(case: Case) -> list[str]:
    diagnosis = case.diagnosis
    drawing = cast("Figure", diagnosis.plot()[0].figure)
    rows = [(hidden.sized(step.effect), hidden.share(step), *hidden.closed(step)) for step in diagnosis.steps]
    head = ("named", "probability", "gap", "gap on held-out FRFs")
    caption = f"Verdict: {diagnosis.verdict.replace('_', ' ')}. At a gap of 1 only random error is left."
    verdict = f"{hidden.outcome(case.hidden, diagnosis)} {hidden.compared(case.hidden, diagnosis)}"
    return [
        "<h2>A hidden effect named</h2>",
        f"<p class='named'>Hidden: <b>{escape(str(case.hidden))}</b>.<br>{escape(verdict)}</p>",
        _tables.html(head, rows, caption=caption),
        _figure(drawing, "The gap by step, where the model as given is off, and a response before and after"),
        "<details open><summary>The service's own report of this diagnosis</summary>"
        f'<iframe title="diagnosis" srcdoc="{escape(case.report)}"></iframe></details>',
    ]


def _figure(drawing: "Figure", words: str) -> str:
    # As an image: the marks of several drawings in one page would share their names.
    source = b64encode(figures.svg(drawing).encode()).decode()
    image = f"<img alt='{escape(words)}' src='data:image/svg+xml;base64,{source}'>"
    return f"<figure>{image}<figcaption>{escape(words)}</figcaption></figure>"
