//! A plugin of QEMU that sends the address of every instruction at its execution, and of every write to a range of the
//! memory. The listener receives words of 32 bits in the machine's own order. The lowest bit is 1 for an instruction,
//! and 0 for a write. All unsafe code of the checks is here.
//!
//! The declarations are a part of `qemu-plugin.h` (QEMU's manual, "QEMU TCG Plugins"), version 3: QEMU 9.1 and later.

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::io::{BufWriter, Write};
use std::net::TcpStream;
use std::ops::Range;
use std::ptr;
use std::sync::{Mutex, OnceLock, PoisonError};

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

/// A callback is for writes.
const WRITES: c_int = 2;

unsafe extern "C" {
    fn qemu_plugin_register_vcpu_tb_trans_cb(id: u64, callback: OnBlock);
    fn qemu_plugin_tb_n_insns(block: *const Block) -> usize;
    fn qemu_plugin_tb_get_insn(block: *const Block, at: usize) -> *mut Translated;
    fn qemu_plugin_insn_vaddr(instruction: *const Translated) -> u64;
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

/// The listener, between two calls of the emulator.
static LISTENER: Mutex<Option<BufWriter<TcpStream>>> = Mutex::new(None);

/// The addresses of which writes are sent.
static WATCHED: OnceLock<Range<u32>> = OnceLock::new();

/// The bit of an instruction: its address is even.
const EXECUTED: u32 = 1;

/// The bits that no address of a word has.
const OF_A_WORD: u32 = 0b11;

/// Sends a word. Without a reader any more it is dropped.
fn send(word: u32) {
    let mut listener = LISTENER.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(stream) = &mut *listener
        && stream.write_all(&word.to_ne_bytes()).is_err()
    {
        *listener = None;
    }
}

/// Reads the arguments `listener=HOST:PORT` and `writes=FIRST-END`, two addresses in decimals, and connects to the
/// listener.
fn connect(arguments: &[&str]) -> Result<(TcpStream, Range<u32>), String> {
    let value = |name: &str| {
        let found = arguments.iter().find_map(|given| given.strip_prefix(name));
        found.ok_or_else(|| format!("the argument {name} is missing"))
    };
    let (address, range) = (value("listener=")?, value("writes=")?);
    let number = |digits: &str| digits.parse::<u32>().ok();
    let watched = range
        .split_once('-')
        .and_then(|(first, end)| Some(number(first)?..number(end)?))
        .ok_or_else(|| format!("writes={range} is no range: two addresses, as in writes=0-4"))?;
    let stream = TcpStream::connect(address)
        .map_err(|error| format!("no listener at {address}: {error}"))?;
    Ok((stream, watched))
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
    let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    match connect(&words) {
        Ok((stream, watched)) => {
            WATCHED.get_or_init(|| watched);
            let stream = BufWriter::with_capacity(1 << 16, stream);
            *LISTENER.lock().unwrap_or_else(PoisonError::into_inner) = Some(stream);
            // SAFETY: `id` is the emulator's own, and the callback lives as long as this library.
            unsafe { qemu_plugin_register_vcpu_tb_trans_cb(id, on_block) };
            0
        }
        Err(fault) => {
            eprintln!("trace: {fault}");
            1
        }
    }
}

/// A block is translated: registers callbacks for each of its instructions.
unsafe extern "C" fn on_block(_id: u64, block: *mut Block) {
    // SAFETY: the emulator hands over a block that lives during this call.
    let count = unsafe { qemu_plugin_tb_n_insns(block) };
    for at in 0..count {
        // SAFETY: `at` is below the count; the callbacks live as long as this library, and take their data for a
        // number.
        unsafe {
            let translated = qemu_plugin_tb_get_insn(block, at);
            let address = ptr::without_provenance_mut(qemu_plugin_insn_vaddr(translated) as usize);
            qemu_plugin_register_vcpu_insn_exec_cb(translated, on_execution, NO_REGISTERS, address);
            qemu_plugin_register_vcpu_mem_cb(translated, on_write, NO_REGISTERS, WRITES, address);
        }
    }
}

/// An instruction is about to be executed. The chip has addresses of 32 bits.
unsafe extern "C" fn on_execution(_cpu: c_uint, address: *mut c_void) {
    send(address.addr() as u32 | EXECUTED);
}

/// The instruction that is being executed writes memory.
unsafe extern "C" fn on_write(_cpu: c_uint, _info: u32, address: u64, _data: *mut c_void) {
    let address = address as u32;
    if WATCHED.get().is_some_and(|range| range.contains(&address)) {
        send(address & !OF_A_WORD);
    }
}
