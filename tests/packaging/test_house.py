"""The rules of the house that no other tool checks."""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
#: the folders that hold the product's Python packages
SOURCES = ("engine", "importers", "editor")


def package_inits() -> list[Path]:
    return sorted(init for name in SOURCES for init in (ROOT / name).rglob("__init__.py"))


def test_packaging_is_no_package() -> None:
    """With one, `import packaging.version` breaks for everything that runs from the root."""
    assert not list((ROOT / "packaging").rglob("__init__.py"))


def test_tests_are_no_packages() -> None:
    found = [p for p in (ROOT / "tests").rglob("__init__.py") if p.parent.name != "bench"]
    assert not found, "pytest imports tests by path; a package there shadows the product"


@pytest.mark.parametrize("init", package_inits(), ids=lambda p: str(p.parent.relative_to(ROOT)))
def test_every_package_says_what_it_is(init: Path) -> None:
    docstring = ast.get_docstring(ast.parse(init.read_text(encoding="utf-8")))
    assert docstring, f"{init} has no docstring: what it owns, what it may import"
    assert len(docstring) >= 40


def test_the_top_level_holds_only_what_is_agreed() -> None:
    folders = {p.name for p in ROOT.iterdir() if p.is_dir() and not p.name.startswith(".")}
    agreed = {"editor", "engine", "importers", "shaders", "project_template", "tests", "packaging", "docs"}
    made_by_running = {"build", "dist", "out", "lucarna-sample", "__pycache__"}
    assert agreed <= folders
    assert {f for f in folders if not f.endswith(".egg-info")} <= agreed | made_by_running


def test_the_layers_are_a_contract() -> None:
    contracts = PROJECT["tool"]["importlinter"]["contracts"]
    floors = [c for c in contracts if c["type"] == "layers" and c.get("containers") == ["engine"]]
    assert len(floors) == 1
    assert floors[0]["exhaustive"] is True
    named = {name.strip() for layer in floors[0]["layers"] for name in layer.split("|")}
    present = {p.parent.name for p in (ROOT / "engine").glob("*/__init__.py")}
    assert present <= named, "a package of the engine that stands on no floor"
    assert any(c["type"] == "forbidden" and "moderngl" in c["forbidden_modules"] for c in contracts)


def test_the_documents_are_there() -> None:
    for name in ("README.md", "CONTRIBUTING.md", "CONVENTIONS.md", "CHANGELOG.md", "LICENSE", "NOTICE"):
        assert (ROOT / name).stat().st_size > 500, name


def test_notice_names_every_dependency() -> None:
    notice = (ROOT / "NOTICE").read_text(encoding="utf-8").lower().replace("_", "-")
    for line in PROJECT["project"]["dependencies"]:
        name = line.split(">=")[0].split("==")[0].strip().lower().replace("_", "-")
        assert name in notice, f"NOTICE does not name {name}"
    assert "test engine" in notice


def text_files() -> list[Path]:
    suffixes = {".py", ".md", ".toml", ".yaml", ".glsl", ".vert", ".frag", ".comp", ".cfg", ""}
    skipped = {".git", ".venv", "out", "build", "dist", "lucarna-sample", "node_modules"}
    found = []
    for path in ROOT.rglob("*"):
        parts = path.relative_to(ROOT).parts
        if skipped & set(parts) or any(p.endswith("_cache") or p in {".cache", "__pycache__"} for p in parts):
            continue
        if path.is_file() and path.suffix in suffixes:
            found.append(path)
    return found


def test_nothing_names_one_machine() -> None:
    """Paths and hosts of the machine that something was written on mean nothing elsewhere."""
    forbidden = ["/wo" + "rk/", "/ro" + "ot/", "/home/" + "user", "C:\\\\Us" + "ers"]
    for path in text_files():
        if path.suffix == "" and path.name not in {"LICENSE", "NOTICE", "run"}:
            continue
        text = path.read_text(encoding="utf-8")
        for words in forbidden:
            assert words not in text, f"{path}: {words}"
