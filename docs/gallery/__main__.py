"""Write pictures and pages of all effects, and the pictures of correlation and extraction; `make docs`."""

from pathlib import Path

from docs.gallery import correlated, extracted
from docs.gallery.drawing import draw, png
from docs.gallery.pages import index, page
from modallab.rig.effect import EFFECTS

FOLDER = Path(__file__).parents[1] / "effects"


def main(folder: Path = FOLDER) -> None:
    """Write the gallery, and take away what no effect is behind any more."""
    folder.mkdir(exist_ok=True)
    pages = {"README.md": index().encode()}
    for kind in EFFECTS:
        pages |= {f"{kind}.md": page(kind).encode(), f"{kind}.png": png(draw(kind))}
    for path in folder.iterdir():
        if path.suffix in (".md", ".png") and path.name not in pages:
            path.unlink()
    for name, content in pages.items():
        (folder / name).write_bytes(content)


if __name__ == "__main__":
    main()
    (FOLDER.parent / "correlation.png").write_bytes(correlated.png(correlated.draw()))
    extracted.write()
