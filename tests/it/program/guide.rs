//! The guide in `docs/guide` as a reader follows it: every command runs and prints what the page shows. And every relative
//! link of the documentation leads somewhere.
//!
//! What a page may hold:
//! * a ```` ```sh ```` block, whose commands are `paracal …`, `cp A B`, `head -n N FILE`, `tail -n N FILE` (or `… > B`),
//!   `cut -d, -f 1-3,5 A > B` and `sed 's/old/new/' A > B`, with plain words, quotes, `\` at the end of a line and `#` comments;
//! * after it a ```` ```text ```` block with what is printed on standard output, or on standard error where nothing else is
//!   printed. A line `...` stands for one or more lines that are left out. Lines that begin with `warning: ` are looked for
//!   on standard error;
//! * in the last line of text before a `sh` block, `(exit code 3)`: that of its last command, 0 if absent;
//! * a ```` ```toml ```` or ```` ```csv ```` block that begins with `# save as NAME`: a file that the reader writes.

use std::collections::{BTreeSet, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::bench::Bench;

/// What a block of a page asks for; `line` counts from 1.
#[derive(Debug, PartialEq)]
enum Step {
    Save { name: String, text: String },
    Run { line: usize, commands: Vec<Vec<String>>, code: i32, shown: Vec<String> },
}

/// The steps of a page in their order.
fn steps(page: &str) -> Result<Vec<Step>, String> {
    let lines: Vec<&str> = page.lines().collect();
    let (mut steps, mut before, mut at) = (Vec::new(), "", 0);
    while at < lines.len() {
        let Some(kind) = lines[at].strip_prefix("```") else {
            if !lines[at].trim().is_empty() {
                before = lines[at];
            }
            at += 1;
            continue;
        };
        let line = at + 1;
        let length = lines[line..].iter().position(|l| *l == "```").ok_or(format!("line {line}: block without end"))?;
        let body = &lines[line..line + length];
        at = line + length + 1;
        match (kind, steps.last_mut()) {
            ("sh", _) => {
                let commands = commands(body).map_err(|e| format!("line {line}: {e}"))?;
                steps.push(Step::Run { line, commands, code: exit_code(before), shown: Vec::new() });
            }
            ("text", Some(Step::Run { shown, .. })) if shown.is_empty() => {
                *shown = body.iter().map(|l| (*l).to_owned()).collect();
            }
            ("text", _) => return Err(format!("line {line}: output without a command before it")),
            ("toml" | "csv", _) => {
                let name = body.first().and_then(|l| l.strip_prefix("# save as "));
                let name = name.ok_or(format!("line {line}: no `# save as NAME`"))?;
                let name = name.split(':').next().unwrap_or(name).trim().to_owned();
                steps.push(Step::Save { name, text: body.join("\n") + "\n" });
            }
            _ => return Err(format!("line {line}: a block of kind '{kind}'")),
        }
        before = "";
    }
    for step in &steps {
        if let Step::Run { line, shown, .. } = step
            && shown.is_empty()
        {
            return Err(format!("line {line}: the commands are not followed by what they print"));
        }
    }
    Ok(steps)
}

/// 0, or what `(exit code N)` in the text says.
fn exit_code(text: &str) -> i32 {
    let code = text.split_once("(exit code ").and_then(|(_, rest)| rest.split_once(')'));
    code.and_then(|(code, _)| code.parse().ok()).unwrap_or(0)
}

fn commands(body: &[&str]) -> Result<Vec<Vec<String>>, String> {
    let mut all = Vec::new();
    for line in body.join("\n").replace("\\\n", " ").lines() {
        let found = words(line)?;
        if !found.is_empty() {
            all.push(found);
        }
    }
    if all.is_empty() { Err("a block without a command".into()) } else { Ok(all) }
}

/// Words and quotes of a shell, without anything that would need one.
fn words(line: &str) -> Result<Vec<String>, String> {
    let (mut all, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in line.chars() {
        match (quote, c) {
            (Some(q), _) if c == q => quote = None,
            (Some('"'), '$' | '`' | '\\') => return Err(format!("'{c}' in double quotes needs a shell: {line}")),
            (None, '\'' | '"') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, '#') if word.is_none() => break,
            (None, ' ' | '\t') => all.extend(word.take()),
            (None, '|' | '&' | ';' | '$' | '`' | '*' | '?' | '<' | '(' | ')' | '{' | '}' | '~' | '\\' | '!') => {
                return Err(format!("'{c}' needs a shell: {line}"));
            }
            _ => word.get_or_insert_default().push(c),
        }
    }
    if quote.is_some() {
        return Err(format!("a quote without end: {line}"));
    }
    all.extend(word);
    Ok(all)
}

/// What a command prints, and its exit code.
#[derive(Default)]
struct Printed {
    out: String,
    err: String,
    code: i32,
}

/// The bundled files, among which a page is followed.
struct Folder(Bench);

impl Folder {
    fn read(&self, name: &str) -> Result<String, String> {
        fs::read_to_string(self.0.at(name)).map_err(|e| format!("{name}: {e}"))
    }

    fn write(&self, name: &str, text: &str) -> Result<Printed, String> {
        fs::write(self.0.at(name), text).map_err(|e| format!("{name}: {e}"))?;
        Ok(Printed::default())
    }

    fn run(&self, command: &[String]) -> Result<Printed, String> {
        let command: Vec<&str> = command.iter().map(String::as_str).collect();
        match command[..] {
            [ref shown @ .., ">", to] if ["paracal", "head", "tail"].contains(&shown[0]) => {
                let shown: Vec<String> = shown.iter().map(|w| (*w).to_owned()).collect();
                let printed = self.run(&shown)?;
                self.write(to, &printed.out)?;
                Ok(Printed { out: String::new(), ..printed })
            }
            ["paracal", ref args @ ..] => {
                let output = self.0.run(args);
                let [out, err] = [output.stdout, output.stderr].map(|b| String::from_utf8_lossy(&b).into_owned());
                Ok(Printed { out, err, code: output.status.code().unwrap_or(-1) })
            }
            ["cp", from, to] => self.write(to, &self.read(from)?),
            [which @ ("head" | "tail"), "-n", number, name] => {
                let (text, number) = (self.read(name)?, number.parse::<usize>().map_err(|e| e.to_string())?);
                let count = text.lines().count();
                let skipped = if which == "head" { 0 } else { count.saturating_sub(number) };
                let out = text.lines().skip(skipped).take(number).map(|l| format!("{l}\n")).collect();
                Ok(Printed { out, ..Printed::default() })
            }
            ["cut", "-d,", "-f", fields, from, ">", to] => self.write(to, &cut(fields, &self.read(from)?)?),
            ["sed", script, from, ">", to] => self.write(to, &substituted(script, &self.read(from)?)?),
            _ => Err(format!("this command is not among those that a page may hold: {}", command.join(" "))),
        }
    }
}

/// These fields of each line, such as `1-3,5`; a line without a comma is kept.
fn cut(fields: &str, text: &str) -> Result<String, String> {
    let number =
        |n: &str| n.parse::<usize>().ok().filter(|n| *n > 0).ok_or(format!("cut: '{n}' is not a field: {fields}"));
    let mut kept = Vec::new();
    for range in fields.split(',') {
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        kept.extend(number(first)?..=number(last)?);
    }
    let line = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let some = cells.iter().enumerate().filter(|(k, _)| cells.len() == 1 || kept.contains(&(k + 1)));
        some.map(|(_, cell)| *cell).collect::<Vec<_>>().join(",") + "\n"
    };
    Ok(text.lines().map(line).collect())
}

