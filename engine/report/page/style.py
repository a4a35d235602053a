"""The page's style sheet: light, dark by the reader's setting, and print (always light)."""

from __future__ import annotations

_LIGHT = """
--paper:#fdfdfb; --plot:#ffffff; --ink:#1b1d21; --soft:#5b616b; --faint:#8b919b; --rule:#dcdedf; --grid:#eceded;
--reach:#1b1d2107; --good:#1a7f4b; --bad:#b3261e; --code:#f1f2f0;
--k0:#0b62a4; --k1:#c8500a; --k2:#0f8a6a; --k3:#a3338b; --k4:#8a6d00; --k5:#3f4fb5; --k6:#7a4a2b;
"""
_DARK = """
--paper:#15171a; --plot:#1a1d21; --ink:#e6e7e8; --soft:#a4a9b1; --faint:#7d838c; --rule:#33373d; --grid:#262a2f;
--reach:#ffffff08; --good:#5bc98c; --bad:#ff8a80; --code:#22262b;
--k0:#62aef0; --k1:#f59a5b; --k2:#4fcaa5; --k3:#dc8bcb; --k4:#d9bb4a; --k5:#98a4f5; --k6:#cfa17f;
"""

STYLE = (
    ":root{color-scheme:light dark;" + _LIGHT.replace("\n", "") + "}\n"
    "@media screen and (prefers-color-scheme:dark){:root{" + _DARK.replace("\n", "") + "}}\n"
    """
*{box-sizing:border-box}
html{background:var(--paper)}
body{margin:0 auto;max-width:1180px;padding:48px 32px 96px;color:var(--ink);background:var(--paper);
 font:16px/1.55 "Iowan Old Style","Palatino Linotype",Palatino,"Book Antiqua",Georgia,"DejaVu Serif",serif}
h1{font-size:34px;line-height:1.15;font-weight:600;margin:0 0 6px;letter-spacing:-.01em}
h2{font-size:23px;line-height:1.25;font-weight:600;margin:0 0 10px}
h2 .n{color:var(--faint);font-weight:400;margin-right:.55em}
h2 code{font-size:13px;font-weight:400;color:var(--soft);margin-left:.6em;vertical-align:2px}
h3,th,dt,figcaption,.lead,.badge,nav,table,svg text,.meta,.foot{
 font-family:"Inter","Helvetica Neue",Helvetica,"Segoe UI","DejaVu Sans",Arial,sans-serif}
h3{font-size:12.5px;font-weight:600;letter-spacing:.03em;color:var(--soft);margin:22px 0 6px}
.lead{font-size:14.5px;color:var(--soft);max-width:74ch;margin:0 0 22px}
.meta{font-size:13px;color:var(--soft);display:grid;grid-template-columns:max-content 1fr;gap:2px 16px;margin:0 0 28px}
.meta dt{color:var(--faint)} .meta dd{margin:0}
section{border-top:1px solid var(--rule);padding-top:30px;margin-top:46px}
dl.about{display:grid;grid-template-columns:78px 1fr;gap:3px 14px;margin:0 0 16px;font-size:15px;max-width:96ch}
dl.about dt{color:var(--faint);font-size:12.5px;padding-top:3px} dl.about dd{margin:0}
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(420px,1fr));gap:18px 26px;margin:10px 0 4px}
figure{margin:0;break-inside:avoid} .figures figure{max-width:600px}
figcaption{font-size:12.5px;line-height:1.45;color:var(--soft);margin-top:4px}
figcaption b{color:var(--ink);font-weight:600}
svg{display:block;width:100%;height:auto}
table{border-collapse:collapse;font-size:12.5px;font-variant-numeric:tabular-nums;margin:2px 0 6px;width:100%}
th{font-weight:600;text-align:left;color:var(--soft);border-bottom:1px solid var(--ink);padding:4px 12px 4px 0;
 vertical-align:bottom}
td{padding:3.5px 12px 3.5px 0;border-bottom:1px solid var(--rule);vertical-align:top}
td.r,th.r{text-align:right} td.o{white-space:nowrap} tr.default td{font-weight:600}
tr:last-child td{border-bottom-color:var(--ink)}
.scroll{overflow-x:auto}
code{font:12.5px/1.4 "JetBrains Mono","SF Mono",Consolas,"DejaVu Sans Mono",monospace;background:var(--code);
 padding:1px 4px;border-radius:3px}
.good{color:var(--good)} .bad{color:var(--bad)} .soft{color:var(--soft)}
ul.plain{margin:0;padding:0;list-style:none;font-size:14px} ul.plain li{padding:2px 0}
.pictures{display:flex;flex-wrap:wrap;gap:10px 14px;margin:8px 0 4px} .pictures figure{width:240px}
.pictures img{display:block;width:100%;height:auto;image-rendering:pixelated;border:1px solid var(--rule)}
a{color:inherit;text-decoration-color:var(--faint);text-underline-offset:2px}
.note{max-width:96ch;font-size:15px;margin:10px 0}
.foot{font-size:12px;color:var(--faint);margin-top:48px}
.plot{fill:var(--plot)} .grid{stroke:var(--grid);fill:none} .axis{stroke:var(--soft);fill:none;stroke-width:1}
svg text{fill:var(--soft);font-size:11.5px} svg .label{fill:var(--ink);font-size:12.5px}
svg .legend{fill:var(--ink);font-size:12px} svg .note{font-size:10px;fill:var(--soft)}
svg .note{paint-order:stroke;stroke:var(--plot);stroke-width:3px;
 stroke-linejoin:round}
.front{fill:none;stroke:var(--ink);stroke-width:1.1} .reach{fill:var(--reach);stroke:none}
.floor{fill:none;stroke:var(--faint);stroke-dasharray:1.5 3.5;stroke-linecap:round}
.slope{fill:none;stroke:var(--soft);stroke-width:1;stroke-dasharray:5 4}
.default{fill:none;stroke:var(--ink);stroke-width:1.4}
.dot{fill:var(--plot);stroke:var(--c);stroke-width:1.5} .dot.on{fill:var(--c)}
.line{fill:none;stroke:var(--c);stroke-width:1.6;stroke-linejoin:round}
.thread{fill:none;stroke:var(--c);stroke-width:1;opacity:.45} .bar{fill:none;stroke:var(--c);stroke-width:1.2}
.nan{fill:none;stroke:var(--c);stroke-width:1.7}
"""
    + "".join(f".c{i}{{--c:var(--k{i})}}" for i in range(7))
    + """
@media (max-width:560px){body{padding:28px 16px 64px}.figures{grid-template-columns:1fr}}
@media print{:root{color-scheme:light}@page{margin:16mm 14mm} html,body{background:none}
 body{max-width:none;padding:0;font-size:10.5pt} section{break-inside:auto;margin-top:26px;padding-top:18px}
 h2,h3,dl.about{break-after:avoid} tr,figure{break-inside:avoid} .scroll{overflow:visible}
 .figures{grid-template-columns:1fr 1fr} table{font-size:8.5pt} a{text-decoration:none}}
"""
)
