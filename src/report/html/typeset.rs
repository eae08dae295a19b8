//! Units as they are printed: µm, °, ″ and °C for the names that terminals and files use.

/// Names of units, and how a page writes them.
const UNITS: [(&str, &str); 5] = [("um/mm2", "µm/mm²"), ("um", "µm"), ("arcsec", "″"), ("degC", "°C"), ("deg", "°")];
/// What begins with one of these stands as it is up to the end that belongs to it.
const AS_IT_IS: [(&str, &str); 3] =
    [("<style", "</style>"), ("<code", "</code>"), ("<section id=\"settings\"", "</section>")];

/// The texts of an HTML document with printed units. Styles, code and what repeats a run stay as they are; columns of
/// preformatted texts stay aligned.
pub(super) fn typeset(html: &str) -> String {
    let mut out = String::with_capacity(html.len());
    let mut rest = html;
    let mut aligned = false;
    while let Some(at) = rest.find('<') {
        let (text, tags) = rest.split_at(at);
        units(text, aligned, &mut out);
        let verbatim = AS_IT_IS.iter().find(|(begin, _)| tags.starts_with(begin));
        let end = match verbatim {
            Some((_, end)) => tags.find(end).map(|at| at + end.len()),
            None => tags.find('>').map(|at| at + 1),
        };
        let (tag, after) = tags.split_at(end.unwrap_or(tags.len()));
        aligned = if tag.starts_with("<pre") { true } else { aligned && tag != "</pre>" };
        out.push_str(tag);
        rest = after;
    }
    units(rest, aligned, &mut out);
    out
}

/// A text of a picture with printed units, which stay on the line of their number.
pub(super) fn in_print(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    units(text, false, &mut out);
    UNITS.iter().fold(out, |text, (_, unit)| text.replace(&format!(" {unit}"), &format!("\u{a0}{unit}")))
}

/// Appends a text with printed units: those behind a number, and those alone in parentheses.
fn units(text: &str, aligned: bool, out: &mut String) {
    let begin = out.len();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let before = &out[begin..];
        let unit = UNITS.iter().find(|(name, _)| rest.strip_prefix(name).is_some_and(ends));
        match unit.filter(|_| follows_number(before) || before.ends_with('(')) {
            Some((name, printed)) => {
                append(out, begin, name, printed, aligned);
                rest = &rest[name.len()..];
            }
            None => {
                out.push(first);
                rest = &rest[first.len_utf8()..];
            }
        }
    }
}

/// Whether no word goes on here.
fn ends(rest: &str) -> bool {
    !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_')
}

/// Whether a text ends in a number, perhaps with a blank behind it.
fn follows_number(before: &str) -> bool {
    let before = before.strip_suffix([' ', '\u{a0}']).unwrap_or(before);
    let word = before.trim_end_matches(|c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | '-' | '+'));
    // `x2um` is a name.
    before.ends_with(|c: char| c.is_ascii_digit()) && !word.ends_with(|c: char| c.is_alphanumeric() || c == '_')
}

/// Appends a printed unit. Signs stand next to their number; in a column the number moves to the right instead.
fn append(out: &mut String, begin: usize, name: &str, printed: &str, aligned: bool) {
    let sign = printed.starts_with(['″', '°']) && printed != "°C";
    let mut missing = name.chars().count() - printed.chars().count();
    if sign && out[begin..].ends_with(' ') {
        out.pop();
        missing += 1;
    }
    if aligned && missing > 0 {
        let line = out[begin..].rfind('\n').map_or(begin, |at| begin + at + 1);
        let number = out[line..].rfind(' ').map_or(line, |at| line + at + 1);
        // A number with a wide gap before it stands in a column.
        if out[line..number].ends_with("  ") {
            out.insert_str(number, &" ".repeat(missing));
        }
    }
    out.push_str(printed);
}

#[cfg(test)]
mod tests {
    use super::{in_print, typeset};

    #[test]
    fn units_behind_numbers_are_printed_and_names_stay() {
        let cases = [
            ("9.15 um and 1.65 arcsec", "9.15 µm and 1.65″"),
            ("position error (um)", "position error (µm)"),
            ("by 55.2 deg at 20 degC", "by 55.2° at 20 °C"),
            ("0.0073 um/mm2, 1.2e-7 um, 3 arcsec/K", "0.0073 µm/mm², 1.2e-7 µm, 3″/K"),
            ("deg where rad is stated, m | mm | um | in", "deg where rad is stated, m | mm | um | in"),
            ("leg1_um temp_degC umbrella 3 umbrellas", "leg1_um temp_degC umbrella 3 umbrellas"),
            ("<code>--noise 2um</code> 2um", "<code>--noise 2um</code> 2µm"),
            ("<style>a{b:1 deg}</style>", "<style>a{b:1 deg}</style>"),
            (
                "<section id=\"settings\"><dd>2 um</dd></section>3 um",
                "<section id=\"settings\"><dd>2 um</dd></section>3 µm",
            ),
        ];
        for (text, wanted) in cases {
            assert_eq!(typeset(text), wanted);
        }
    }

    #[test]
    fn units_in_pictures_stay_with_their_number() {
        assert_eq!(in_print("the largest is < 15.9 um or 3 deg"), "the largest is < 15.9\u{a0}µm or 3°");
    }

    #[test]
    fn columns_stay_aligned() {
        let text = "<pre>RMS  9.15 um  1.65 arcsec\nmax  15.9 um  75.1 deg\n</pre>";
        assert_eq!(typeset(text), "<pre>RMS  9.15 µm        1.65″\nmax  15.9 µm     75.1°\n</pre>");
    }
}
