#pragma once

#include <string_view>

namespace stof::host {

// CSS of the pages: light and dark, wide and narrow, on paper.
inline constexpr std::string_view kStyleSheet = R"css(
:root{--paper:#fff;--ink:#1d2026;--soft:#5b626e;--line:#d9dce2;--panel:#f4f5f8;--link:#0b57b7;
--yes:#14794a;--partly:#9a5b00;--no:#b3261e;--unknown:#5b626e}
@media (prefers-color-scheme:dark){:root{--paper:#14161a;--ink:#e4e6ea;--soft:#a2a9b5;--line:#32363e;
--panel:#1d2026;--link:#7db4ff;--yes:#45c48a;--partly:#f0ad4e;--no:#ff8a80;--unknown:#a2a9b5}}
*{box-sizing:border-box}
html{scroll-behavior:smooth}
body{margin:0;background:var(--paper);color:var(--ink);line-height:1.5;
font-family:system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif;font-size:16px;
-webkit-text-size-adjust:100%;overflow-wrap:break-word}
header,main{max-width:74rem;margin:0 auto;padding:0 1.1rem}
h1{font-size:1.75rem;line-height:1.2;margin:2rem 0 .6rem}
h2{font-size:1.35rem;line-height:1.25;margin:0 0 .6rem}
h3{font-size:1.05rem;margin:1.8rem 0 .5rem}
p{max-width:46rem;margin:.5rem 0 .9rem}
a{color:var(--link);text-decoration:none}
a:hover{text-decoration:underline}
nav{display:flex;flex-wrap:wrap;gap:.35rem .5rem;margin:1rem 0 1.6rem}
nav a{border:1px solid var(--line);border-radius:1rem;padding:.1rem .7rem;font-size:.88rem}
section{border-top:1px solid var(--line);padding:1.6rem 0 1.2rem}
.scroll{overflow-x:auto;margin:.8rem 0 1.2rem}
table{border-collapse:collapse;font-size:.88rem;font-variant-numeric:tabular-nums}
.caption{color:var(--soft);font-size:.88rem;margin:1.1rem 0 -.5rem}
.scroll table:not(.verdicts) .t{white-space:nowrap}
th,td{padding:.26rem .7rem;border-bottom:1px solid var(--line);vertical-align:top}
th{color:var(--soft);font-weight:600;vertical-align:bottom}
.t{text-align:left}.n{text-align:right;white-space:nowrap}
th.n{white-space:normal;min-width:4.2rem;max-width:7rem}
tbody tr.group td{font-weight:600;background:var(--panel)}
.verdicts td:first-child{min-width:18rem}
.chip{display:inline-block;border:1.5px solid currentColor;border-radius:1rem;padding:0 .6rem;
font-weight:600;font-size:.85rem;white-space:nowrap}
.yes{color:var(--yes)}.partly{color:var(--partly)}.no{color:var(--no)}.unknown{color:var(--unknown)}
.claim{background:var(--panel);border-left:4px solid var(--link);border-radius:0 6px 6px 0;
padding:.7rem 1rem;margin:.8rem 0;max-width:60rem;break-inside:avoid}
dl{display:grid;grid-template-columns:minmax(8rem,11rem) 1fr;gap:.3rem 1rem;margin:0}
dt{color:var(--soft);font-size:.88rem;padding-top:.1rem}dd{margin:0}
.rule{color:var(--soft);font-size:.88rem}
.figures{display:grid;gap:1.2rem;margin:1rem 0 1.4rem}
.small{grid-template-columns:repeat(auto-fill,minmax(min(100%,17rem),1fr))}
.medium{grid-template-columns:repeat(auto-fill,minmax(min(100%,23rem),1fr))}
.large{grid-template-columns:repeat(auto-fill,minmax(min(100%,32rem),1fr))}
figure{margin:0;min-width:0;break-inside:avoid}
img{display:block;width:100%;height:auto;border-radius:4px;background:#14161a}
.pixels{image-rendering:pixelated}
.plot{display:block;width:100%;height:auto;color:var(--ink);font-size:13px}
.plot text{fill:currentColor}
.plot path{fill:none;stroke-linecap:round;stroke-linejoin:round}
.plot .grid{stroke:var(--line)}.plot .zero{stroke:var(--soft)}.plot .axes{stroke:currentColor}
figcaption{font-size:.86rem;color:var(--soft);margin-top:.35rem;line-height:1.4}
figcaption b{color:var(--ink)}
.bar{display:block;width:100%;height:auto;margin-top:.35rem;color:var(--ink)}
.key{display:flex;flex-wrap:wrap;gap:.15rem .9rem;font-size:.8rem;margin-top:.35rem}
.key span{display:inline-flex;align-items:center;gap:.35rem}
.key i{width:.85rem;height:.85rem;border-radius:2px;border:1px solid var(--line);display:inline-block}
@media (max-width:34rem){dl{grid-template-columns:1fr;gap:.1rem}dd{margin-bottom:.45rem}
body{font-size:15px}th,td{padding:.24rem .45rem}.verdicts td:first-child{min-width:13rem}}
@media print{:root{--paper:#fff;--ink:#000;--soft:#444;--line:#bbb;--panel:#f3f3f3;--link:#000;
--yes:#0a5c36;--partly:#7a4700;--no:#8f1d17;--unknown:#444}
body{font-size:10pt}header,main{max-width:none;padding:0}nav{display:none}
.small{grid-template-columns:repeat(3,1fr)}.medium,.large{grid-template-columns:repeat(2,1fr)}
.scroll{overflow:visible}tr,figure,.claim{break-inside:avoid}h2,h3{break-after:avoid}
*{-webkit-print-color-adjust:exact;print-color-adjust:exact}}
)css";

}  // namespace stof::host
