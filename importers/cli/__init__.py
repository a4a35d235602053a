"""The `lucarna` command: one module a subcommand, imported only when it is chosen. May import engine and importers.

    main     COMMANDS table, --help without heavy imports, errors -> stderr and exit code
    convert  sources -> our files             inspect  what is in a file           check   findings only
    render   scene -> picture                 play     a plain window              edit    the editor
    lights   many lights over a scene
    new      a project from the template      doctor   device and libraries        report  error against time
    interrupted  what a killed `mv` left is put back before any command looks at files
    cache    what the import cache holds      settings_flags   flags of imports, from importers/settings.py

A command module has `add_arguments(parser)` and `run(args) -> exit code`: 0 done, 1 some input is bad, 2 wrong usage,
3 could not run. Machine output (--json) alone goes to stdout; errors go to stderr.
"""
