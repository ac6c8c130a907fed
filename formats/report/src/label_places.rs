//! Where words at points of a chart stand: each at a corner of its point or beside it, beside the words before it and the marks.
//! A front falls to the right: nothing of it, and no row that it dominates, is left below its points, so words begin there.

use std::ops::Range;

/// A mark that no word may hide, in steps of the drawing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    pub(super) at: (i32, i32),
    pub(super) radius: i32,
}

/// A word to be placed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Word {
    /// Its point.
    pub(super) at: (i32, i32),
    /// Width and height.
    pub(super) size: (i32, i32),
    /// From the point, along and up.
    pub(super) distance: i32,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    left: i32,
    top: i32,
    right: i32,
    bottom: i32,
}

impl Place {
    fn meets(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    fn is_within(&self, (along, up): &(Range<i32>, Range<i32>)) -> bool {
        self.left >= along.start
            && self.right <= along.end
            && self.top >= up.start
            && self.bottom <= up.end
    }
}

/// The upper left corner of each word: left below its point if that is free, otherwise right above, left above, right below,
/// left or right of it; `None` for a word that would hide something everywhere, or leave the area.
pub(super) fn placed(
    words: &[Word],
    marks: &[Mark],
    area: (Range<i32>, Range<i32>),
) -> Vec<Option<(i32, i32)>> {
    let mut taken: Vec<Place> = (marks.iter())
        .map(|mark| Place {
            left: mark.at.0 - mark.radius,
            top: mark.at.1 - mark.radius,
            right: mark.at.0 + mark.radius,
            bottom: mark.at.1 + mark.radius,
        })
        .collect();
    (words.iter())
        .map(|word| {
            let (x, y) = word.at;
            let (width, height) = word.size;
            let (right, left) = (x + word.distance, x - word.distance - width);
            let (above, below) = (y - word.distance - height, y + word.distance);
            let beside = y - height / 2;
            let places = [
                (left, below),
                (right, above),
                (left, above),
                (right, below),
                (left, beside),
                (right, beside),
            ];
            let free = places
                .into_iter()
                .map(|(left, top)| Place {
                    left,
                    top,
                    right: left + width,
                    bottom: top + height,
                })
                .find(|place| {
                    place.is_within(&area) && !taken.iter().any(|other| place.meets(other))
                })?;
            taken.push(free);
            Some((free.left, free.top))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORD: (i32, i32) = (20, 10);

    fn at(points: &[(i32, i32)]) -> Vec<Option<(i32, i32)>> {
        let words: Vec<Word> = (points.iter())
            .map(|at| Word {
                at: *at,
                size: WORD,
                distance: 3,
            })
            .collect();
        let marks: Vec<Mark> = (points.iter())
            .map(|at| Mark { at: *at, radius: 2 })
            .collect();
        placed(&words, &marks, (0..200, 0..100))
    }

    #[test]
    fn words_at_one_point_take_its_corners_and_what_finds_no_place_is_left_out() {
        let found = at(&[(100, 50); 5]);
        let corners = [(77, 53), (103, 37), (77, 37), (103, 53)].map(Some);
        assert_eq!(found[..4], corners);
        assert_eq!(found[4], None);
        // Near the lower edge, with a mark above: beside the point.
        let marks = [
            Mark {
                at: (100, 95),
                radius: 2,
            },
            Mark {
                at: (94, 82),
                radius: 8,
            },
            Mark {
                at: (106, 82),
                radius: 8,
            },
        ];
        let word = Word {
            at: (100, 95),
            size: (20, 8),
            distance: 3,
        };
        assert_eq!(placed(&[word], &marks, (0..200, 0..100)), [Some((77, 91))]);
    }

    #[test]
    fn a_word_stays_in_the_area_and_hides_no_mark() {
        assert_eq!(at(&[(198, 4)]), [Some((175, 7))]);
        // The mark of the second point is where the first one's word would begin.
        assert_eq!(at(&[(100, 50), (94, 56)])[0], Some((103, 37)));
    }
}