/// `s/old/new/` and `s/old/new/g` on plain characters. A script that changes nothing is a mistake of the page.
fn substituted(script: &str, text: &str) -> Result<String, String> {
    let parts: Vec<&str> = script.split('/').collect();
    let ["s", old, new, flag @ ("" | "g")] = parts[..] else { return Err(format!("sed: only s/old/new/: {script}")) };
    if old.is_empty() || format!("{old}{new}").contains(['\\', '[', ']', '*', '^', '$', '&']) {
        return Err(format!("sed: only plain characters: {script}"));
    }
    let changed: String =
        text.lines().map(|l| l.replacen(old, new, if flag == "g" { usize::MAX } else { 1 }) + "\n").collect();
    if changed == text { Err(format!("sed: nothing to change: {script}")) } else { Ok(changed) }
}

/// Requires that the lines are printed as they are shown, where `...` leaves out one or more.
fn compare(shown: &[&str], printed: &[&str]) -> Result<(), String> {
    let parts: Vec<&[&str]> = shown.split(|l| *l == "...").collect();
    let mut from = 0;
    for (n, part) in parts.iter().enumerate() {
        // The first part stands at the beginning, the last at the end, one between two `...` where it comes first.
        let earliest = if n == 0 { 0 } else { from + 1 };
        let latest = printed.len().checked_sub(part.len()).filter(|l| *l >= earliest);
        let mut places = if n == 0 { 0..=0 } else { earliest..=latest.unwrap_or(0) };
        let last = n + 1 == parts.len();
        let found = latest.and_then(|l| places.find(|p| printed[*p..].starts_with(part) && (!last || *p == l)));
        from = found.ok_or_else(|| format!("not printed like this:\n{}", part.join("\n")))? + part.len();
    }
    Ok(())
}

