//! Subtrees as tasks, and the memory that their update matrices take.

use super::Fronts;

/// A subtree becomes one task when it is less than this part of the work.
const TASKS: f64 = 64.0;

/// A subtree of more than this part of the work is eliminated by itself, with all threads.
const LARGE: f64 = 0.25;

impl Fronts {
    /// Whether a subtree is so large that no other one is eliminated beside it.
    pub fn stands_alone(&self, front: usize) -> bool {
        self.subtree_flops[front] > LARGE * self.flops()
    }

    /// Whether a subtree is small enough to be one task.
    pub fn is_one_task(&self, front: usize) -> bool {
        self.children(front).is_empty() || self.subtree_flops[front] * TASKS <= self.flops()
    }

    /// Entries that the update matrices of fronts of even and of odd depth take at most while one thread eliminates a subtree; the
    /// root's own is held elsewhere.
    pub fn stack_rooms(&self, root: usize) -> [usize; 2] {
        let (mut tops, mut rooms) = ([0_usize; 2], [0_usize; 2]);
        for front in self.first_descendant(root)..root {
            let own = self.depth(front) % 2;
            let children = self.children(front).iter();
            let handed: usize = children
                .map(|child| self.update_length(*child as usize))
                .sum();
            tops[1 - own] -= handed;
            tops[own] += self.update_length(front);
            rooms[own] = rooms[own].max(tops[own]);
        }
        rooms
    }

    /// Bound of the entries of update matrices held at once by so many threads.
    pub fn stack_bound(&self, threads: usize) -> usize {
        let mut bounds = vec![0_usize; self.len()];
        let square = |front: u32| self.update_length(front as usize);
        for front in 0..self.len() {
            bounds[front] = if self.is_one_task(front) {
                self.subtree_stack[front]
            } else {
                let bound = self.side_by_side(&self.children[front], &bounds, threads);
                let held: usize = self.children[front].iter().map(|c| square(*c)).sum();
                bound.max(held + square(front as u32))
            };
        }
        self.side_by_side(&self.roots, &bounds, threads)
    }

    /// Large subtrees one after the other, then as many of the others as there are threads at their peak, the rest done.
    fn side_by_side(&self, subtrees: &[u32], bounds: &[usize], threads: usize) -> usize {
        let square = |front: &u32| self.update_length(*front as usize);
        let (large, small): (Vec<u32>, Vec<u32>) = subtrees
            .iter()
            .partition(|front| self.stands_alone(**front as usize));
        let (mut held, mut bound) = (0, 0);
        for front in &large {
            bound = bound.max(held + bounds[*front as usize]);
            held += square(front);
        }
        let mut extra: Vec<usize> = small
            .iter()
            .map(|front| bounds[*front as usize].saturating_sub(square(front)))
            .collect();
        extra.sort_unstable_by_key(|extra| std::cmp::Reverse(*extra));
        held += small.iter().map(square).sum::<usize>();
        bound.max(held + extra.iter().take(threads).sum::<usize>())
    }
}
