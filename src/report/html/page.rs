//! The page itself.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::report::chart::{Figure, PAGE_STYLE, Scene};

/// The style of all pages: light and dark, narrow and wide, screen and paper.
const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#1b1f24;--dim:#57606a;--line:#d0d7de;--held:#116329;--drawn:#7d4e00;--not:#a40e26;--paper:#fff}
@media(prefers-color-scheme:dark){:root{--ink:#e6edf3;--dim:#9da7b1;--line:#3d444d;--held:#56d364;--drawn:#e3b341;--not:#ff7b72;--paper:#0d1117}}
body{font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:76rem;margin:0 auto;padding:1rem;overflow-wrap:anywhere}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;overflow-wrap:normal}
th,td{padding:.3rem .7rem;border-bottom:1px solid var(--line);text-align:right;vertical-align:top}
th[scope=row]{font-weight:normal;min-width:10rem}th:first-child,td:first-child,.words{text-align:left}.number{white-space:nowrap}
small{display:block;color:var(--dim)}
.held{color:var(--held)}.drawn{color:var(--drawn)}.not{color:var(--not);font-weight:bold}
dl.numbers{display:flex;flex-wrap:wrap;gap:.8rem;padding:0;margin:1rem 0}
.numbers div{border:1px solid var(--line);border-radius:.4rem;padding:.5rem .9rem;min-width:9rem}
.numbers dt{color:var(--dim);font-size:.875rem}.numbers dd{margin:0;font-size:1.25rem;font-variant-numeric:tabular-nums}
.verdict{font-size:1.25rem;font-weight:bold;border-left:.4rem solid;padding-left:.8rem}
dt{color:var(--dim)}dd{margin:0 0 .5rem}
@media(max-width:44rem){table{font-size:.875rem}th,td{padding:.3rem .4rem}th:first-child,td:first-child{padding-left:0}}
@media(min-width:44rem){dl{display:grid;grid-template-columns:fit-content(50%) 1fr;gap:.3rem 1.4rem}dd{margin:0}}
.wide{overflow-x:auto}pre{overflow-x:auto;font-size:.85rem}figure{margin:1rem 0}svg{max-width:100%;height:auto}
";

/// On paper nothing scrolls, and pictures and rows stay whole.
const PAPER: &str = "\
@media print{:root{font-size:11px}body{font-size:1rem;padding:0}.wide{overflow:visible}pre{white-space:pre-wrap;overflow:visible}
figure,pre,tr,.verdict{break-inside:avoid}h2,h2+p{break-after:avoid}}";

/// How good the news is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// All is well.
    Good,
    /// Something is to be known or done.
    Mind,
    /// Not to be used.
    Bad,
}

/// A page.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// Title of the page.
    pub title: String,
    /// The result in one sentence.
    pub verdict: String,
    /// How good it is.
    pub tone: Tone,
    /// The few numbers that matter: name, value.
    pub numbers: Vec<(String, String)>,
    /// Main messages and advice, one paragraph each.
    pub lead: Vec<String>,
    /// Sections, in order.
    pub sections: Vec<Section>,
    /// Everything needed to repeat the run, by name.
    pub settings: Vec<(String, String)>,
}

/// The numbers that have a value.
pub(super) fn known<const N: usize>(numbers: [(&str, Option<String>); N]) -> Vec<(String, String)> {
    numbers.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect()
}

/// A part of a page with a heading.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Name of its anchor.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Contents, in order.
    pub parts: Vec<Part>,
}

/// A paragraph, a table, a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    /// A paragraph.
    Text(String),
    /// Lines as they are.
    Lines(String),
    /// A table: header, rows.
    Table(Vec<&'static str>, Vec<Vec<String>>),
    /// A picture.
    Picture(Box<Figure>),
    /// A drawing in perspective.
    Drawing(Box<Scene>),
}

impl Part {
    /// A picture.
    pub fn picture(figure: Figure) -> Self {
        Self::Picture(Box::new(figure))
    }

    /// A drawing in perspective.
    pub fn drawing(scene: Scene) -> Self {
        Self::Drawing(Box::new(scene))
    }