/// The lines of a text without blanks at the end.
fn lines(text: &str) -> Vec<&str> {
    text.trim_end().lines().map(str::trim_end).collect()
}

fn follow(page: &str) -> Result<(), String> {
    let folder = Folder(Bench::project());
    let steps = steps(page)?;
    if !steps.iter().any(|s| matches!(s, Step::Run { .. })) {
        return Err("a page without a command".into());
    }
    for step in &steps {
        match step {
            Step::Save { name, text } => drop(folder.write(name, text)?),
            Step::Run { line, commands, code, shown } => {
                block(&folder, commands, *code, shown).map_err(|e| format!("line {line}: {e}"))?;
            }
        }
    }
    Ok(())
}

fn block(folder: &Folder, commands: &[Vec<String>], code: i32, shown: &[String]) -> Result<(), String> {
    let mut all = Printed::default();
    for (n, command) in commands.iter().enumerate() {
        let printed = folder.run(command)?;
        let wanted = if n + 1 == commands.len() { code } else { 0 };
        if printed.code != wanted {
            let command = command.join(" ");
            return Err(format!(
                "exit code {} and not {wanted}: {command}\n{}{}",
                printed.code, printed.out, printed.err
            ));
        }
        all.out += &printed.out;
        all.err += &printed.err;
    }
    let (warnings, shown): (Vec<&str>, Vec<&str>) =
        shown.iter().map(|l| l.trim_end()).partition(|l| l.starts_with("warning: "));
    let errors = lines(&all.err);
    if let Some(missing) = warnings.iter().find(|w| !errors.contains(w)) {
        return Err(format!("no such warning: {missing}\nbut:\n{}", all.err));
    }
    let printed = if all.out.trim().is_empty() { &all.err } else { &all.out };
    compare(&shown, &lines(printed)).map_err(|e| format!("{e}\nbut:\n{printed}"))
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The `.md` files of a folder and of those in it.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(pages(&path));
        } else if path.extension().is_some_and(|e| e == "md") {
            all.push(path);
        }
    }
    all.sort();
    all
}

