//! The end of a program that the system refuses memory.
//!
//! A Rust program that gets no memory aborts: no word of what it was at, no clean-up, and an exit status that looks like a mistake of the
//! program. With this allocator it says how much was asked for and how much is in use, removes what is unfinished and ends with
//! status 1. It serves every allocation, those of libraries included.

use std::alloc::{GlobalAlloc, Layout};
use std::fmt::Write;
use std::ptr::null_mut;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicPtr, AtomicU8, AtomicUsize, Ordering};

/// Kept free for the clean-up, bytes.
const RESERVE: usize = 1 << 20;
/// Bytes of a message, at most.
const MESSAGE: usize = 1024;
/// Bytes of a stage's name, at most.
const STAGE: usize = 32;
/// Seconds that a clean-up may take.
const PATIENCE: u32 = 10;
/// Exit status of a program without memory.
const STATUS: i32 = 1;

/// An allocator that ends the program where another one has no memory.
pub struct EndsProgram<A>(pub A);

// SAFETY: every call goes to the other allocator unchanged, and so does its answer.
unsafe impl<A: GlobalAlloc> GlobalAlloc for EndsProgram<A> {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the allocator's contract.
        granted(unsafe { self.0.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the allocator's contract.
        granted(unsafe { self.0.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the allocator's contract.
        unsafe { self.0.dealloc(block, layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller keeps the allocator's contract.
        granted(unsafe { self.0.realloc(block, layout, size) }, size)
    }
}

/// End of a program for want of memory.
struct End {
    clean_up: fn(),
    remedy: &'static str,
}

static END: OnceLock<End> = OnceLock::new();
static RESERVED: AtomicPtr<u8> = AtomicPtr::new(null_mut());
/// A number of the thread that ends the program; 0 for none.
static ENDING: AtomicUsize = AtomicUsize::new(0);
static STAGE_NAME: [AtomicU8; STAGE] = [const { AtomicU8::new(0) }; STAGE];

/// From now on the program ends for want of memory with a message that closes with a remedy, after a clean-up that removes what is
/// unfinished. For programs with [`EndsProgram`], at their start.
pub fn end_with(remedy: &'static str, clean_up: fn()) {
    if END.set(End { clean_up, remedy }).is_ok() {
        RESERVED.store(
            Vec::<u8>::with_capacity(RESERVE).leak().as_mut_ptr(),
            Ordering::SeqCst,
        );
    }
}

/// Ends the program unless so many bytes of a limited address space are left: for libraries that don't survive that they aren't.
pub fn demand(bytes: usize) {
    if address_space_limit().is_some() {
        std::hint::black_box(Vec::<u8>::with_capacity(bytes));
    }
}

/// Present task of the program, for the message.
pub fn at_stage(name: &str) {
    let bytes = name.bytes().chain(std::iter::repeat(0));
    for (place, byte) in STAGE_NAME.iter().zip(bytes) {
        place.store(byte, Ordering::Relaxed);
    }
}

fn granted(block: *mut u8, size: usize) -> *mut u8 {
    if block.is_null()
        && let Some(end) = END.get()
    {
        end_program(end, size);
    }
    block
}

#[cfg(unix)]
fn end_program(end: &End, size: usize) {
    // The address of something that each thread has its own of.
    thread_local! { static OWN: u8 = const { 0 } }
    let thread = OWN.with(|own| own as *const u8 as usize);
    match ENDING.compare_exchange(0, thread, Ordering::SeqCst, Ordering::SeqCst) {
        Ok(_) => {}
        // The clean-up has no memory either.
        Err(other) if other == thread => exit(),
        Err(_) => loop {
            std::thread::park();
        },
    }
    let mut message = Message::default();
    // What doesn't fit the message is left out.
    let _ = write_message(&mut message, size, end.remedy);
    message.print();
    let reserved = RESERVED.swap(null_mut(), Ordering::SeqCst);
    if !reserved.is_null() {
        // SAFETY: the block was leaked by `end_with`, with this capacity, and nobody else takes it.
        drop(unsafe { Vec::from_raw_parts(reserved, 0, RESERVE) });
    }
    // A clean-up that waits for what this thread holds never ends.
    // SAFETY: the handler does nothing but end the program.
    unsafe {
        libc::signal(libc::SIGALRM, on_alarm as *const () as libc::sighandler_t);
        libc::alarm(PATIENCE);
    }
    (end.clean_up)();
    exit();
}

#[cfg(not(unix))]
fn end_program(_: &End, _: usize) {}

#[cfg(unix)]
extern "C" fn on_alarm(_: libc::c_int) {
    exit();
}

#[cfg(unix)]
fn exit() -> ! {
    // SAFETY: ends the program without running anything of it.
    unsafe { libc::_exit(STATUS) }
}

fn write_message(message: &mut Message, size: usize, remedy: &str) -> std::fmt::Result {
    let megabytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    write!(message, "error: out of memory")?;
    let mut stage = [0; STAGE];
    for (byte, place) in stage.iter_mut().zip(&STAGE_NAME) {
        *byte = place.load(Ordering::Relaxed);
    }
    let length = stage.iter().position(|byte| *byte == 0).unwrap_or(STAGE);
    if let Ok(stage) = std::str::from_utf8(&stage[..length])
        && !stage.is_empty()
    {
        write!(message, " in the stage {stage:?}")?;
    }
    let more = megabytes(size as u64);
    write!(message, ": {more:.1} MB more are needed")?;
    let used = address_space();
    if let Some(used) = used {
        write!(message, " beside the {:.0} MB in use", megabytes(used))?;
    }
    if let Some(limit) = address_space_limit() {
        write!(
            message,
            ", {:.0} MB are allowed (ulimit -v)",
            megabytes(limit)
        )?;
    }
    writeln!(message, "; {remedy}")
}

/// Address space in use, bytes; without allocating.
#[cfg(target_os = "linux")]
fn address_space() -> Option<u64> {
    let mut text = [0_u8; 64];
    // SAFETY: a path that ends with a zero, and a buffer of the length that is told.
    let length = unsafe {
        let file = libc::open(c"/proc/self/statm".as_ptr(), libc::O_RDONLY);
        let length = libc::read(file, text.as_mut_ptr().cast(), text.len());
        libc::close(file);
        usize::try_from(length).ok()?
    };
    let text = std::str::from_utf8(text.get(..length)?).ok()?;
    let pages: u64 = text.split(' ').next()?.parse().ok()?;
    // SAFETY: asks for a constant.
    let page = u64::try_from(unsafe { libc::sysconf(libc::_SC_PAGESIZE) }).ok()?;
    Some(pages * page)
}

#[cfg(not(target_os = "linux"))]
fn address_space() -> Option<u64> {
    None
}

/// Address space that this program may have, bytes; `None` for no limit.
#[cfg(unix)]
pub fn address_space_limit() -> Option<u64> {
    let mut limit = libc::rlimit {
        rlim_cur: 0,
        rlim_max: 0,
    };
    // SAFETY: writes the limit that it is given.
    let answer = unsafe { libc::getrlimit(libc::RLIMIT_AS, &mut limit) };
    (answer == 0 && limit.rlim_cur != libc::RLIM_INFINITY).then_some(limit.rlim_cur)
}

/// Address space that this program may have, bytes; `None` for no limit.
#[cfg(not(unix))]
pub fn address_space_limit() -> Option<u64> {
    None
}

/// Text in a place of its own: there is no memory for more.
struct Message {
    bytes: [u8; MESSAGE],
    length: usize,
}

impl Default for Message {
    fn default() -> Self {
        Self {
            bytes: [0; MESSAGE],
            length: 0,
        }
    }
}

impl Message {
    #[cfg(unix)]
    fn print(&self) {
        // SAFETY: as many bytes as there are.
        let _ = unsafe { libc::write(2, self.bytes.as_ptr().cast(), self.length) };
    }
}

impl Write for Message {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        let room = &mut self.bytes[self.length..];
        let length = text.len().min(room.len());
        room[..length].copy_from_slice(&text.as_bytes()[..length]);
        self.length += length;
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_message_names_stage_size_and_remedy() {
        at_stage("factor");
        let mut message = Message::default();
        write_message(&mut message, 3 << 20, "take more").unwrap();
        let text = std::str::from_utf8(&message.bytes[..message.length]).unwrap();
        assert!(
            text.starts_with(
                "error: out of memory in the stage \"factor\": 3.0 MB more are needed"
            )
        );
        assert!(text.ends_with("; take more\n"), "{text}");
        at_stage("");
        write_message(&mut message, 1, &"long ".repeat(MESSAGE)).unwrap();
        assert_eq!(message.length, MESSAGE);
    }
}
