//! The plugin's arguments, from the emulator's command line.

use std::ops::Range;

/// The code that is measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Watched {
    /// The handler's first instruction.
    pub(crate) handler: u32,
    /// Functions that only an emulated drive has: neither they nor their callees count.
    pub(crate) left_out: Vec<Range<u32>>,
    /// Addresses that an interrupt may pass; those that it passed are reported.
    pub(crate) marks: Vec<u32>,
}

impl Watched {
    pub(crate) fn leaves_out(&self, address: u32) -> bool {
        self.left_out.iter().any(|range| range.contains(&address))
    }

    /// The bit of a mark, where one is.
    pub(crate) fn mark_at(&self, address: u32) -> u32 {
        let found = self.marks.iter().position(|&mark| mark == address);
        found.map_or(0, |at| 1 << at)
    }
}

/// The code that is measured, and the address to which the costs are sent.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Request {
    pub(crate) watched: Watched,
    pub(crate) listener: String,
}

/// Bits for marks in a cost.
const MAX_MARKS: usize = 32;

impl Request {
    /// Reads `handler=ADDRESS`, `listener=HOST:PORT`, and as often as needed `mark=ADDRESS` and
    /// `leave-out=FROM-TO`, the end not included; addresses in hexadecimal digits.
    pub(crate) fn read<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Result<Self, String> {
        let (mut handler, mut listener) = (None, None);
        let (mut left_out, mut marks) = (Vec::new(), Vec::new());
        for argument in arguments {
            match argument.split_once('=') {
                Some(("handler", value)) => handler = Some(address(value)?),
                Some(("listener", value)) => listener = Some(value.to_owned()),
                Some(("mark", value)) => marks.push(address(value)?),
                Some(("leave-out", value)) => {
                    let (from, to) = value.split_once('-').ok_or_else(|| {
                        format!("leave-out={value} is no range: write FROM-TO in hexadecimal")
                    })?;
                    left_out.push(address(from)?..address(to)?);
                }
                _ => {
                    return Err(format!(
                        "{argument} is unknown: the arguments are handler, listener, mark and leave-out"
                    ));
                }
            }
        }
        if marks.len() > MAX_MARKS {
            return Err(format!("there are more than {MAX_MARKS} marks"));
        }
        Ok(Self {
            watched: Watched {
                handler: handler.ok_or("handler=ADDRESS is missing")?,
                left_out,
                marks,
            },
            listener: listener.ok_or("listener=HOST:PORT is missing")?,
        })
    }
}

fn address(text: &str) -> Result<u32, String> {
    u32::from_str_radix(text, 16)
        .map_err(|error| format!("{text} is no address: {error}; write it in hexadecimal digits"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_read() {
        let words = [
            "handler=800022c",
            "listener=127.0.0.1:5000",
            "mark=8015a58",
            "leave-out=8000400-8000480",
            "mark=8002000",
        ];
        let Request { watched, listener } = Request::read(words).expect("right");
        assert_eq!(listener, "127.0.0.1:5000");
        assert_eq!(watched.handler, 0x0800_022c);
        assert_eq!(watched.mark_at(0x0801_5a58), 0b01);
        assert_eq!(watched.mark_at(0x0800_2000), 0b10);
        assert_eq!(watched.mark_at(0x0800_022c), 0);
        assert!(watched.leaves_out(0x0800_0400));
        assert!(!watched.leaves_out(0x0800_0480));
    }

    #[test]
    fn a_wrong_request_is_refused() {
        let fault = |words: &[&str]| Request::read(words.iter().copied()).expect_err("wrong");
        assert!(fault(&["listener=a:1"]).contains("handler=ADDRESS"));
        assert!(fault(&["handler=10"]).contains("listener=HOST:PORT"));
        assert!(fault(&["handler=x1", "listener=a:1"]).contains("x1 is no address"));
        assert!(fault(&["leave-out=10"]).contains("FROM-TO"));
        assert!(fault(&["speed=3"]).contains("speed=3 is unknown"));
        let marks = ["mark=10"; MAX_MARKS + 1];
        assert!(fault(&marks).contains("marks"));
    }
}
