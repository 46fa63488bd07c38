//! A headless browser, driven as W3C WebDriver has it.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};

/// A driver with the port that it listens on; none if it has ended without one.
fn with_port(mut driver: Child) -> Option<(Child, String)> {
    let mut lines = BufReader::new(driver.stdout.take().expect("it is piped")).lines();
    let port = lines.find_map(|line| {
        let line = line.expect("the driver prints its port");
        let port = line
            .split("on port ")
            .nth(1)?
            .trim_end_matches('.')
            .to_owned();
        line.contains("started successfully").then_some(port)
    });
    // Later output is discarded, but must be read.
    std::thread::spawn(move || lines.for_each(drop));
    if port.is_none() {
        let _ = driver.wait();
    }
    Some((driver, port?))
}

/// Colours of a canvas that are seen at all.
pub(crate) const SEEN: &str = "
    const seen = (canvas) => {
        const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
        copy.drawImage(canvas, 0, 0);
        const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
        const colours = new Set();
        for (let i = 0; i < data.length; i += 4)
            if (data[i + 3] > 200) colours.add(data.slice(i, i + 3).join());
        return [...colours];
    };";

/// A number of a page.
pub(crate) fn number(value: &Value) -> f64 {
    let number = value.as_f64();
    number.unwrap_or_else(|| panic!("no number: {value}"))
}

/// A browser with one page.
pub(crate) struct Browser {
    driver: Child,
    session: String,
}

impl Browser {
    /// A browser; `None` where none is installed: the test then reports itself as skipped. CI must have one.
    pub(crate) fn start() -> Option<Self> {
        /// Drivers that are started at once may find the same port free, and all but one of them end.
        const ATTEMPTS: usize = 5;
        let mut started = None;
        for _ in 0..ATTEMPTS {
            let Ok(driver) = Command::new("chromedriver")
                .arg("--port=0")
                .stdout(Stdio::piped())
                .stderr(Stdio::null())
                .spawn()
            else {
                let missing = "no browser: install the packages chromium and chromium-driver";
                assert!(std::env::var_os("CI").is_none(), "{missing}");
                // Past the capture of the output of tests that pass.
                let line = format!("\nskipped: {missing}\n");
                let _ = std::io::stderr().write_all(line.as_bytes());
                return None;
            };
            started = with_port(driver);
            if started.is_some() {
                break;
            }
        }
        let (driver, port) = started.expect("a driver started");
        let server = format!("http://127.0.0.1:{port}/session");
        // Root, as CI is, has no sandbox; only pages of our own are opened.
        let wanted = json!({ "capabilities": { "alwaysMatch": {
            "browserName": "chrome",
            "goog:chromeOptions": { "args": [
                "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                "--window-size=1280,1000",
            ] },
            "goog:loggingPrefs": { "browser": "ALL" },
        } } });
        let answer = post(&server, &wanted);
        let session = answer["sessionId"].as_str().expect("a session");
        Some(Self {
            driver,
            session: format!("{server}/{session}"),
        })
    }

    pub(crate) fn open(&self, address: &str) {
        self.call("url", &json!({ "url": address }));
    }

    /// Result of a function's body in the page.
    pub(crate) fn ask(&self, body: &str) -> Value {
        self.call("execute/sync", &json!({ "script": body, "args": [] }))
    }

    /// Presses and releases keys, one after the other.
    pub(crate) fn press(&self, keys: &[&str]) {
        let both = |key: &&str| {
            let of = |kind: &str| json!({ "type": kind, "value": key });
            [of("keyDown"), of("keyUp")]
        };
        let presses: Vec<Value> = keys.iter().flat_map(both).collect();
        let actions = json!({ "actions": [{ "type": "key", "id": "keys", "actions": presses }] });
        self.call("actions", &actions);
    }

    /// Moves the pointer to places of the window, pressed from the first to the last.
    pub(crate) fn drag(&self, from: [i64; 2], to: [i64; 2]) {
        let to_place =
            |[x, y]: [i64; 2]| json!({ "type": "pointerMove", "duration": 50, "x": x, "y": y });
        let actions = json!({ "actions": [{ "type": "pointer", "id": "mouse", "actions": [
            to_place(from), { "type": "pointerDown", "button": 0 }, to_place(to), { "type": "pointerUp", "button": 0 },
        ] }] });
        self.call("actions", &actions);
    }

    /// Emulates something, as the DevTools protocol has it.
    pub(crate) fn emulate(&self, what: &str, how: &Value) {
        let command = json!({ "cmd": format!("Emulation.{what}"), "params": how });
        self.call("goog/cdp/execute", &command);
    }

    /// Has a screen of these points, each of some dots.
    pub(crate) fn show_on(&self, [width, height]: [u32; 2], dots: u32) {
        let screen = json!({ "width": width, "height": height, "deviceScaleFactor": dots, "mobile": width < 800 });
        self.emulate("setDeviceMetricsOverride", &screen);
    }

    /// Has features of media: their names and values.
    pub(crate) fn prefer(&self, features: &[[&str; 2]]) {
        let feature = |[name, value]: &[&str; 2]| json!({ "name": name, "value": value });
        let features: Vec<Value> = features.iter().map(feature).collect();
        let media = json!({ "media": "", "features": features });
        self.emulate("setEmulatedMedia", &media);
    }

    /// Asserts that nothing was said at the console since the last call.
    pub(crate) fn assert_silent(&self) {
        let said = self.call("se/log", &json!({ "type": "browser" }));
        assert_eq!(said, json!([]));
    }

    fn call(&self, command: &str, body: &Value) -> Value {
        post(&format!("{}/{command}", self.session), body)
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // The driver ends its browser with the session.
        let _ = minreq::delete(&self.session).send();
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}

fn post(address: &str, body: &Value) -> Value {
    let request = minreq::post(address).with_json(body).expect("JSON");
    let answer = request.send().expect("the driver answers");
    let mut answer: Value = answer.json().expect("JSON");
    let value = answer["value"].take();
    assert!(value.get("error").is_none(), "{address}: {value}");
    value
}
