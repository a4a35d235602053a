"""`python -m tests.pruning --count 200`: random scenes, pruned against everything forced, equal to the bit.

Prints what was left out how often. Exit code 1 with the first scene that differs.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections import Counter
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, seed, settings

from engine.gpu import open_device
from tests.pruning.compare import paths_agree, pruned_equals_forced
from tests.pruning.scenes import SceneSpec, specs, write_textures
from tests.support.stage import Stage


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.pruning", description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="scenes to try (default 200)")
    parser.add_argument("--seed", type=int, default=1, help="another seed, other scenes (default 1)")
    parser.add_argument("--paths", action="store_true", help="compare the render paths instead")
    args = parser.parse_args(argv)
    left_out: Counter[str] = Counter()
    tried: set[SceneSpec] = set()
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        write_textures(Path(folder))
        stage = Stage(open_device("gl", debug=True))

        @seed(args.seed)
        @settings(
            max_examples=2 * args.count,
            deadline=None,
            database=None,
            suppress_health_check=[HealthCheck.too_slow],
            phases=[Phase.generate],
        )
        @given(specs)
        def compare(spec: SceneSpec) -> None:
            if spec in tried or len(tried) == args.count:
                return
            if args.paths:
                paths_agree(stage, spec, Path(folder))
                tried.add(spec)
                return
            pictures = pruned_equals_forced(stage, spec, Path(folder))
            tried.add(spec)
            left_out.update(item.name for item in pictures.left_out)

        try:
            compare()
        except AssertionError as error:
            print(f"not equal: {error}")
            for note in getattr(error, "__notes__", ()):
                print(note)
            return 1
        finally:
            stage.close()
            stage.device.release()
    print(f"{len(tried)} different scenes, all equal to the bit, in {time.perf_counter() - start:.0f} s")
    print("| left out | times |\n|---|---|")
    for name, times in left_out.most_common():
        print(f"| {name} | {times} |")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
