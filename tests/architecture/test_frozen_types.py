import ast

from tests.architecture.test_names import ROOT, TREES, modules


def test_a_frozen_type_sets_only_fields_that_it_has() -> None:
    """A renamed field of which the old name is still set would stay unchecked and writeable."""
    strangers = [
        f"{path.relative_to(ROOT)}: {cls.name}.{call.args[1].value!r}"
        for tree in TREES
        for path, module in modules(tree)
        for cls in ast.walk(module)
        if isinstance(cls, ast.ClassDef)
        for call in ast.walk(cls)
        if isinstance(call, ast.Call)
        and ast.unparse(call.func) == "object.__setattr__"
        and isinstance(call.args[1], ast.Constant)
        and call.args[1].value not in fields(cls)
    ]
    assert strangers == []


def fields(cls: ast.ClassDef) -> set[str]:
    return {
        node.target.id
        for node in cls.body
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
    }
