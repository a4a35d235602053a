"""`python -m importers.cli` is `lucarna`."""

from __future__ import annotations

import sys

from importers.cli.main import main

sys.exit(main())
