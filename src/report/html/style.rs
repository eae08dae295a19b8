//! The style of all pages.

/// The style of all pages: light and dark, narrow and wide, screen and paper.
pub(super) const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#1b1f24;--dim:#57606a;--line:#d0d7de;--held:#116329;--drawn:#7d4e00;--not:#a40e26;--paper:#fff}
@media(prefers-color-scheme:dark){:root{--ink:#e6edf3;--dim:#9da7b1;--line:#3d444d;--held:#56d364;--drawn:#e3b341;--not:#ff7b72;--paper:#0d1117}}
body{font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:76rem;margin:0 auto;padding:1rem;overflow-wrap:anywhere}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;overflow-wrap:normal}
th,td{padding:.3rem .7rem;border-bottom:1px solid var(--line);text-align:right;vertical-align:top}
th[scope=row]{font-weight:normal;min-width:10rem}th:first-child,td:first-child,.words{text-align:left}.number{white-space:nowrap}
small{display:block;color:var(--dim)}
.held{color:var(--held)}.drawn{color:var(--drawn)}.not{color:var(--not);font-weight:bold}
dl.numbers{display:grid;grid-template-columns:repeat(auto-fill,minmax(16rem,1fr));gap:.8rem;padding:0;margin:1rem 0}
.numbers.five{grid-template-columns:repeat(auto-fill,minmax(12.8rem,1fr))}
.numbers div{border:1px solid var(--line);border-radius:.4rem;padding:.5rem .9rem}
.numbers dt{color:var(--dim);font-size:.875rem}.numbers dd{margin:0;font-size:1.25rem;font-variant-numeric:tabular-nums}
.numbers dd.meaning{color:var(--dim);font-size:.875rem;line-height:1.35}
.verdict{font-size:1.25rem;font-weight:bold;border-left:.4rem solid;padding-left:.8rem}
dt{color:var(--dim)}dd{margin:0 0 .5rem}
@media(max-width:44rem){table{font-size:.875rem}th,td{padding:.3rem .4rem}th:first-child,td:first-child{padding-left:0}}
@media(min-width:44rem){dl{display:grid;grid-template-columns:fit-content(50%) 1fr;gap:.3rem 1.4rem}dd{margin:0}}
@media(max-width:44rem){.cards,.cards tbody{display:block}.cards thead{display:none}
.cards tr{display:block;padding:.4rem 0;border-bottom:1px solid var(--line)}
.cards td{display:flex;justify-content:space-between;gap:1rem;border:0;padding:.1rem 0;text-align:right;white-space:normal}
.cards td::before{content:attr(data-of);color:var(--dim);text-align:left}.cards td:first-child{font-weight:600}.cards td:empty{display:none}}
.row{display:flex;flex-wrap:wrap;gap:0 1.5rem;align-items:flex-start}.row>div{flex:1 1 34rem;min-width:0}
summary{cursor:pointer;padding:.3rem 0}details{margin:.8rem 0}
.wide{overflow-x:auto;margin:.8rem 0}pre{overflow-x:auto;font-size:.85rem}figure{margin:1rem 0}svg{max-width:100%;height:auto}
";

/// On paper nothing scrolls, and pictures and rows stay whole.
pub(super) const PAPER: &str = "\
@media print{details::details-content{display:block;content-visibility:visible}
:root{font-size:11px}body{font-size:1rem;padding:0}.wide{overflow:visible}pre{white-space:pre-wrap;overflow:visible}
figure,pre,tr,.verdict{break-inside:avoid}h2,h2+p{break-after:avoid}}";
