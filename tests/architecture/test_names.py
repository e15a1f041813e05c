"""Names of the code: standard terms, nouns for values, one class a name."""

import ast
import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TREES = ("service/modallab", "client/modallab_client", "client/modallab_cli")
GENERATED = {"_sync", "_generated", "migrations"}

# Private words of earlier versions, and pictures where the field has a term.
RETIRED_TEXT = """
singly jointly collating measured_lines observing proposing located_words findings identified located
glimpses glimpse foreseen hanging hung knob panel turned nudged freedom clearing cleared settling
certainty put_right judging improves only_noise_left temperature several borne_out fewest
saturating widenings blurred downhill valleys effort further joint around built_in gone_through detuned
apart lessened judged tied smear rehearsals rehearsal dressing dressed strays drawn ringing succession
steadiness carried_over unbiased answering shot moment taken nearly_still sits alike_in_runs bursts
more_than plainer lookalike looks tries unleaked cleaners beyond concluding participating reach mixture
projection searched even_lines stretch circle law told_law wander doubled offered
common_share at_once whole above clear belief believe dividing idle refuse_blind turn few_rows kept
keeping lean losing jumps
"""
RETIRED = frozenset(RETIRED_TEXT.split())
# Bindings that say nothing of what they hold.
VAGUE_TEXT = """
one ones other others own left told seen rest same such each every all both none nothing something
anything everything it its this that these those what which who whom here there where given taken found
made kept asked held said known wanted needed meant done gone come put drawn shown weighed counted
allowed tried sought looked felt heard touched moved shared owned named called meaning being having
going apart alike alone away beside above below before after back further nearer later sooner
"""
VAGUE = frozenset(VAGUE_TEXT.split())
MOST_VAGUE = 0.025  # share of bindings; scikit-fem, pyMOR and httpx have about 0.005


def modules(tree: str) -> Iterator[tuple[Path, ast.Module]]:
    for path in sorted((ROOT / tree).rglob("*.py")):
        if not GENERATED & set(path.parts):
            yield path, ast.parse(path.read_text())


def bindings(module: ast.Module) -> Iterator[str]:
    for node in ast.walk(module):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif isinstance(node, ast.arg) and node.arg not in ("self", "cls"):
            yield node.arg


# Field names of the contract, and words of the standards that stay.
CONTRACT = {"located", "law"}


def definitions(path: Path, module: ast.Module) -> Iterator[str]:
    """Yield names of the module, its classes, functions and parameters."""
    yield path.stem
    yield path.parent.name
    for node in ast.walk(module):
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name
        elif isinstance(node, ast.arg):
            yield node.arg


@pytest.mark.parametrize("tree", TREES)
def test_a_class_name_stands_for_one_class(tree: str) -> None:
    names = Counter(
        node.name
        for _, module in modules(tree)
        for node in module.body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert [name for name, count in names.items() if count > 1] == []


def test_modules_classes_functions_and_parameters_have_standard_terms() -> None:
    retired = [
        f"{path.relative_to(ROOT)}: {name}"
        for tree in TREES
        for path, module in modules(tree)
        for name in definitions(path, module)
        if name.strip("_").lower() in RETIRED
    ]
    assert retired == []


def test_fields_on_the_wire_have_standard_terms() -> None:
    schemas = json.loads((ROOT / "docs" / "openapi.json").read_text())["components"]["schemas"]
    fields = {name for schema in schemas.values() for name in schema.get("properties", ())}
    assert fields & RETIRED - CONTRACT == set()


def test_bindings_are_nouns_of_the_domain() -> None:
    names = [name for tree in TREES for _, module in modules(tree) for name in bindings(module)]
    vague = [name for name in names if name.strip("_").lower() in VAGUE]
    assert len(vague) < MOST_VAGUE * len(names), Counter(vague).most_common(20)
