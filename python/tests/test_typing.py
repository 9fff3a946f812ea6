"""The stubs say what is there, all of it and no more."""

import ast
import inspect
from pathlib import Path

import supple
from supple import _supple

STUB = Path(supple.__file__).with_name("_supple.pyi")


def stubs():
    """Class → member → names of its parameters; functions of the module under None."""
    tree = ast.parse(STUB.read_text())
    found = {}
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            found[node.name] = {
                f.name: parameters(f) for f in node.body if isinstance(f, ast.FunctionDef)
            }
    return found


def parameters(function):
    arguments = function.args
    names = [a.arg for a in arguments.posonlyargs + arguments.args + arguments.kwonlyargs]
    names += [a.arg for a in (arguments.vararg, arguments.kwarg) if a]
    return [name for name in names if name != "self"]


def there(kind):
    """Public members of a class, and their parameters where they have any."""
    found = {}
    for name, member in vars(kind).items():
        if name.startswith("_") and name not in ("__init__", "__new__", "__len__"):
            continue
        if name == "__new__" and kind.__text_signature__ is None:
            continue  # nobody makes one by hand
        if not callable(getattr(kind, name)):
            found[name] = []
            continue
        function = kind if name == "__new__" else getattr(kind, name)
        names = [p for p in inspect.signature(function).parameters if p not in ("self", "cls")]
        found["__init__" if name == "__new__" else name] = names
    return found


def test_stubs_and_classes_agree():
    written = stubs()
    classes = {n: c for n, c in vars(_supple).items() if inspect.isclass(c)}
    assert set(written) == set(classes)
    for name, kind in classes.items():
        found = there(kind)
        assert written[name] == found, name


def test_every_public_name_is_documented():
    for name in supple.__all__:
        thing = getattr(supple, name)
        if inspect.isclass(thing):
            assert thing.__doc__, name
            for member, value in vars(thing).items():
                if not member.startswith("_") and value is not None and not issubclass(thing, Exception):
                    assert inspect.getdoc(getattr(thing, member)), f"{name}.{member}"


def test_the_package_is_typed():
    assert STUB.with_name("py.typed").exists()
    assert supple.__version__.count(".") == 2
