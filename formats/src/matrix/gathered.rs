//! Entries that come block after block, on their way into a matrix.

use super::entries::{Entries, Order};

/// Blocks of entries in file order. Where the first one has both triangles they are joined while they come, as long as they rise by columns or by
/// rows: the matrix is made of them without a copy, and no block waits beside it.
#[derive(Debug, Default)]
pub struct Gathered {
    blocks: Vec<Entries>,
    joined: Joined,
}

/// Of the blocks so far.
#[derive(Clone, Copy, Debug, Default)]
enum Joined {
    /// There is none.
    #[default]
    Nothing,
    /// They are one, in this order, up to this place.
    One(Order, Option<(u32, u32)>),
    /// They can't be.
    Apart,
}

impl Gathered {
    /// Puts a block behind the others.
    pub fn push(&mut self, block: Entries) {
        if block.is_empty() {
            return;
        }
        self.joined = self.with(&block);
        match (self.joined, self.blocks.first_mut()) {
            (Joined::One(..), Some(all)) => all.append(block),
            _ => self.blocks.push(block),
        }
    }

    /// What the blocks are with another one.
    fn with(&self, block: &Entries) -> Joined {
        let (before, orders) = match self.joined {
            Joined::Nothing => (None, &[Order::ByColumns, Order::ByRows][..]),
            Joined::One(Order::ByColumns, last) => (last, &[Order::ByColumns][..]),
            Joined::One(Order::ByRows, last) => (last, &[Order::ByRows][..]),
            Joined::Apart => return Joined::Apart,
        };
        let held: usize = self.blocks.iter().map(Entries::len).sum();
        let has_both = || {
            let (above, below) = block.triangle_counts();
            above > 0 && below > 0
        };
        let is_first = matches!(self.joined, Joined::Nothing);
        if held + block.len() > u32::MAX as usize || (is_first && !has_both()) {
            return Joined::Apart;
        }
        let rises = |&order: &Order| Some(Joined::One(order, block.rise_behind(before, order)?));
        orders.iter().find_map(rises).unwrap_or(Joined::Apart)
    }

    /// All of them.
    pub fn into_blocks(self) -> Vec<Entries> {
        self.blocks
    }
}

#[cfg(test)]
mod tests {
    use super::super::entries::Triplet;
    use super::*;

    fn block(places: &[(u32, u32)]) -> Entries {
        let mut entries = Entries::default();
        for &(row, column) in places {
            let value = f64::from(10 * row + column);
            entries.push(Triplet { row, column, value });
        }
        entries
    }

    /// Places of each block that is left.
    fn gathered(blocks: &[&[(u32, u32)]]) -> Vec<Vec<(u32, u32)>> {
        let mut gathered = Gathered::default();
        blocks
            .iter()
            .for_each(|places| gathered.push(block(places)));
        let blocks = gathered.into_blocks().into_iter();
        let places = blocks.map(|block| {
            let places = block.iter().map(|entry| {
                assert_eq!(entry.value, f64::from(10 * entry.row + entry.column));
                (entry.row, entry.column)
            });
            places.collect()
        });
        places.collect()
    }

    #[test]
    fn both_triangles_in_rising_order_become_one_block() {
        let first = [(0, 0), (0, 2), (1, 0), (1, 1)];
        let second = [(1, 2), (2, 0), (2, 2), (2, 3), (3, 2)];
        let whole = [&first[..], &second].concat();
        assert_eq!(
            gathered(&[&first, &[], &second]),
            std::slice::from_ref(&whole)
        );
        let turned = |places: &[(u32, u32)]| -> Vec<_> {
            places.iter().map(|&(row, column)| (column, row)).collect()
        };
        let by_columns = gathered(&[&turned(&first), &turned(&second)]);
        assert_eq!(by_columns, [turned(&whole)]);
    }

    #[test]
    fn other_blocks_stay_as_they_are() {
        let first = [(0, 0), (0, 2), (1, 0)];
        let third = [(5, 4), (5, 5), (5, 6)];
        // A place again, twice the same place, by columns behind rows.
        for second in [
            &[(1, 0), (1, 1), (1, 2)][..],
            &[(1, 1), (4, 2), (4, 2)],
            &[(3, 1), (2, 2), (2, 3)],
        ] {
            let apart = gathered(&[&first, second, &third]);
            assert_eq!(apart, [&first, second, &third]);
        }
        assert_eq!(gathered(&[&[(1, 0)], &third]).len(), 2);
        assert_eq!(gathered(&[&first, &[(1, 1)], &third]).len(), 1);
        assert_eq!(gathered(&[]), Vec::<Vec<_>>::new());
    }
}
