//! The blocks of a text, worked on by all threads while the next ones are read.
//!
//! Blocks of whole lines are read and hashed one after the other and handed to the threads; what they make of them stays in file order, so
//! that the result doesn't depend on the number of threads. Of the text nothing is kept.

use std::sync::mpsc::{Receiver, Sender, channel};

use rayon::{Scope, Yield};

use super::bytes::TextBlocks;
use crate::Error;

/// Blocks for each thread that are in memory together.
const BLOCKS_PER_THREAD: usize = 2;
/// Blocks beside those: a thread that the system holds up leaves work for the others.
const FURTHER_BLOCKS: usize = 16;

/// Whether what comes after a block can still matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// It can.
    Wanted,
    /// Nothing behind what was read is needed.
    Unwanted,
}

/// Makes something of every block of a text, in file order. `work` is called by any thread; `took` by this one, in file order too, as soon as a
/// block and all before it are done, and with the bytes of text read so far. It may take out what it wants.
///
/// # Errors
/// As [`TextBlocks::next_block`], and those of `took`.
pub fn read_blocks<T: Default + Send>(
    text: &mut TextBlocks,
    work: impl Fn(&[u8]) -> T + Sync,
    took: impl FnMut(&mut T, u64) -> Result<Rest, Error> + Send,
) -> Result<Vec<T>, Error> {
    read_blocks_in_context(text, |_| (), |block, ()| work(block), took)
}

/// As [`read_blocks`], for texts in which what stands in one block says how the next ones are read: `look` sees the blocks in file order
/// before they are worked on, and what it tells of each goes with the block.
///
/// # Errors
/// As [`read_blocks`].
pub fn read_blocks_in_context<T: Default + Send, C: Send>(
    text: &mut TextBlocks,
    look: impl FnMut(&[u8]) -> C + Send,
    work: impl Fn(&[u8], C) -> T + Sync,
    took: impl FnMut(&mut T, u64) -> Result<Rest, Error> + Send,
) -> Result<Vec<T>, Error> {
    rayon::scope(|scope| Reading::new(took).read(scope, text, look, &work))
}

/// Content made of a block: its number, the content, and the buffer for another one.
type Done<T> = (usize, T, Vec<u8>);

/// A block that is worked on. It is handed back however the work ends, so that nobody waits for it for ever.
struct Work<T: Default> {
    number: usize,
    content: T,
    buffer: Vec<u8>,
    done: Sender<Done<T>>,
}

impl<T: Default> Work<T> {
    fn read<C>(mut self, used: usize, context: C, work: &impl Fn(&[u8], C) -> T) {
        self.content = work(&self.buffer[..used], context);
    }
}

impl<T: Default> Drop for Work<T> {
    fn drop(&mut self) {
        let (content, buffer) = (
            std::mem::take(&mut self.content),
            std::mem::take(&mut self.buffer),
        );
        // Nobody listens any more where reading has ended with an error.
        let _ = self.done.send((self.number, content, buffer));
    }
}

/// Blocks on their way through the threads.
struct Reading<T, F> {
    took: F,
    sender: Sender<Done<T>>,
    receiver: Receiver<Done<T>>,
    contents: Vec<T>,
    /// Whether a content is there.
    is_done: Vec<bool>,
    /// Contents from the first on that were taken.
    taken: usize,
    spare: Vec<Vec<u8>>,
    in_work: usize,
    rest: Rest,
}

impl<T: Default + Send, F: FnMut(&mut T, u64) -> Result<Rest, Error>> Reading<T, F> {
    fn new(took: F) -> Self {
        let (sender, receiver) = channel();
        Self {
            took,
            sender,
            receiver,
            contents: Vec::new(),
            is_done: Vec::new(),
            taken: 0,
            spare: Vec::new(),
            in_work: 0,
            rest: Rest::Wanted,
        }
    }

    fn read<'s, C: Send + 's>(
        mut self,
        scope: &Scope<'s>,
        text: &mut TextBlocks,
        mut look: impl FnMut(&[u8]) -> C,
        work: &'s (impl Fn(&[u8], C) -> T + Sync),
    ) -> Result<Vec<T>, Error>
    where
        T: 's,
    {
        let most = BLOCKS_PER_THREAD * rayon::current_num_threads() + FURTHER_BLOCKS;
        while self.rest == Rest::Wanted {
            let mut buffer = self.spare.pop().unwrap_or_default();
            let used = text.next_block(&mut buffer)?;
            if used == 0 {
                break;
            }
            let context = look(&buffer[..used]);
            let block = Work {
                number: self.contents.len(),
                content: T::default(),
                buffer,
                done: self.sender.clone(),
            };
            self.contents.push(T::default());
            self.is_done.push(false);
            self.in_work += 1;
            scope.spawn(move |_| block.read(used, context, work));
            while self.in_work >= most {
                self.take_one(text.length())?;
            }
        }
        while self.in_work > 0 {
            self.take_one(text.length())?;
        }
        Ok(self.contents)
    }

    /// Waits for a block, and works on one meanwhile.
    fn take_one(&mut self, text_length: u64) -> Result<(), Error> {
        let (number, content, buffer) = loop {
            if let Ok(done) = self.receiver.try_recv() {
                break done;
            }
            if rayon::yield_now() != Some(Yield::Executed) {
                std::thread::yield_now();
            }
        };
        self.in_work -= 1;
        self.spare.push(buffer);
        self.contents[number] = content;
        self.is_done[number] = true;
        while self.is_done.get(self.taken) == Some(&true) {
            let content = &mut self.contents[self.taken];
            self.taken += 1;
            if (self.took)(content, text_length)? == Rest::Unwanted {
                self.rest = Rest::Unwanted;
            }
        }
        Ok(())
    }
}
