//! Sets of nodes in which each stands once, within bounds that the size of the file sets.

/// Why a set isn't made.
#[derive(Debug)]
pub(super) struct TooMuch;

impl TooMuch {
    pub fn message(&self) -> String {
        "the sets hold far more nodes together than a file of this size should; write fewer sets that repeat each other".into()
    }
}

/// Marks what a set has already.
#[derive(Debug)]
pub(super) struct Marks {
    /// Set that took a node last.
    marks: Vec<u32>,
    set: u32,
    /// Members that all sets may still have.
    room: u64,
    /// Members that may still be looked at.
    visits: u64,
}

impl Marks {
    /// For so many nodes or cells, in a text of so many bytes.
    pub fn new(count: usize, bytes: u64) -> Self {
        Self {
            marks: vec![0; count],
            set: 0,
            room: bytes + (1 << 20),
            visits: 64 * bytes + (1 << 24),
        }
    }

    /// A new set begins.
    pub fn start(&mut self) {
        self.set += 1;
    }

    /// Puts a place into the set, if it isn't there.
    ///
    /// # Errors
    /// When the sets hold or repeat too much.
    pub fn put(&mut self, into: &mut Vec<u32>, place: u32) -> Result<(), TooMuch> {
        self.look_at(1)?;
        let mark = &mut self.marks[place as usize];
        if *mark != self.set {
            *mark = self.set;
            self.room = self.room.checked_sub(1).ok_or(TooMuch)?;
            into.push(place);
        }
        Ok(())
    }

    /// Counts what is looked at.
    ///
    /// # Errors
    /// When that is too much.
    pub fn look_at(&mut self, count: u64) -> Result<(), TooMuch> {
        self.visits = self.visits.checked_sub(count).ok_or(TooMuch)?;
        Ok(())
    }
}