#[test]
fn the_commands_of_the_guide_print_what_it_shows() {
    let guide = pages(&root().join("docs/guide"));
    assert!(guide.len() > 1, "no pages in docs/guide");
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let runs: Vec<_> = guide
            .iter()
            .map(|path| scope.spawn(move || follow(&fs::read_to_string(path).unwrap()).map_err(|e| (path, e))))
            .collect();
        let ends = runs.into_iter().filter_map(|run| run.join().unwrap().err());
        ends.map(|(path, e)| format!("{}, {e}", path.display())).collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn the_index_of_the_guide_names_every_page() {
    let guide = pages(&root().join("docs/guide"));
    let index = fs::read_to_string(root().join("docs/guide/README.md")).unwrap();
    for name in guide.iter().map(|p| p.file_name().unwrap().to_str().unwrap()).filter(|n| *n != "README.md") {
        assert!(index.contains(&format!("]({name})")), "{name}");
    }
}

/// The text without blocks and code in a line.
fn prose(page: &str) -> String {
    let (mut text, mut inside) = (String::new(), false);
    for line in page.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
        } else if !inside {
            text += line;
            text.push('\n');
        }
    }
    text.split('`').step_by(2).collect()
}

/// Targets of links and pictures, without those that lead out of the project.
fn links(page: &str) -> Vec<String> {
    let text = prose(page);
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target.to_owned());
    targets.filter(|t| !["http:", "https:", "mailto:"].iter().any(|s| t.starts_with(s))).collect()
}

/// Anchors of the headings as GitHub makes them.
fn anchors(page: &str) -> BTreeSet<String> {
    let (mut all, mut inside, mut seen) = (BTreeSet::new(), false, HashMap::new());
    for line in page.lines() {
        inside ^= line.starts_with("```");
        let title = line.trim_start_matches('#');
        if inside || title.len() == line.len() || !title.starts_with(' ') {
            continue;
        }
        let kept = title.trim().to_lowercase();
        let slug: String = kept.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect();
        let slug = slug.replace(' ', "-");
        let times = seen.entry(slug.clone()).or_insert(0);
        all.insert(if *times == 0 { slug } else { format!("{slug}-{times}") });
        *times += 1;
    }
    all
}

/// The links of a page that lead nowhere.
fn broken(path: &Path, page: &str) -> Vec<String> {
    let leads = |link: &str| {
        let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
        let target = if file.is_empty() { path.to_owned() } else { path.parent().unwrap().join(file) };
        let known = || anchors(&fs::read_to_string(&target).unwrap_or_default()).contains(anchor);
        target.exists() && (anchor.is_empty() || known())
    };
    links(page).into_iter().filter(|link| !leads(link)).collect()
}

#[test]
fn links_of_the_documentation_lead_somewhere() {
    let mut all = pages(&root().join("docs"));
    all.extend(["README.md", "DESIGN.md", "CHANGELOG.md", "mechanisms/README.md"].map(|n| root().join(n)));
    let mut count = 0;
    for path in all {
        let page = fs::read_to_string(&path).unwrap();
        count += links(&page).len();
        let broken = broken(&path, &page);
        assert!(broken.is_empty(), "{}: {}", path.display(), broken.join(", "));
    }
    assert!(count > 30, "only {count} links were found");
}

mod can_fail {
    use super::*;

    fn refused(page: &str, part: &str) {
        let error = steps(page).err().or_else(|| follow(page).err());
        assert!(error.as_ref().is_some_and(|e| e.contains(part)), "{error:?}\n{page}");
    }

    fn page(commands: &str, shown: &str) -> String {
        format!("Try it.\n\n```sh\n{commands}\n```\n\n```text\n{shown}\n```\n")
    }

    #[test]
    fn blocks_are_read() {
        let text = "```toml\n# save as a.toml: mine\nx = 1\n```\n\nNo (exit code 3):\n\n```sh\n# first\nparacal 'a b' \\\n  \
                    c # d\n```\n\n```text\n...\n```\n";
        let run = Step::Run {
            line: 8,
            commands: vec![["paracal", "a b", "c"].map(str::to_owned).to_vec()],
            code: 3,
            shown: vec!["...".into()],
        };
        let save = Step::Save { name: "a.toml".into(), text: "# save as a.toml: mine\nx = 1\n".into() };
        assert_eq!(steps(text).unwrap(), [save, run]);
    }

