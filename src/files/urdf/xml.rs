//! XML as a small tree with line numbers, within bounds.
//!
//! A hostile or broken file must cost no more than a robot: its size, its depth and its numbers of elements and
//! attributes are bounded, and no entity but the five of XML itself is replaced. Prefixes need no declaration, since
//! tags such as `drake:ball_constraint` are found in files that declare none.

use crate::files::finding::{Finding, FindingKind};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Largest file, bytes.
pub(super) const MAX_BYTES: usize = 64 << 20;
/// Elements within elements.
const MAX_DEPTH: usize = 64;
/// Elements in all.
const MAX_ELEMENTS: usize = 500_000;
/// Attributes of one element.
const MAX_ATTRIBUTES: usize = 100;

/// An element with all that is in it.
#[derive(Clone, Debug, Default)]
pub(super) struct Element {
    /// Name as it is written, with its prefix.
    pub(super) name: String,
    /// Line of its start, from 1.
    pub(super) line: usize,
    pub(super) attributes: Vec<(String, String)>,
    pub(super) children: Vec<Element>,
    /// Text directly in it.
    pub(super) text: String,
}

impl Element {
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }

    pub(super) fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|c| c.name == name)
    }

    pub(super) fn children_named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |c| c.name == name)
    }
}

fn bad(kind: FindingKind, line: usize, text: impl Into<String>) -> Finding {
    Finding { kind, element: String::new(), line: Some(line), text: text.into() }
}

fn too_large(line: usize, what: &str) -> Finding {
    bad(FindingKind::TooLarge, line, format!("{what}; no robot needs that, check that it is the right file"))
}

/// Lines by position, counted as the positions come, in order.
struct Lines<'a> {
    text: &'a [u8],
    at: usize,
    line: usize,
}

impl Lines<'_> {
    fn of(&mut self, position: u64) -> usize {
        let to = usize::try_from(position).unwrap_or(usize::MAX).min(self.text.len());
        if to > self.at {
            self.line += self.text[self.at..to].iter().filter(|b| **b == b'\n').count();
            self.at = to;
        }
        self.line
    }
}

/// The root element of a text.
pub(super) fn parse(text: &str) -> Result<Element, Finding> {
    if text.len() > MAX_BYTES {
        return Err(too_large(1, &format!("the file has {} MB", text.len() >> 20)));
    }
    let mut lines = Lines { text: text.as_bytes(), at: 0, line: 1 };
    let mut reader = Reader::from_str(text);
    let (mut open, mut root): (Vec<Element>, Option<Element>) = (Vec::new(), None);
    let mut elements = 0;
    loop {
        let line = lines.of(reader.buffer_position());
        let event = reader.read_event().map_err(|e| {
            let line = lines.of(reader.error_position());
            bad(FindingKind::Xml, line, format!("not well-formed XML: {e}; correct the file or export it again"))
        })?;
        let empty = matches!(event, Event::Empty(_));
        match event {
            Event::Start(tag) | Event::Empty(tag) => {
                elements += 1;
                if open.len() >= MAX_DEPTH {
                    return Err(too_large(line, &format!("more than {MAX_DEPTH} elements are nested")));
                }
                if elements > MAX_ELEMENTS {
                    return Err(too_large(line, &format!("there are more than {MAX_ELEMENTS} elements")));
                }
                if root.is_some() {
                    return Err(bad(
                        FindingKind::Xml,
                        line,
                        "a second root element; an XML file has one, delete the rest",
                    ));
                }
                let element = element(&tag, line)?;
                if empty { close(element, &mut open, &mut root) } else { open.push(element) }
            }
            Event::End(_) => {
                if let Some(element) = open.pop() {
                    close(element, &mut open, &mut root);
                }
            }
            Event::Text(t) => add_text(&mut open, line, &String::from_utf8_lossy(&t))?,
            Event::CData(t) => add_text(&mut open, line, &String::from_utf8_lossy(&t))?,
            Event::GeneralRef(r) => {
                let name = String::from_utf8_lossy(&r).into_owned();
                let of_xml = quick_xml::escape::resolve_xml_entity(&name).map(str::to_owned);
                let character = || r.resolve_char_ref().ok().flatten().map(String::from);
                let text = of_xml.or_else(character).ok_or_else(|| unknown_entity(line, &name))?;
                add_text(&mut open, line, &text)?;
            }
            Event::Eof => break,
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => {}
        }
    }
    if let Some(left) = open.last() {
        let text = format!("<{}> is not closed; the file is cut off, copy or export it again", left.name);
        return Err(bad(FindingKind::Xml, left.line, text));
    }
    root.ok_or_else(|| bad(FindingKind::Xml, 1, "no element at all; check that it is the right file"))
}

