//! A browser without a window, driven over the DevTools protocol on a pair of pipes.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// Longer than any page takes, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// The browser to use: `PARACAL_BROWSER`, or one that is on the path. `None` says that the tests are to be skipped.
pub fn find() -> Option<PathBuf> {
    let wanted = std::env::var("PARACAL_BROWSER").unwrap_or_default();
    if !wanted.is_empty() && wanted != "required" {
        assert!(Path::new(&wanted).exists(), "PARACAL_BROWSER: there is no {wanted}");
        return Some(wanted.into());
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let places = |name: &str| std::env::split_paths(&path).map(|p| p.join(name)).find(|p| p.is_file());
    let found = ["chromium", "chromium-browser", "google-chrome"].into_iter().find_map(places);
    assert!(found.is_some() || wanted != "required", "a browser is required, and none is on the path");
    if found.is_none() {
        eprintln!("SKIPPED: no browser on the path and none named by PARACAL_BROWSER");
    }
    found
}

/// A running browser with one open tab.
pub struct Browser {
    child: Child,
    input: ChildStdin,
    messages: Receiver<Value>,
    session: Option<String>,
    last: u64,
    events: Vec<Value>,
    _profile: tempfile::TempDir,
}

impl Browser {
    pub fn start(program: &Path) -> Self {
        let profile = tempfile::tempdir().unwrap();
        // The protocol wants descriptors 3 and 4; the shell puts our pipes there.
        let mut child = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1"])
            .arg(program)
            .args(["--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"])
            .args(["--disable-dev-shm-usage", "--disable-background-networking", "--no-first-run"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (input, output) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            let mut output = BufReader::new(output);
            loop {
                let mut bytes = Vec::new();
                match output.read_until(0, &mut bytes) {
                    Ok(n) if n > 1 => bytes.pop(),
                    _ => return,
                };
                if sender.send(serde_json::from_slice(&bytes).unwrap()).is_err() {
                    return;
                }
            }
        });
        let mut browser =
            Self { child, input, messages, session: None, last: 0, events: Vec::new(), _profile: profile };
        let target = browser.call("Target.createTarget", &json!({"url": "about:blank"}));
        let target = json!({"targetId": target["targetId"], "flatten": true});
        let session = browser.call("Target.attachToTarget", &target);
        browser.session = Some(session["sessionId"].as_str().unwrap().to_owned());
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), &json!({}));
        }
        browser.call("Page.setLifecycleEventsEnabled", &json!({"enabled": true}));
        browser
    }

    /// Calls a method of the protocol; what happens meanwhile is kept as events.
    pub fn call(&mut self, method: &str, parameters: &Value) -> Value {
        self.last += 1;
        let mut message = json!({"id": self.last, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.input.write_all(format!("{message}\0").as_bytes()).unwrap();
        let until = Instant::now() + PATIENCE;
        loop {
            let answer = self.next(until);
            if answer["id"] == json!(self.last) {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.events.push(answer);
        }
    }

    fn next(&mut self, until: Instant) -> Value {
        let left = until.saturating_duration_since(Instant::now());
        self.messages.recv_timeout(left).expect("the browser answers")
    }

    /// Opens a file and waits until it is loaded; the events of the loading.
    pub fn open(&mut self, url: &str) -> Vec<Value> {
        // An empty page in between, so that nothing of the page before is taken for one of this page.
        self.navigate("about:blank");
        self.events.clear();
        self.navigate(url);
        self.events()
    }

    fn navigate(&mut self, url: &str) {
        let answer = self.call("Page.navigate", &json!({"url": url}));
        assert!(answer["errorText"].is_null(), "{url}: {}", answer["errorText"]);
        let until = Instant::now() + PATIENCE;
        let loaded = |e: &Value| e["params"]["name"] == "load" && e["params"]["loaderId"] == answer["loaderId"];
        while !self.events.iter().any(loaded) {
            let event = self.next(until);
            self.events.push(event);
        }
    }

    /// What happened since the page was opened.
    pub fn events(&mut self) -> Vec<Value> {
        std::mem::take(&mut self.events)
    }

    /// The value of an expression in the page; a promise is awaited.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let wanted = json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        let answer = self.call("Runtime.evaluate", &wanted);
        assert!(answer["exceptionDetails"].is_null(), "{}", answer["exceptionDetails"]);
        answer["result"]["value"].clone()
    }

    /// The bytes that a method answers.
    pub fn bytes(&mut self, method: &str, parameters: &Value) -> Vec<u8> {
        decode(self.call(method, parameters)["data"].as_str().unwrap())
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Closing its input asks it to leave; whoever stays is ended.
        let close = json!({"id": 0, "method": "Browser.close"});
        let _ = self.input.write_all(format!("{close}\0").as_bytes());
        for _ in 0..50 {
            if matches!(self.child.try_wait(), Ok(Some(_))) {
                return;
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Base 64.
fn decode(text: &str) -> Vec<u8> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let text = text.trim_end_matches('=').as_bytes();
    let group = |four: &[u8]| {
        let bits = four.iter().fold(0_u32, |all, c| all << 6 | u32::from(digit(*c))) << (6 * (4 - four.len()));
        bits.to_be_bytes()[1..four.len()].to_vec()
    };
    text.chunks(4).flat_map(group).collect()
}
