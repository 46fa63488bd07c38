//! QEMU's interface for plugins, and all unsafe code.
//!
//! The declarations are a part of `qemu-plugin.h` (QEMU's manual, "QEMU TCG Plugins"), version 3, the first
//! that copies an instruction's bytes: QEMU 9.1 and later.

use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::io::{BufWriter, Write};
use std::net::TcpStream;
use std::sync::{Mutex, PoisonError};

use thumb::Instruction;

use crate::meter::{Lost, Meter};
use crate::request::Request;

/// The version of the interface.
#[unsafe(no_mangle)]
static qemu_plugin_version: c_int = 3;

/// A block of instructions that the emulator translates, and one of them.
#[repr(C)]
struct Block {
    _opaque: [u8; 0],
}
#[repr(C)]
struct Translated {
    _opaque: [u8; 0],
}

type OnBlock = unsafe extern "C" fn(id: u64, block: *mut Block);
type OnExecution = unsafe extern "C" fn(cpu: c_uint, data: *mut c_void);
type OnAccess = unsafe extern "C" fn(cpu: c_uint, info: u32, address: u64, data: *mut c_void);

/// A callback uses no registers of the processor.
const NO_REGISTERS: c_int = 0;

/// A callback is for reads.
const READS: c_int = 1;

unsafe extern "C" {
    fn qemu_plugin_register_vcpu_tb_trans_cb(id: u64, callback: OnBlock);
    fn qemu_plugin_tb_n_insns(block: *const Block) -> usize;
    fn qemu_plugin_tb_get_insn(block: *const Block, at: usize) -> *mut Translated;
    fn qemu_plugin_insn_vaddr(instruction: *const Translated) -> u64;
    fn qemu_plugin_insn_data(
        instruction: *const Translated,
        bytes: *mut c_void,
        length: usize,
    ) -> usize;
    fn qemu_plugin_register_vcpu_insn_exec_cb(
        instruction: *mut Translated,
        callback: OnExecution,
        registers: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_register_vcpu_mem_cb(
        instruction: *mut Translated,
        callback: OnAccess,
        registers: c_int,
        which: c_int,
        data: *mut c_void,
    );
}

/// The state between two calls of the emulator.
static SESSION: Mutex<Option<Session>> = Mutex::new(None);

struct Session {
    meter: Meter,
    report: BufWriter<TcpStream>,
    /// Decoded instructions: the emulator translates the same code repeatedly.
    decoded: HashMap<(u32, [u8; 4]), &'static Instruction>,
}

impl Session {
    fn begin(request: Request) -> Result<Self, String> {
        let Request { watched, listener } = request;
        let stream = TcpStream::connect(&listener)
            .map_err(|error| format!("no listener at {listener}: {error}"))?;
        Ok(Self {
            meter: Meter::new(watched),
            report: BufWriter::new(stream),
            decoded: HashMap::new(),
        })
    }

    fn decode(&mut self, address: u32, bytes: [u8; 4]) -> &'static Instruction {
        self.decoded.entry((address, bytes)).or_insert_with(|| {
            // As many as the program has, and the emulator keeps them until it ends.
            let [a, b, c, d] = bytes;
            let halves = [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])];
            Box::leak(Box::new(Instruction::decode(address, halves)))
        })
    }

    /// Writes a line per interrupt; without a reader any more it is dropped.
    fn execute(&mut self, instruction: &Instruction) {
        let _ = match self.meter.execute(instruction) {
            Ok(None) => Ok(()),
            Ok(Some(cost)) => writeln!(
                self.report,
                "{} {} {}",
                cost.marks, cost.instructions, cost.cycles
            ),
            Err(Lost) => writeln!(self.report, "lost").and_then(|()| self.report.flush()),
        };
    }
}

fn with_session<T>(act: impl FnOnce(&mut Session) -> T) -> Option<T> {
    let mut session = SESSION.lock().unwrap_or_else(PoisonError::into_inner);
    session.as_mut().map(act)
}

/// Called by the emulator as it starts; anything but 0 ends it.
///
/// # Safety
/// `values` must point to `count` strings that end with a zero.
#[unsafe(no_mangle)]
unsafe extern "C" fn qemu_plugin_install(
    id: u64,
    _info: *const c_void,
    count: c_int,
    values: *const *const c_char,
) -> c_int {
    let words: Vec<_> = (0..usize::try_from(count).unwrap_or(0))
        .map(|at| {
            // SAFETY: as this function asks of its caller.
            unsafe { CStr::from_ptr(*values.add(at)) }.to_string_lossy()
        })
        .collect();
    let words = words.iter().map(AsRef::as_ref);
    match Request::read(words).and_then(Session::begin) {
        Ok(session) => {
            *SESSION.lock().unwrap_or_else(PoisonError::into_inner) = Some(session);
            // SAFETY: `id` is the emulator's own, and the callback lives as long as this library.
            unsafe { qemu_plugin_register_vcpu_tb_trans_cb(id, on_block) };
            0
        }
        Err(fault) => {
            eprintln!("interrupt-meter: {fault}");
            1
        }
    }
}

/// A block is translated: registers callbacks for each of its instructions.
unsafe extern "C" fn on_block(_id: u64, block: *mut Block) {
    // SAFETY: the emulator hands over a block that lives during this call.
    let count = unsafe { qemu_plugin_tb_n_insns(block) };
    for at in 0..count {
        let mut bytes = [0; 4];
        // SAFETY: `at` is below the count; the bytes have room for the longest instruction.
        let (translated, address) = unsafe {
            let translated = qemu_plugin_tb_get_insn(block, at);
            qemu_plugin_insn_data(translated, bytes.as_mut_ptr().cast(), bytes.len());
            (translated, qemu_plugin_insn_vaddr(translated))
        };
        // The chip has addresses of 32 bits.
        let Some(instruction) = with_session(|session| session.decode(address as u32, bytes))
        else {
            return;
        };
        let data = std::ptr::from_ref(instruction).cast_mut().cast();
        // SAFETY: the callbacks live as long as this library, their data for ever; they only read
        // it.
        unsafe {
            qemu_plugin_register_vcpu_insn_exec_cb(translated, on_execution, NO_REGISTERS, data);
            qemu_plugin_register_vcpu_mem_cb(translated, on_read, NO_REGISTERS, READS, data);
        }
    }
}

/// An instruction is about to be executed.
unsafe extern "C" fn on_execution(_cpu: c_uint, data: *mut c_void) {
    // SAFETY: `on_block` gave a shared reference that lives for ever.
    let instruction = unsafe { &*data.cast::<Instruction>() };
    with_session(|session| session.execute(instruction));
}

/// The instruction that is being executed reads memory.
unsafe extern "C" fn on_read(_cpu: c_uint, _info: u32, address: u64, _data: *mut c_void) {
    with_session(|session| session.meter.load(address as u32));
}
