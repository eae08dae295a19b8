//! Colours, where somebody sees them.

use std::io::IsTerminal;

/// Paints words on a terminal, and leaves them alone elsewhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    colours: bool,
}

impl Paint {
    /// For a stream: colours on a terminal that knows them, never under `NO_COLOR` (<https://no-color.org>).
    pub(crate) fn of(stream: &impl IsTerminal) -> Self {
        let set = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty());
        let dumb = set("TERM").is_some_and(|term| term == "dumb");
        Self { colours: stream.is_terminal() && set("NO_COLOR").is_none() && !dumb }
    }

    fn with(self, code: &str, words: &str) -> String {
        if self.colours && !words.is_empty() { format!("\x1b[{code}m{words}\x1b[0m") } else { words.to_owned() }
    }

    /// A result.
    pub(crate) fn bold(self, words: &str) -> String {
        self.with("1", words)
    }

    /// Something to mind.
    pub(crate) fn yellow(self, words: &str) -> String {
        self.with("1;33", words)
    }

    /// Something wrong.
    pub(crate) fn red(self, words: &str) -> String {
        self.with("1;31", words)
    }
}

#[cfg(test)]
mod tests {
    use super::Paint;

    #[test]
    fn words_are_painted_for_eyes_alone() {
        assert_eq!(Paint { colours: false }.red("error:"), "error:");
        assert_eq!(Paint { colours: true }.red("error:"), "\x1b[1;31merror:\x1b[0m");
    }
}
