"""Prints the version of Python, the number of faults in a robot.py, and the syntax error, if any.

Reads the file and the modules beside it that it imports, and runs none of them. A fault is a syntax
error, a module that is not installed, or a name that is not defined. Runs in Python 2.7 and 3.
"""
from __future__ import print_function

import sys

# `python -c` searches the current folder first. Nothing there may replace a module of Python.
sys.path[:] = [folder for folder in sys.path if folder]

import ast
import os
import warnings

try:
    import builtins
    from importlib.util import find_spec
except ImportError:  # Python 2
    import __builtin__ as builtins
    from pkgutil import find_loader as find_spec

# More than other faults of a file.
SYNTAX_ERROR = 1000
# Only the dictionaries of Python 2 have these methods.
METHODS = {"has_key", "iteritems", "iterkeys", "itervalues"} - set(dir(dict))
# The fields of nodes with the names that they define.
FIELDS = ("id", "name", "asname", "arg", "vararg", "kwarg")
# The endings of modules without source.
COMPILED = (".pyc", ".pyd", ".so")


def inside(tree, is_outer):
    """Returns the nodes in nodes of a kind."""
    outer = [node for node in ast.walk(tree) if is_outer(type(node).__name__, node)]
    return {node for part in outer for node in ast.walk(part)}


def is_main(kind, node):
    """Returns true for `if __name__ == ...`, which is false in a robot."""
    return kind == "If" and any(getattr(name, "id", "") == "__name__" for name in ast.walk(node.test))


def faults(path, checked):
    """Returns the undefined names and the missing modules, also of modules in the same folder."""
    checked.add(path)
    with open(path, "rb") as source:
        tree = compile(source.read(), path, "exec", ast.PyCF_ONLY_AST, True)
    compile(tree, path, "exec", 0, True)
    # A program that runs in both tries the names of one, then those of the other.
    tried = inside(tree, lambda kind, node: kind in ("Try", "TryExcept") or is_main(kind, node))
    late = inside(tree, lambda kind, node: kind in ("FunctionDef", "AsyncFunctionDef"))
    used, defined, modules, loaded = set(), set(dir(builtins)), set(), set()
    for node in ast.walk(tree):
        if not (isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)):
            names = [getattr(node, field, None) for field in FIELDS]
            defined.update(name.split(".")[0] for name in names if isinstance(name, str))
        elif node not in tried:
            used.add(node.id)
        if node in tried:
            continue
        imported = set()
        if isinstance(node, ast.Import):
            imported = {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            imported = {node.module.split(".")[0]}
        elif isinstance(node, ast.Attribute) and node.attr in METHODS:
            used.add("." + node.attr)
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.RShift):
            # In Python 3, `print >> file, text` shifts the function print.
            used.update(["print >>"] if getattr(node.left, "id", "") == "print" else [])
        modules |= imported
        loaded |= imported if node not in late else set()
    found = {name for name in used - defined if not name.startswith("__")}
    folder = os.path.dirname(path)
    others = [name for name in os.listdir(folder) if is_module(os.path.join(folder, name))]
    others = {name.split(".")[0] for name in others}
    for module in modules:
        beside = os.path.join(folder, module + ".py")
        if os.path.isfile(beside):
            try:
                found |= faults(beside, checked) if beside not in checked else set()
            except SyntaxError:
                # The robot may never call the function that imports the module.
                if module in loaded:
                    raise
                found.add("import " + module)
        elif not (module in others or module in sys.modules or find_spec(module)):
            found.add("import " + module)
    return found


def is_module(path):
    """Returns true for a package and for a module without source."""
    return os.path.isdir(path) or path.endswith(COMPILED)


def main():
    path, count, error = os.path.abspath(sys.argv[1]), 0, ""
    warnings.simplefilter("ignore")
    try:
        count = len(faults(path, set()))
    except SyntaxError as found:
        place = (os.path.basename(found.filename or path), found.lineno, found.msg)
        count, error = SYNTAX_ERROR, "%s, line %s: %s" % place
    except (TypeError, ValueError) as found:  # null bytes
        count, error = SYNTAX_ERROR, str(found)
    except Exception:
        pass  # The robot will report it.
    print("%d.%d" % sys.version_info[:2], count, error)


if __name__ == "__main__":
    main()
