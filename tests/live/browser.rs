//! The page in a real browser: Debian's Chromium, which `./setup.sh --peers` installs, told by pipes what to do
//! (https://chromedevtools.github.io/devtools-protocol). Screenshots stay in `target/tmp`.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread;
use std::time::Duration;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

use crate::support::command::{Folder, Run};
use crate::web::{Served, serve};
use crate::{SCENE, end, interrupt};

/// A browser with one page.
struct Browser {
    process: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
    asked: u64,
    session: Option<String>,
    /// Addresses that the page has asked for.
    requests: Vec<String>,
    /// What has gone wrong in its script.
    exceptions: Vec<Value>,
    _profile: tempfile::TempDir,
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Browser {
    fn open(address: &str) -> Self {
        let profile = tempfile::tempdir().expect("a folder");
        let options = "--headless --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run \
                       --hide-scrollbars --remote-debugging-pipe";
        // It reads from descriptor 3 and writes to 4.
        let script = format!(
            "exec 3<&0 4>&1; exec chromium {options} --user-data-dir='{}' </dev/null >/dev/null 2>&1",
            profile.path().display()
        );
        let mut process = Command::new("sh")
            .args(["-c", &script])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("a shell is there");
        let questions = process.stdin.take().expect("piped");
        let answers = BufReader::new(process.stdout.take().expect("piped"));
        let mut browser = Self {
            process,
            questions,
            answers,
            asked: 0,
            session: None,
            requests: Vec::new(),
            exceptions: Vec::new(),
            _profile: profile,
        };
        let target = browser.ask("Target.createTarget", &json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let attached = browser.ask("Target.attachToTarget", &attach);
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Network", "Runtime", "Page"] {
            browser.ask(&format!("{domain}.enable"), &json!({}));
        }
        browser.size(1280, 800);
        browser.ask("Page.navigate", &json!({ "url": address }));
        browser
    }

    fn ask(&mut self, method: &str, parameters: &Value) -> Value {
        self.asked += 1;
        let mut question = json!({ "id": self.asked, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            question["sessionId"] = session.as_str().into();
        }
        self.questions.write_all(format!("{question}\0").as_bytes()).expect("it reads");
        loop {
            let mut answer = Vec::new();
            let count = self.answers.read_until(0, &mut answer).expect("it writes");
            assert!(count > 0, "chromium has ended; ./setup.sh --peers installs it");
            answer.pop();
            let answer: Value = serde_json::from_slice(&answer).expect("JSON");
            match answer["method"].as_str() {
                Some("Network.requestWillBeSent") => {
                    let address = answer["params"]["request"]["url"].as_str().expect("an address");
                    self.requests.push(address.to_owned());
                }
                Some("Runtime.exceptionThrown") => self.exceptions.push(answer),
                _ if answer["id"] == self.asked => {
                    assert!(answer["error"].is_null(), "{method}: {answer}");
                    return answer["result"].clone();
                }
                _ => {}
            }
        }
    }

    fn size(&mut self, width: u32, height: u32) {
        let metrics =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.ask("Emulation.setDeviceMetricsOverride", &metrics);
    }

    fn evaluate(&mut self, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "returnByValue": true });
        let result = self.ask("Runtime.evaluate", &parameters);
        assert!(result["exceptionDetails"].is_null(), "{expression}: {result}");
        result["result"]["value"].clone()
    }

    fn wait_until(&mut self, expression: &str) {
        while self.evaluate(expression) != true {
            thread::sleep(Duration::from_millis(20));
        }
    }

    fn text(&mut self, id: &str) -> String {
        let text = self.evaluate(&format!("document.getElementById('{id}').textContent"));
        text.as_str().expect("text").to_owned()
    }

    fn point_at(&mut self, x: u32, y: u32) {
        let event = json!({ "type": "mouseMoved", "x": x, "y": y });
        self.ask("Input.dispatchMouseEvent", &event);
    }

    /// Bytes of the canvas, four for each pixel.
    fn canvas(&mut self) -> Vec<u8> {
        let script = "{ const c = document.getElementById('picture');
            btoa([...c.getContext('2d').getImageData(0, 0, c.width, c.height).data]
                .map(b => String.fromCharCode(b)).join('')) }";
        let text = self.evaluate(script);
        BASE64_STANDARD.decode(text.as_str().expect("text")).expect("base 64")
    }

    fn screenshot(&mut self, name: &str) {
        let shot = self.ask("Page.captureScreenshot", &json!({}));
        let bytes = BASE64_STANDARD.decode(shot["data"].as_str().expect("text")).expect("base 64");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
        fs::write(folder.join(name), bytes).expect("writable");
    }
}

/// Begins of the text of the layers' values in the loupe.
const LOUPE: &str = "document.getElementById('values').textContent";

