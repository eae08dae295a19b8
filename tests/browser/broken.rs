//! Small pages, each with one fault.
//!
//! Nothing here may depend on the fonts that are installed. Where the width of a text matters it is stated
//! (`textLength`) or exceeded many times; and there is room for letters up to twice as high as the font size says.

use crate::view::View;

const HEAD: &str = "<!DOCTYPE html><html lang=en><head><meta charset=utf-8><title>t</title><style>\
    :root{color-scheme:light dark;--ink:#111;--paper:#fff}\
    @media(prefers-color-scheme:dark){:root{--ink:#eee;--paper:#111}}\
    body{color:var(--ink);background:var(--paper);margin:16px;font:16px/3 sans-serif}\
    text{fill:var(--ink);font-size:14px}.wide{overflow-x:auto}</style></head><body>\
    <h1>Sound</h1><p>Some text that is long enough for a second line on a narrow screen, <b>with bold</b> words.</p>\
    <table><tr><th>a</th><td>b</td></tr></table>\
    <svg role=img aria-labelledby=n width=250 height=200><title id=n>Name</title><text x=10 y=40>one</text>\
    <text x=10 y=80>two</text><text x=100 y=180 textLength=160 transform='rotate(-45 100 180)'>turned</text>\
    <text x=100 y=80 textLength=20>in its corner</text></svg>";

/// A sound page with something added.
pub fn page(added: &str) -> String {
    format!("{HEAD}{added}</body></html>")
}

type Shown = fn(&View) -> bool;
type Fault = (&'static str, String, &'static str, Shown);

/// What is wrong, the page, the kind of fault, and in which views it is to be found.
pub fn faults() -> Vec<Fault> {
    let always: Shown = |_| true;
    let never: Shown = |_| false;
    let svg = |inside: &str| format!("<svg role=img aria-label=x width=200 height=100>{inside}</svg>");
    let wide = "<span style='display:inline-block;width:1400px;text-align:right'>far</span>";
    let mut all: Vec<Fault> = vec![
        ("nothing", String::new(), "", never),
        ("texts overlap", "<p style='margin-bottom:-60px'>first</p><p>second</p>".into(), "overlap", always),
        ("lines overlap", "<p style='line-height:.5'>one<br>two<br>three</p>".into(), "overlap", always),
        (
            "texts of a picture overlap",
            svg("<text x=10 y=50 textLength=60>first</text><text x=30 y=54 textLength=60>other</text>"),
            "overlap",
            always,
        ),
        (
            "a turned text overlaps",
            svg("<text x=50 y=90 textLength=80 transform='rotate(-90 50 90)'>turned</text><text x=20 y=50 textLength=60>level</text>"),
            "overlap",
            always,
        ),
        (
            "a text is cut at a side",
            format!("<p style='width:40px;overflow:hidden;white-space:nowrap'>{}</p>", "cut text ".repeat(20)),
            "cut",
            always,
        ),
        ("a text is cut below", "<div style='height:10px;overflow:clip'>cut</div>".into(), "cut", always),
        ("a picture cuts a text", svg("<text x=180 y=50 textLength=60>cut</text>"), "cut", always),
        ("a text begins left of the page", "<p style='margin-left:-40px'>left</p>".into(), "cut", always),
        ("a table scrolls, but not on paper", format!("<div class=wide>{wide}</div>"), "cut", |v| v.paper),
        ("the page is too wide", "<p style='width:500px'>far</p>".into(), "width", |v| v.width < 500),
        ("faint text", "<p style='color:#888;background:#999'>faint</p>".into(), "contrast", always),
        ("faint on dark only", "<p style='color:#444'>faint</p>".into(), "contrast", |v| v.dark),
        ("faint on light only", "<p style='opacity:.5'>faint</p>".into(), "contrast", |v| !v.dark),
        (
            "faint on an area of a picture",
            svg("<rect width=200 height=100 fill='#777'/><text style='fill:#666' x=10 y=50>faint</text>"),
            "contrast",
            always,
        ),
        (
            "small in a picture that shrinks",
            "<svg role=img aria-label=x viewBox='0 0 600 100' style='width:100%'><text x=9 y=50>small</text></svg>"
                .into(),
            "small",
            |v| v.width < 600,
        ),
        ("a picture from elsewhere", "<img alt='' src='http://127.0.0.1:9/x.png'>".into(), "request", always),
        ("a style from elsewhere", "<style>@import 'http://127.0.0.1:9/x.css';</style>".into(), "request", always),
        ("a script fails", "<script>nothing.there()</script>".into(), "script", always),
        ("a script complains", "<script>console.error('no')</script>".into(), "script", always),
        ("an id stands twice", "<p id=n></p>".into(), "id", always),
        ("a link leads nowhere", "<a href='#gone' style='color:inherit'>there</a>".into(), "reference", always),
        ("a name is gone", "<p aria-labelledby=gone>text</p>".into(), "reference", always),
        ("a clip is gone", svg("<g clip-path='url(#gone)'></g>"), "reference", always),
        ("a picture has no role", "<svg aria-label=x width=9 height=9></svg>".into(), "picture", always),
        ("a picture has no name", "<svg role=img width=9 height=9></svg>".into(), "picture", always),
        ("a table has no headings", "<table><tr><td>a</td></tr></table>".into(), "table", always),
    ]
    .into_iter()
    .map(|(what, added, kind, shown)| (what, page(&added), kind, shown))
    .collect();
    all.push(("no language", page("").replace(" lang=en", ""), "language", always));
    all.push(("no title", page("").replace("<title>t<", "<title><"), "title", always));
    all
}