    #[test]
    fn pages_that_a_reader_could_not_follow() {
        refused("Words only.\n", "a page without a command");
        refused("```sh\nparacal --help\n", "line 1: block without end");
        refused("```sh\n# nothing\n```\n", "without a command");
        refused("```sh\nparacal --help\n```\n", "not followed");
        refused("```text\nhello\n```\n", "without a command before");
        refused("```toml\nx = 1\n```\n", "save as");
        refused("```python\nx = 1\n```\n", "'python'");
        refused(&page("paracal --help | head", "..."), "'|' needs a shell");
        refused(&page("paracal 'a", "..."), "quote without end");
        refused(&page("rm -r mechanisms", "..."), "not among those");
        refused(&page("sed 's/no such words/x/' mechanisms/table5.toml > x.toml", "..."), "nothing to change");
        refused(&page("sed 's/[a-z]/x/' mechanisms/table5.toml > x.toml", "..."), "plain characters");
        refused(&page("head -n 2 nothing.csv", "..."), "nothing.csv");
        refused(&page("cut -d, -f 1,b examples/data/hardpoint-errors.csv > x.csv", "..."), "'b' is not a field");
    }

    #[test]
    fn output_that_is_not_printed_and_codes_that_are_not_returned() {
        let head = "head -n 1 examples/data/hardpoint-errors.csv";
        follow(&page(head, "leg,xA_mm,yA_mm,zA_mm,xB_mm,yB_mm,zB_mm,h_mm")).unwrap();
        refused(&page(head, "leg,xA_mm,yA_mm,zA_mm,xB_mm,yB_mm,zB_mm,h_um"), "line 3: not printed like this:");
        let call = "paracal inspect nothing.toml";
        refused(&page(call, "..."), "exit code 2 and not 0");
        let error = "error: nothing.toml: cannot be read";
        let shown = page(call, error).replace("Try it.", "It fails (exit code 2):");
        refused(&shown, "not printed like this");
        refused(&page("paracal --version", "warning: none\n..."), "no such warning");
        let kept = page(
            "paracal --version > version.txt\nhead -n 1 version.txt",
            concat!("paracal ", env!("CARGO_PKG_VERSION")),
        );
        follow(&kept).unwrap();
        assert_eq!(cut("1,3-4", "a,b,c,d,e\n# all\n").unwrap(), "a,c,d\n# all\n");
    }

    #[test]
    fn a_line_that_differs_is_found_wherever_it_stands() {
        let printed = ["a", "b", "c", "b", "d"];
        for shown in ["a b c b d", "a ... d", "... c b d", "a ... b ...", "... b ... d", "..."] {
            let shown: Vec<&str> = shown.split(' ').collect();
            assert_eq!(compare(&shown, &printed), Ok(()), "{shown:?}");
        }
        for shown in
            ["a b c b", "a b c x d", "b ...", "a ... x d", "... d ...", "a b c b d ...", "... a", "... d b", "a a ..."]
        {
            let shown: Vec<&str> = shown.split(' ').collect();
            assert!(compare(&shown, &printed).is_err(), "{shown:?}");
        }
        assert!(compare(&["a"], &[]).is_err() && compare(&["...", "a", "..."], &[]).is_err());
    }

    #[test]
    fn links_that_lead_nowhere() {
        let text = "# One title, `code` and 2\n[a](#one-title-code-and-2) [b](#none) [c](../Cargo.toml) ![d](none.svg)\n\
                    [e](../README.md#the-commands) [f](../README.md#none) [g](https://example.org/x) `[h](none)`\n\
                    ```text\n[i](none)\n```\n";
        let found: Vec<String> = links(text).into_iter().filter(|l| l.starts_with('#')).collect();
        assert_eq!(found, ["#one-title-code-and-2", "#none"]);
        assert!(anchors(text).contains("one-title-code-and-2"));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("docs/page.md");
        fs::create_dir(folder.path().join("docs")).unwrap();
        fs::write(folder.path().join("Cargo.toml"), "").unwrap();
        fs::write(folder.path().join("README.md"), "## The commands\n").unwrap();
        fs::write(&path, text).unwrap();
        assert_eq!(broken(&path, text), ["#none", "none.svg", "../README.md#none"]);
    }
}