#[test]
fn the_page_shows_what_is_rendered() {
    let folder = Folder::with_scene(SCENE);
    let arguments = "--spp 4000000000 --error 1e-9 -o b.png --live web";
    let Served { child, host, path, rest } = serve(&folder, arguments);
    let address = format!("http://{host}{path}");
    let mut browser = Browser::open(&address);
    browser.wait_until("document.getElementById('zoom') !== null");
    browser.wait_until("parseFloat(document.getElementById('samples').textContent) >= 16");
    browser.wait_until("/^[0-9]/.test(document.getElementById('error').textContent)");
    assert_eq!(browser.text("scene"), "scene.xml");
    assert_eq!(browser.text("error-name"), "Error (relMSE)");
    assert!(browser.text("error").ends_with(", asked 1e-9"));
    assert_eq!(browser.text("state"), "0 %");

    // The loupe shows the pixel under the pointer, which has a value for each channel.
    browser.point_at(640, 380);
    browser.wait_until("!document.getElementById('loupe').hidden");
    let values = browser.evaluate(LOUPE);
    let values = values.as_str().expect("text");
    assert!(values.starts_with("pixel 321,") && values.contains("\nR ") && values.contains("\nB "));
    browser.screenshot("live-1280.png");
    // Nothing of the page is out of sight, however narrow the screen.
    for (width, height) in [(1280, 800), (390, 844), (320, 568), (844, 390)] {
        browser.size(width, height);
        // Twice as long as a frame: the page has been laid out again.
        browser.wait_until(&format!("innerWidth === {width}"));
        let fits = format!(
            "{{ const all = document.documentElement, box = document.getElementById('picture').getBoundingClientRect();
                all.scrollWidth <= {width} && all.scrollHeight <= {height} && box.left >= 0 && box.right <= {width}
                && box.width > 0 && Math.abs(box.width / box.height - 637 / 478) < 0.02 }}"
        );
        browser.wait_until(&fits);
        if width == 390 {
            browser.point_at(200, 250);
            browser.wait_until("!document.getElementById('loupe').hidden");
            browser.screenshot("live-390.png");
        }
    }
    browser.size(1280, 800);
    for (layer, start) in [(1, "\n "), (2, "\nx ")] {
        browser.evaluate(&format!(
            "{{ const s = document.getElementById('layer'); s.value = {layer}; s.dispatchEvent(new Event('change')) }}"
        ));
        browser.point_at(640, 381 + layer);
        browser.wait_until(&format!("{LOUPE}.includes({})", json!(start)));
        browser.screenshot(&format!("live-layer-{layer}.png"));
    }

    interrupt(&child);
    browser.wait_until("document.getElementById('state').textContent === 'interrupted'");
    let Run { code, stderr, .. } = end(child, rest);
    assert_eq!(code, Some(130), "{stderr}");

    // Nobody answers any more, and all is there: the picture, brighter and darker, and its layers.
    let choose = |layer: u32, stops: i32| {
        format!(
            "{{ const s = document.getElementById('layer'), e = document.getElementById('exposure');
                s.value = {layer}; s.dispatchEvent(new Event('change'));
                e.value = {stops}; e.dispatchEvent(new Event('input')) }}"
        )
    };
    for (layer, seen) in [(1, "depth"), (2, "normal")] {
        browser.evaluate(&choose(layer, 0));
        let canvas = browser.canvas();
        assert!(canvas.chunks(4).any(|p| p[..3] != canvas[..3]), "{seen}");
    }
    browser.evaluate(&choose(0, -1));
    let dark = browser.canvas();
    browser.evaluate(&choose(0, 0));
    let canvas = browser.canvas();
    let sum = |bytes: &[u8]| bytes.iter().map(|b| u64::from(*b)).sum::<u64>();
    assert!(sum(&dark) < sum(&canvas));
    // The table of the page has 9 bits of a number, thus an error of 2⁻¹⁰, which changes a byte by one at most.
    let (width, height, written) = folder.png("b.png");
    assert_eq!((width, height, canvas.len()), (637, 478, 4 * 637 * 478));
    for (pixel, (seen, written)) in canvas.chunks(4).zip(written.chunks(3)).enumerate() {
        let near = seen.iter().zip(written).all(|(a, b)| a.abs_diff(*b) <= 1);
        assert!(near && seen[3] == 255, "pixel {pixel}: {seen:?} and not {written:?}");
    }
    browser.screenshot("live-ended.png");
    assert_eq!(browser.exceptions, Vec::<Value>::new());
    let elsewhere: Vec<_> = browser.requests.iter().filter(|r| !r.starts_with(&address)).collect();
    assert!(elsewhere.iter().all(|r| r.starts_with("data:")), "{elsewhere:?}");
}
