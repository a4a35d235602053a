"""Experiments on what importers do, for `lucarna report`: a module here with an EXPERIMENT is one, named as its file.

They lie here because the engine's own (engine/experiments) may not know the importers; `lucarna report` includes both.

    importers.cli.report -> engine.experiments.harness.registry.include("importers.experiments") -> found by name
"""
