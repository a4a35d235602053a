"""`python -m tests.stability`: the catalogue of numeric extremes as a markdown table, with the tests that guard it."""

from __future__ import annotations

from tests.stability.rows import markdown

if __name__ == "__main__":
    print(markdown())
