"""Damaged Ogre files: 300 seeded mutants of each kind; every one loads or says why not, and quickly."""

from __future__ import annotations

import random
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import pytest

from engine.core.errors import LucarnaError
from importers.ogre.reader import load
from importers.settings import ImportSettings
from tests.support.ogre_builder import MORPH_XML, OgreBytes, rigged

SETTINGS = ImportSettings(max_decoded_bytes=64 << 20)
MUTANTS = 300
SECONDS = 20


@contextmanager
def _deadline(seconds: int) -> Iterator[None]:
    """Ends a hang with an error, where the system has alarms."""
    if not hasattr(signal, "SIGALRM"):
        yield
        return

    def ring(number: int, frame: FrameType | None) -> None:
        raise AssertionError(f"still reading after {seconds} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def mutate(data: bytes, dice: random.Random) -> bytes:
    """One to four of: cut, flipped bits, random bytes, extremes of four bytes, deleted, doubled, filled runs."""
    out = bytearray(data)
    for _ in range(dice.randint(1, 4)):
        if len(out) < 8:
            break
        at, run = dice.randrange(len(out)), dice.choice((1, 2, 4, 16, 200))
        what = dice.randrange(7)
        if what == 0:
            del out[at:]
        elif what == 1:
            out[at] ^= 1 << dice.randrange(8)
        elif what == 2:
            out[at : at + run] = dice.randbytes(len(out[at : at + run]))
        elif what == 3:
            out[at : at + 4] = dice.choice(
                (b"\xff" * 4, b"\0" * 4, b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0\0\xc0\x7f")
            )
        elif what == 4:
            del out[at : at + run]
        elif what == 5:
            out[at:at] = out[at : at + run]
        else:
            out[at : at + run] = bytes([dice.randrange(256)]) * len(out[at : at + run])
    return bytes(out)


def _run(data: bytes, path: Path, seed: int) -> int:
    """How many of the mutants were refused."""
    dice, refused = random.Random(seed), 0
    for number in range(MUTANTS):
        path.write_bytes(mutate(data, dice))
        try:
            with _deadline(SECONDS):
                load(path, SETTINGS)
        except LucarnaError:
            refused += 1
        except Exception as error:
            raise AssertionError(f"mutant {number} of seed {seed}: {type(error).__name__}: {error}") from error
    return refused


@pytest.mark.parametrize("order", ["<", ">"])
def test_mutated_meshes(order: str, tmp_path: Path) -> None:
    mesh, skeleton = rigged(OgreBytes(order))
    (tmp_path / "t.skeleton").write_bytes(skeleton)
    assert 20 < _run(mesh, tmp_path / "t.mesh", 1) < MUTANTS - 20


def test_mutated_skeletons(tmp_path: Path) -> None:
    mesh, skeleton = rigged(OgreBytes())
    path = tmp_path / "t.mesh"
    path.write_bytes(mesh)
    dice = random.Random(2)
    for _ in range(MUTANTS):
        (tmp_path / "t.skeleton").write_bytes(mutate(skeleton, dice))
        with _deadline(SECONDS):
            load(path, SETTINGS)  # a broken skeleton never costs the mesh
    assert 20 < _run(skeleton, tmp_path / "u.skeleton", 3) < MUTANTS


def test_mutated_xml(tmp_path: Path) -> None:
    assert 20 < _run(MORPH_XML.encode(), tmp_path / "t.mesh.xml", 4) < MUTANTS


def test_mutated_scripts(tmp_path: Path) -> None:
    text = """abstract material Base { set $t a.png
      technique { pass { diffuse 1 0.5 0 1\n specular 1 1 1 30\n alpha_rejection greater 100
        texture_unit { texture $t\n scale 2 2\n rotate 30\n tex_address_mode clamp }
        texture_unit { texture n.png\n rtshader_system { normal_map tangent_space } } } } }
    material m : Base { set $t "b c.png"\n technique { pass { emissive 0 0 2 } } }"""
    path = tmp_path / "t.mesh"
    path.write_bytes(OgreBytes().square("m"))
    dice = random.Random(5)
    for _ in range(MUTANTS):
        (tmp_path / "m.material").write_bytes(mutate(text.encode(), dice))
        with _deadline(SECONDS):
            load(path, SETTINGS)


def test_mutated_real_files(shared_assets: Path, tmp_path: Path) -> None:
    folder = shared_assets / "ogre" / "models"
    (tmp_path / "robot.skeleton").write_bytes((folder / "robot.skeleton").read_bytes())
    assert _run((folder / "robot.mesh").read_bytes(), tmp_path / "robot.mesh", 6) < MUTANTS
