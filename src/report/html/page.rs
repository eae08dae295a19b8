//! The page itself.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::style::{PAPER, STYLE};
use super::typeset::{in_print, typeset};
use crate::report::chart::{Figure, PAGE_STYLE, Scene};

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
    /// The few numbers that matter.
    pub numbers: Vec<Tile>,
    /// Main messages and advice, one paragraph each.
    pub lead: Vec<String>,
    /// Sections, in order.
    pub sections: Vec<Section>,
    /// Everything needed to repeat the run, by name.
    pub settings: Vec<(String, String)>,
}

/// A number that can be understood without the rest of the page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tile {
    /// What it is called.
    pub name: String,
    /// The number with its unit.
    pub value: String,
    /// What it means; may be empty.
    pub meaning: String,
}

impl Tile {
    /// A number, if it is known.
    pub(super) fn of(name: &str, value: Option<String>, meaning: impl Into<String>) -> Option<Self> {
        Some(Self { name: name.into(), value: value?, meaning: meaning.into() })
    }
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
    /// Parts side by side where there is room.
    Row(Vec<Part>),
    /// Parts behind a line that opens them.
    Folded(String, Vec<Part>),
}

/// Tables with more rows than this are folded.
const LONG: usize = 12;
/// Tables with more columns than this become lists on a phone.
const COLUMNS: usize = 2;

impl Part {
    /// A picture.
    pub fn picture(figure: Figure) -> Self {
        Self::Picture(Box::new(figure))
    }

    /// A drawing in perspective.
    pub fn drawing(scene: Scene) -> Self {
        Self::Drawing(Box::new(scene))
    }

    /// A table that is folded if it is long; `title` is the line that opens it.
    pub fn table(title: &str, header: Vec<&'static str>, rows: Vec<Vec<String>>) -> Self {
        let (long, count) = (rows.len() > LONG, rows.len());
        let table = Self::Table(header, rows);
        if long { Self::Folded(format!("{title} ({count} rows)"), vec![table]) } else { table }
    }

    /// What the program prints, folded.
    pub fn printed(text: String) -> Self {
        Self::Folded("As the program prints it".into(), vec![Self::Lines(text)])
    }

    fn markup(&self, id: &str) -> Markup {
        match self {
            Self::Text(text) => html! { p { (text) } },
            Self::Lines(lines) => html! { pre { (lines) } },
            Self::Table(header, rows) => table(header, rows),
            Self::Picture(figure) => html! { figure { (PreEscaped(figure.html_with_id(id))) } },
            Self::Drawing(scene) => html! { figure { (PreEscaped(scene.html_alone(id))) } },
            Self::Row(parts) => html! {
                div.row { @for (k, part) in parts.iter().enumerate() { div { (part.beside(&format!("{id}-{k}"))) } } }
            },
            Self::Folded(title, parts) => html! {
                details {
                    summary { (title) }
                    @for (k, part) in parts.iter().enumerate() { (part.markup(&format!("{id}-{k}"))) }
                }
            },
        }
    }

    /// The part as one of a row, with half of the page for itself.
    fn beside(&self, id: &str) -> Markup {
        match self {
            Self::Drawing(scene) => html! { figure { (PreEscaped(scene.html_with_id(id))) } },
            other => other.markup(id),
        }
    }
}

fn table(header: &[&'static str], rows: &[Vec<String>]) -> Markup {
    let class = |k: usize| if of_words(rows, k) { "words" } else { "number" };
    let label = |k: usize| header.get(k).copied().unwrap_or_default();
    html! {
        div.wide { table.cards[header.len() > COLUMNS] {
            thead { tr { @for (k, h) in header.iter().enumerate() {
                th scope="col" class=[of_words(rows, k).then_some("words")] { (h) }
            } } }
            tbody { @for row in rows { tr {
                @for (k, cell) in row.iter().enumerate() { td class=(class(k)) data-of=(in_print(label(k))) { (cell) } }
            } } }
        } }
    }
}

/// Whether a column holds words and not numbers: words begin at the left and may wrap.
fn of_words(rows: &[Vec<String>], column: usize) -> bool {
    let mut cells = rows.iter().filter_map(|row| row.get(column)?.chars().next());
    cells.all(|first| first.is_alphabetic() || first == '[')
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
                dl.numbers.five[self.numbers.len() == 5] { @for tile in &self.numbers { div {
                    dt { (tile.name) } dd { (tile.value) }
                    @if !tile.meaning.is_empty() { dd.meaning { (tile.meaning) } }
                } } }
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
            body { (PreEscaped(typeset(&body.0))) }
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
            numbers: vec![Tile { name: "<u>".into(), value: "1".into(), meaning: String::new() }],
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
