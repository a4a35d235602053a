"""The report as one HTML page: figures drawn here as SVG, no script, no font, no file besides.

Report ─> html.page ─┬─ section (one experiment) ─┬─ diagram  work-precision, convergence, profile ─> svg, axes
                     │                            ├─ scaling  cost over size, crossovers ─> svg
                     │                            └─ tables   points, extremes, omissions
                     └─ style: light, dark, print
"""
