//! Numbers as text, and the estimated widths of texts.

/// Ten to the power `e`.
pub(super) fn ten(e: i32) -> f64 {
    10f64.powi(e)
}

/// The decimal exponent of a positive number: `10^e <= v < 10^(e+1)`.
pub(super) fn exponent(v: f64) -> i32 {
    let e = v.log10().floor() as i32;
    // The logarithm can be off by one unit in the last place next to a power of ten.
    if v >= ten(e + 1) * (1.0 - 1e-12) { e + 1 } else { e }
}

/// An integer in superscript digits.
pub(super) fn superscript(e: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    e.to_string()
        .bytes()
        .map(|b| if b.is_ascii_digit() { DIGITS.get(usize::from(b - b'0')).copied().unwrap_or(' ') } else { '⁻' })
        .collect()
}

/// A number with fixed decimals, a true minus sign and groups of three digits from 10 000 on.
pub(super) fn fixed(v: f64, decimals: usize) -> String {
    let plain = format!("{v:.decimals$}");
    let (negative, digits) = plain.strip_prefix('-').map_or((false, plain.as_str()), |d| (true, d));
    let (whole, rest) = digits.split_once('.').map_or((digits, ""), |(w, r)| (w, r));
    let mut out = String::new();
    if negative && digits.bytes().any(|b| (b'1'..=b'9').contains(&b)) {
        out.push('−');
    }
    for (i, c) in whole.chars().enumerate() {
        if i > 0 && whole.len() > 4 && (whole.len() - i) % 3 == 0 {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    if !rest.is_empty() {
        out.push('.');
        out.push_str(rest);
    }
    out
}

/// A number with so many significant digits, trailing zeros removed; very large and small ones with a power of ten.
pub(super) fn significant(v: f64, digits: i32) -> String {
    if !v.is_finite() {
        return "–".to_owned();
    }
    if v.abs() < 1e-300 {
        return "0".to_owned();
    }
    // The exponential format rounds first, so that 9.9999 gets the exponent of 10.
    let text = format!("{v:.*e}", (digits - 1).max(0) as usize);
    let (mantissa, e) = text.split_once('e').unwrap_or((&text, "0"));
    let (mantissa, e) = (mantissa.parse().unwrap_or(v), e.parse().unwrap_or(0));
    let trim = |text: String| {
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    };
    if (-3..6).contains(&e) {
        trim(fixed(mantissa * ten(e), (digits - 1 - e).max(0) as usize))
    } else {
        format!("{}×10{}", trim(fixed(mantissa, (digits - 1).max(0) as usize)), superscript(e))
    }
}

/// Estimated width of a text, on the generous side.
pub(super) fn width(text: &str, size: f64, bold: bool) -> f64 {
    let em: f64 = text
        .chars()
        .map(|c| match c {
            'i' | 'j' | 'l' | 'I' | '.' | ',' | ':' | ';' | '|' | '\'' | '!' => 0.38,
            ' ' | '\u{202f}' | 'f' | 't' | 'r' | '(' | ')' | '[' | ']' | '-' | '/' => 0.44,
            'm' | 'w' | 'M' | 'W' | '@' | '%' | '—' | '…' | '→' => 1.02,
            '×' | '−' | '+' | '=' | '<' | '>' | '±' => 0.84,
            'A'..='Z' | '&' => 0.78,
            '⁰' | '¹' | '²' | '³' | '⁴'..='⁹' | '⁻' => 0.48,
            c if u32::from(c) >= 0x1100 => 1.1,
            _ => 0.64,
        })
        .sum();
    em * size * if bold { 1.12 } else { 1.0 }
}

/// Breaks a text into lines of at most the given width; words that are too long are broken inside.
pub(super) fn wrap(text: &str, size: f64, bold: bool, limit: f64) -> Vec<String> {
    let fits = |line: &str| width(line, size, bold) <= limit;
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split(is_break).filter(|w| !w.is_empty()) {
        let joined = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if fits(&joined) {
            line = joined;
            continue;
        }
        if !line.is_empty() {
            lines.push(std::mem::take(&mut line));
        }
        for c in word.chars() {
            line.push(c);
            if !fits(&line) && line.chars().count() > 1 {
                line.pop();
                lines.push(std::mem::replace(&mut line, c.to_string()));
            }
        }
    }
    if !line.is_empty() {
        lines.push(line);
    }
    lines
}

/// The text, cut with an ellipsis if it is wider than the limit.
pub(super) fn shorten(text: &str, size: f64, limit: f64) -> String {
    let text = text.replace(is_break, " ");
    if width(&text, size, false) <= limit {
        return text;
    }
    let mut short = String::new();
    for c in text.chars() {
        if width(&format!("{short}{c}…"), size, false) > limit {
            break;
        }
        short.push(c);
    }
    format!("{}…", short.trim_end())
}

/// Blanks and control characters at which lines may break (not the no-break spaces).
pub(super) fn is_break(c: char) -> bool {
    c == ' ' || c.is_control()
}
