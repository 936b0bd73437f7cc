/// The report's style sheet: light and dark, wide and narrow, screen and paper.
#pragma once

namespace loopline {

inline constexpr const char* report_style = R"css(
:root { color-scheme: light dark;
  --page: #f6f8fa; --card: #ffffff; --ink: #1d242c; --quiet: #5b6673; --rule: #dde3e9; --soft: #eef2f5;
  --estimate: #0072b2; --odometry: #c98a00; --start: #009e73; --end: #d55e00; --band: #0072b2;
  --good: #00734f; --good-bg: #e1f4ec; --warn: #8a5300; --warn-bg: #fff3d6; --bad: #a32f00; --bad-bg: #fde8df; }
@media (prefers-color-scheme: dark) { :root {
  --page: #11161b; --card: #1a2128; --ink: #e6ebf0; --quiet: #9aa7b4; --rule: #313b45; --soft: #242d36;
  --estimate: #56b4e9; --odometry: #f0b429; --start: #2dc79b; --end: #ff8a45; --band: #56b4e9;
  --good: #6fdcb4; --good-bg: #123328; --warn: #ffcf70; --warn-bg: #3a2c10; --bad: #ffab85; --bad-bg: #42200f; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); font: 16px/1.5 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 1120px; margin: 0 auto; padding: 28px 20px 48px; }
header { margin-bottom: 20px; }
h1 { font-size: 1.75rem; line-height: 1.2; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 36px 0 12px; }
p { margin: 4px 0; }
a { color: var(--estimate); }
.quiet { color: var(--quiet); }
.badge { display: inline-block; padding: 2px 12px; border-radius: 99px; font-size: .85rem; font-weight: 600; vertical-align: middle; margin-left: 8px; white-space: nowrap; }
.good { color: var(--good); background: var(--good-bg); } .warn { color: var(--warn); background: var(--warn-bg); } .bad { color: var(--bad); background: var(--bad-bg); }
.alert { border-left: 5px solid currentColor; border-radius: 6px; padding: 10px 16px; margin: 10px 0; overflow-wrap: anywhere; }
.alert b { display: block; } .alert span { color: var(--ink); }
.tiles { margin-top: 16px; display: grid; grid-template-columns: repeat(auto-fill, minmax(158px, 1fr)); gap: 12px; }
.tile { background: var(--card); border: 1px solid var(--rule); border-radius: 10px; padding: 12px 16px; }
.tile .value { font-size: 1.45rem; font-weight: 650; line-height: 1.25; white-space: nowrap; font-variant-numeric: tabular-nums; }
.tile .value small { font-size: .95rem; font-weight: 500; color: var(--quiet); }
.tile .name { color: var(--quiet); font-size: .85rem; line-height: 1.35; }
figure { margin: 0; background: var(--card); border: 1px solid var(--rule); border-radius: 10px; overflow: hidden; break-inside: avoid; }
figure img { display: block; width: 100%; height: auto; background: #fff; }
figcaption { padding: 8px 14px; font-size: .9rem; color: var(--quiet); border-top: 1px solid var(--rule); }
.pictures, .plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 430px), 1fr)); gap: 16px; align-items: start; }
.plots figure:only-child { max-width: 640px; } .pictures figure:last-child:nth-child(2) { grid-column: 1 / -1; }
.pictures figure:first-child { grid-column: 1 / -1; }
.corrections { margin-top: 16px; } .pictures.corrections figure:first-child { grid-column: auto; }
td .badge { margin-left: 0; }
.plots figure { padding: 12px 12px 0; } .plots figcaption { border: 0; padding: 2px 4px 12px; }
.plots.three { grid-template-columns: repeat(auto-fit, minmax(min(100%, 310px), 1fr)); margin-top: 16px; }
.stack { display: grid; gap: 16px; }
.plots h3 { margin: 0 0 6px 4px; font-size: .95rem; }
svg { display: block; width: 100%; height: auto; } svg text { fill: var(--quiet); font-size: 12.5px; } svg text.label { fill: var(--ink); }
svg path { fill: none; } .grid { stroke: var(--rule); stroke-width: 1; } .axis { stroke: var(--quiet); stroke-width: 1; }
path.estimate, path.odometry { stroke-width: 2; stroke-linejoin: round; stroke-linecap: round; }
path.estimate { stroke: var(--estimate); } path.odometry { stroke: var(--odometry); stroke-dasharray: 6 5; stroke-linecap: butt; }
svg path.band { fill: var(--band); fill-opacity: .2; } circle.start { fill: var(--start); } circle.end { fill: var(--end); }
.key::before { content: ""; display: inline-block; width: 22px; height: 0; border-top: 3px solid currentColor; margin: 0 6px 4px 10px; vertical-align: middle; }
.key.estimate::before { border-color: var(--estimate); } .key.odometry::before { border-top-style: dashed; border-color: var(--odometry); }
.key.start::before, .key.end::before { width: 10px; height: 10px; border: 0; border-radius: 9px; margin-bottom: 2px; }
.key.start::before { background: var(--start); } .key.end::before { background: var(--end); }
.wide { overflow-x: auto; background: var(--card); border: 1px solid var(--rule); border-radius: 10px; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: 7px 14px; text-align: right; border-bottom: 1px solid var(--rule); } tr:last-child td { border-bottom: 0; }
th { color: var(--quiet); font-weight: 600; font-size: .85rem; } th:first-child, td:first-child, .left { text-align: left; }
td.size { white-space: nowrap; }
td.hash { font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: .8rem; overflow-wrap: anywhere; min-width: 15em; text-align: left; }
.bar { display: block; height: 8px; min-width: 2px; border-radius: 4px; background: var(--estimate); }
td.share { width: 30%; min-width: 90px; }
details { background: var(--card); border: 1px solid var(--rule); border-radius: 10px; padding: 10px 16px; margin: 12px 0; }
summary { cursor: pointer; font-weight: 600; } pre { overflow-x: auto; font: .82rem/1.45 ui-monospace, "DejaVu Sans Mono", monospace; margin: 12px 0 4px; }
ul.files { columns: 3 240px; list-style: none; margin: 0; padding: 14px 16px; background: var(--card); border: 1px solid var(--rule); border-radius: 10px; }
ul.files li { break-inside: avoid; padding: 2px 0; overflow-wrap: anywhere; }
footer { margin-top: 36px; color: var(--quiet); font-size: .85rem; }
@media (max-width: 560px) { main { padding: 18px 12px 32px; } h1 { font-size: 1.4rem; } .badge { margin-left: 0; }
  .tiles { grid-template-columns: repeat(2, 1fr); } .tile { padding: 10px 12px; } .tile .value { font-size: 1.2rem; } th, td { padding: 6px 10px; } }
@media print { :root { --page: #fff; --card: #fff; --ink: #000; --quiet: #444; --rule: #bbb; --soft: #eee; --estimate: #0072b2; --odometry: #c98a00; }
  body { font-size: 11pt; } main { max-width: none; padding: 0; } h2 { break-after: avoid; } .tile, table, .alert { break-inside: avoid; }
  .pictures, .plots { grid-template-columns: 1fr 1fr; } .plots.three { grid-template-columns: 1fr 1fr 1fr; } }
)css";

}  // namespace loopline