    fn markup(&self, id: &str) -> Markup {
        match self {
            Self::Text(text) => html! { p { (text) } },
            Self::Lines(lines) => html! { pre { (lines) } },
            Self::Table(header, rows) => {
                let class = |k: usize| if of_words(rows, k) { "words" } else { "number" };
                html! {
                    div.wide { table {
                        thead { tr { @for (k, h) in header.iter().enumerate() {
                            th scope="col" class=[of_words(rows, k).then_some("words")] { (h) }
                        } } }
                        tbody { @for row in rows { tr {
                            @for (k, cell) in row.iter().enumerate() { td class=(class(k)) { (cell) } }
                        } } }
                    } }
                }
            }
            Self::Picture(figure) => html! { figure { (PreEscaped(figure.html_with_id(id))) } },
            Self::Drawing(scene) => html! { figure { (PreEscaped(scene.html_with_id(id))) } },
        }
    }
}

/// Whether a column holds words and not numbers: words begin at the left and may wrap.
fn of_words(rows: &[Vec<String>], column: usize) -> bool {
    let mut cells = rows.iter().filter_map(|row| row.get(column)?.chars().next());
    cells.all(char::is_alphabetic)
}

impl Page {
    /// The page as HTML.
    pub fn html(&self) -> String {
        let class = match self.tone {
            Tone::Good => "verdict held",
            Tone::Mind => "verdict drawn",
            Tone::Bad => "verdict not",
        };
        let body = html! {
            h1 { (self.title) }
            p class=(class) { (self.verdict) }
            @if !self.numbers.is_empty() {
                dl.numbers { @for (name, value) in &self.numbers { div { dt { (name) } dd { (value) } } } }
            }
            @for paragraph in &self.lead { p { (with_code(&sentence(paragraph))) } }
            @for section in self.sections.iter().filter(|s| !s.parts.is_empty()) {
                section id=(section.id) {
                    h2 { (section.title) }
                    @for (k, part) in section.parts.iter().enumerate() {
                        (part.markup(&format!("{}{k}", section.id)))
                    }
                }
            }
            section id="settings" {
                h2 { "How to repeat it" }
                dl {
                    @for (name, value) in &self.settings { dt { (name) } dd { (value) } }
                    dt { "paracal" } dd { (env!("CARGO_PKG_VERSION")) }
                }
            }
        };
        shell(&self.title, &body)
    }
}

/// A sentence with what stands between backticks as code.
fn with_code(text: &str) -> Markup {
    html! { @for (k, part) in text.split('`').enumerate() {
        @if k % 2 == 1 { code { (part) } } @else { (part) }
    } }
}

/// A remark as a sentence.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first: String = letters.next().map(|c| c.to_uppercase().collect()).unwrap_or_default();
    // Names such as `drift.leg` stay as they are.
    let is_name = text.split([' ', ':']).next().is_some_and(|word| word.contains(['.', '_']));
    let end = if text.ends_with(['.', '!', '?', ')']) { "" } else { "." };
    if is_name { format!("{text}{end}") } else { format!("{first}{}{end}", letters.as_str()) }
}

/// A document around a body, in the style of all pages.
pub(crate) fn shell(title: &str, body: &Markup) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) (PreEscaped(PAGE_STYLE)) (PreEscaped(PAPER)) }
            }
            body { (body) }
        }
    }
    .into_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_escaped_and_parts_have_anchors_of_their_own() {
        let page = Page {
            title: "<b> & \"c\"".into(),
            verdict: "a < b".into(),
            tone: Tone::Mind,
            numbers: vec![("<u>".into(), "1".into())],
            lead: vec!["<script> `paracal <x>`".into()],
            sections: vec![Section {
                id: "s",
                title: "S",
                parts: vec![
                    Part::picture(Figure::default()),
                    Part::picture(Figure::default()),
                    Part::Lines("<i>".into()),
                ],
            }],
            settings: vec![("file".into(), "<x>".into())],
        };
        let html = page.html();
        assert!(
            !html.contains("<script")
                && !html.contains("<u>")
                && !html.contains("<i>")
                && !html.contains("<x>")
                && html.contains("a &lt; b")
        );
        assert!(html.contains("<code>paracal &lt;x&gt;</code>"));
        assert!(html.contains("s0") && html.contains("s1"));
    }
}
