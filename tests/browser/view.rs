//! The ways in which a page is shown, and what is wrong with it there.

use std::path::Path;

use serde_json::{Value, json};

use crate::devtools::Browser;

/// Width in CSS pixels, colours, medium.
#[derive(Debug)]
pub struct View {
    pub name: &'static str,
    pub width: u32,
    pub dark: bool,
    pub paper: bool,
}

/// The screens, and A4 between margins of 1 cm.
pub const VIEWS: [View; 5] = [
    View { name: "1280-light", width: 1280, dark: false, paper: false },
    View { name: "1280-dark", width: 1280, dark: true, paper: false },
    View { name: "390-light", width: 390, dark: false, paper: false },
    View { name: "390-dark", width: 390, dark: true, paper: false },
    View { name: "paper", width: 718, dark: false, paper: true },
];

/// Pictures are cut in pieces of this height: the browser paints no more than 16384 pixels.
const PIECE: u32 = 8000;

impl View {
    /// Shows a page and gives its faults, each as `kind: what`.
    pub fn faults(&self, browser: &mut Browser, page: &Path) -> Vec<String> {
        browser.call(
            "Emulation.setDeviceMetricsOverride",
            &json!({"width": self.width, "height": 800, "deviceScaleFactor": 1, "mobile": false}),
        );
        let scheme = json!([{"name": "prefers-color-scheme", "value": if self.dark { "dark" } else { "light" }}]);
        let medium = if self.paper { "print" } else { "screen" };
        browser.call("Emulation.setEmulatedMedia", &json!({"media": medium, "features": scheme}));
        let url = format!("file://{}", page.display());
        let mut events = browser.open(&url);
        let view = json!({"width": self.width, "dark": self.dark, "paper": self.paper});
        let judged = browser.evaluate(&format!("{}({view})", include_str!("check.js").trim_end()));
        events.extend(browser.events());
        let mut faults: Vec<String> = events.iter().filter_map(|event| told(event, &url)).collect();
        let judged = judged.as_array().unwrap();
        faults.extend(judged.iter().map(|fault| fault.as_str().unwrap().to_owned()));
        faults
    }

    /// Writes what is shown into a folder: pictures of the whole page, or a PDF.
    pub fn picture(&self, browser: &mut Browser, folder: &Path, name: &str) {
        std::fs::create_dir_all(folder).unwrap();
        if self.paper {
            let a4 = json!({"paperWidth": 8.27, "paperHeight": 11.69, "printBackground": true});
            let pdf = browser.bytes("Page.printToPDF", &a4);
            std::fs::write(folder.join(format!("{name}.pdf")), pdf).unwrap();
            return;
        }
        let height = browser.evaluate("document.scrollingElement.scrollHeight").as_u64().unwrap() as u32;
        for (k, top) in (0..height).step_by(PIECE as usize).enumerate() {
            let clip = json!({
                "x": 0, "y": top, "width": self.width, "height": PIECE.min(height - top), "scale": 1,
            });
            let png = browser.bytes("Page.captureScreenshot", &json!({"captureBeyondViewport": true, "clip": clip}));
            let part = if k == 0 { String::new() } else { format!("-{}", k + 1) };
            std::fs::write(folder.join(format!("{name}-{}{part}.png", self.name)), png).unwrap();
        }
    }
}

/// The fault that an event of the browser tells of.
fn told(event: &Value, url: &str) -> Option<String> {
    let about = &event["params"];
    match event["method"].as_str()? {
        "Runtime.exceptionThrown" => {
            let details = &about["exceptionDetails"];
            Some(format!("script: {} {}", details["text"], details["exception"]["description"]))
        }
        "Runtime.consoleAPICalled" if about["type"] == "error" || about["type"] == "warning" => {
            Some(format!("script: {} {}", about["type"], about["args"][0]["value"]))
        }
        // What could not be fetched is told as a request already.
        "Log.entryAdded" if about["entry"]["level"] == "error" && about["entry"]["source"] != "network" => {
            Some(format!("script: {}", about["entry"]["text"]))
        }
        "Network.requestWillBeSent" => {
            let wanted = about["request"]["url"].as_str()?;
            let own = wanted == url || wanted.starts_with("data:");
            (!own).then(|| format!("request: {wanted}"))
        }
        _ => None,
    }
}
