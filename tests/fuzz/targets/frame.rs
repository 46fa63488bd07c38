//! Bytes of any value on the drive's line: a message or an error per frame, and a message is the same when framed again.

#![no_main]

use drive_link::{Message, Receiver, Request, frame};
use libfuzzer_sys::fuzz_target;
use serde::ser::{Serialize, SerializeTuple, Serializer};

/// Bytes that are a message as they stand: only with their check are they looked at.
struct Bytes<'a>(&'a [u8]);

impl Message for Bytes<'_> {
    const SEED: u32 = Request::SEED;
}

impl Serialize for Bytes<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut bytes = serializer.serialize_tuple(self.0.len())?;
        self.0
            .iter()
            .try_for_each(|byte| bytes.serialize_element(byte))?;
        bytes.end()
    }
}

fuzz_target!(|bytes: &[u8]| {
    take(bytes);
    if let Ok(framed) = frame(&Bytes(bytes)) {
        take(&framed);
    }
});

fn take(bytes: &[u8]) {
    let mut receiver = Receiver::new();
    for &byte in bytes {
        let Some(Ok(request)) = receiver.take_request(byte) else {
            continue;
        };
        let framed = frame(&request).expect("a message that was received fits");
        let mut again = Receiver::new();
        let taken = framed.iter().find_map(|&byte| again.take_request(byte));
        let taken = taken
            .expect("a frame is whole")
            .expect("a frame is undamaged");
        assert_eq!(format!("{taken:?}"), format!("{request:?}"));
    }
}