fn unknown_entity(line: usize, name: &str) -> Finding {
    let name: String = name.chars().take(40).collect();
    bad(FindingKind::Xml, line, format!("entity '&{name};' is not expanded here; write what it stands for"))
}

fn close(element: Element, open: &mut [Element], root: &mut Option<Element>) {
    match open.last_mut() {
        Some(parent) => parent.children.push(element),
        None => *root = Some(element),
    }
}

fn add_text(open: &mut [Element], line: usize, text: &str) -> Result<(), Finding> {
    match open.last_mut() {
        Some(element) => element.text += text,
        None if text.trim().is_empty() => {}
        None => return Err(bad(FindingKind::Xml, line, "text outside the root element; delete it")),
    }
    Ok(())
}

fn element(tag: &BytesStart<'_>, line: usize) -> Result<Element, Finding> {
    let wrong = |problem: String| {
        bad(FindingKind::Xml, line, format!("not well-formed XML: {problem}; correct the file or export it again"))
    };
    let name = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
    let mut attributes = Vec::new();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|e| wrong(e.to_string()))?;
        if attributes.len() >= MAX_ATTRIBUTES {
            return Err(too_large(line, &format!("an element has more than {MAX_ATTRIBUTES} attributes")));
        }
        let key = String::from_utf8_lossy(attribute.key.as_ref()).into_owned();
        let value = attribute.unescape_value().map_err(|e| wrong(format!("attribute '{key}': {e}")))?.into_owned();
        attributes.push((key, value));
    }
    Ok(Element { name, line, attributes, children: Vec::new(), text: String::new() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(text: &str) -> (FindingKind, usize) {
        let finding = parse(text).unwrap_err();
        (finding.kind, finding.line.unwrap())
    }

    #[test]
    fn lines_prefixes_and_character_references_survive() {
        let root = parse("<?xml version=\"1.0\"?>\n<a>\n  <drake:b x='&lt;1&#65;'/>\n<c>t&amp;u</c></a>\n").unwrap();
        let b = root.child("drake:b").unwrap();
        assert_eq!((b.line, b.attribute("x")), (3, Some("<1A")));
        assert_eq!(root.child("c").unwrap().text, "t&u");
    }

    #[test]
    fn what_is_no_robot_is_refused_with_its_line() {
        assert_eq!(kind("<a>\n<b></a>"), (FindingKind::Xml, 2));
        assert_eq!(kind("<a>\n<b>"), (FindingKind::Xml, 2));
        assert_eq!(kind("<a/>\n<a/>"), (FindingKind::Xml, 2));
        assert_eq!(kind(&"<a>".repeat(1_000_000)), (FindingKind::TooLarge, 1));
        assert_eq!(kind(&format!("<a>{}</a>", "<b/>".repeat(600_000))), (FindingKind::TooLarge, 1));
        let many: String = (0..200_000).map(|k| format!(" a{k}=''")).collect();
        assert_eq!(kind(&format!("<a{many}/>")), (FindingKind::TooLarge, 1));
        let bomb = "<!DOCTYPE a [<!ENTITY b \"bbbb\"><!ENTITY c \"&b;&b;&b;\">]>\n<a x='&c;'/>";
        assert_eq!(kind(bomb), (FindingKind::Xml, 2));
        assert_eq!(kind("<!DOCTYPE a [<!ENTITY b \"bbbb\">]>\n<a>&b;</a>"), (FindingKind::Xml, 2));
    }
}
