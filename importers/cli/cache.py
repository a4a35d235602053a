"""`lucarna cache info|prune`: what the caches of imports and shader programs hold, and making them smaller."""

from __future__ import annotations

import argparse
import time
from collections import Counter
from typing import Any

from engine.core.errors import UsageError
from importers.cli.output import print_json, size_text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("action", choices=("info", "prune"), help="info: what is there; prune: remove some of it")
    parser.add_argument("--max-size", metavar="SIZE", help="prune: remove the least recently used until all fits (5GB)")
    parser.add_argument("--older-than", metavar="AGE", help="prune: remove what was not used for so long (30d, 12h)")
    parser.add_argument("--dry-run", action="store_true", help="prune: say what would be removed")
    parser.add_argument("--json", action="store_true", help="print one JSON value instead of text")


def run(args: argparse.Namespace) -> int:
    from engine.core.paths import user_cache_dir
    from importers import cache_upkeep

    if args.action == "info":
        if args.max_size or args.older_than or args.dry_run:
            raise UsageError("these flags are for `lucarna cache prune`")
        kept = cache_upkeep.entries()
        _tell({"folder": str(user_cache_dir())} | _sums(kept), args.json)
        return 0
    if args.max_size is None and args.older_than is None:
        raise UsageError("nothing says what may go", hint="give --max-size 5GB or --older-than 30d")
    removed = cache_upkeep.prune(
        None if args.max_size is None else cache_upkeep.parse_size(args.max_size),
        None if args.older_than is None else cache_upkeep.parse_age(args.older_than),
        dry_run=args.dry_run,
    )
    left = sum(kept.size for kept in cache_upkeep.entries()) - (sum(k.size for k in removed) if args.dry_run else 0)
    if args.json:
        print_json({"removed": [str(k.path) for k in removed], "bytes": sum(k.size for k in removed), "left": left,
                    "dry_run": args.dry_run})  # fmt: skip
    else:
        words = "would be removed" if args.dry_run else "removed"
        total = sum(kept.size for kept in removed)
        print(f"{len(removed):,} entries, {size_text(total)} {words}; {size_text(left)} left")
    return 0


def _sums(kept: list[Any]) -> dict[str, Any]:
    counts, sizes = Counter(k.kind for k in kept), Counter[str]()
    for item in kept:
        sizes[item.kind] += item.size
    used = [item.used for item in kept if item.used]
    return {
        "entries": len(kept), "bytes": sum(sizes.values()),
        "parts": {kind: {"entries": counts[kind], "bytes": sizes[kind]} for kind in sorted(counts)},
        "litter": sum(item.litter for item in kept),
        "oldest_use_s_ago": round(time.time() - min(used)) if used else 0,
    }  # fmt: skip


def _tell(data: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(data)
        return
    print(f"{data['folder']}: {data['entries']:,} entries, {size_text(data['bytes'])}")
    for kind, part in data["parts"].items():
        print(f"  {kind:<10} {part['entries']:>8,} entries  {size_text(part['bytes']):>10}")
    if data["litter"]:
        print(f"  {data['litter']} left by processes that died; `lucarna cache prune` removes them")
    if data["oldest_use_s_ago"]:
        print(f"  the least recently used was used {data['oldest_use_s_ago'] / 86400:.1f} days ago")
