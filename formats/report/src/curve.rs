//! From the points of a curve to lines that can be drawn: interrupted where there is nothing to draw, and with no more
//! points than can be seen.

use crate::axis::Ruler;

/// Columns into which a long history is divided: as many as the widest picture has dots.
const COLUMNS: f64 = 2000.0;
/// Points beyond which that pays.
const MANY: usize = 8000;

/// The pieces of a curve between values that have no place on the axes.
pub(super) fn pieces(points: &[[f64; 2]], x: &Ruler, y: &Ruler) -> Vec<Vec<[f64; 2]>> {
    let drawable = |point: &[f64; 2]| x.shows(point[0]) && y.shows(point[1]);
    points
        .split(|point| !drawable(point))
        .filter(|piece| !piece.is_empty())
        .map(|piece| match piece.len() > MANY && is_ordered(piece) {
            true => thinned(piece, x),
            false => piece.to_vec(),
        })
        .collect()
}

fn is_ordered(piece: &[[f64; 2]]) -> bool {
    piece.windows(2).all(|pair| pair[0][0] <= pair[1][0])
}

/// The first, lowest, highest and last point of each column of pixels: the picture stays the same.
fn thinned(piece: &[[f64; 2]], x: &Ruler) -> Vec<[f64; 2]> {
    let column = |point: &[f64; 2]| (x.fraction(point[0]) * COLUMNS) as i64;
    let mut thin = Vec::new();
    for part in piece.chunk_by(|a, b| column(a) == column(b)) {
        let indices = 0..part.len();
        let height = |index: &usize| part[*index][1];
        let lowest = indices
            .clone()
            .min_by(|a, b| height(a).total_cmp(&height(b)));
        let highest = indices.max_by(|a, b| height(a).total_cmp(&height(b)));
        let mut kept = [Some(0), lowest, highest, Some(part.len() - 1)];
        kept.sort();
        let mut previous = None;
        for index in kept.into_iter().flatten() {
            if previous != Some(index) {
                thin.push(part[index]);
            }
            previous = Some(index);
        }
    }
    thin
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::Ends;
    use crate::chart::Scale;

    #[test]
    fn a_single_peak_among_a_million_points_survives() {
        let mut points: Vec<[f64; 2]> = (0..1_000_000)
            .map(|step| [f64::from(step) * 1e-6, (f64::from(step) * 1e-4).sin()])
            .collect();
        points[123_456][1] = 17.0;
        points[700_000][1] = f64::NAN;
        let axis = |index: usize| {
            let values = points.iter().map(move |point| point[index]);
            Ruler::around(values, Scale::Linear, Ends::Loose, 5)
        };
        let pieces = pieces(&points, &axis(0), &axis(1));
        assert_eq!(pieces.len(), 2);
        assert!(pieces[0].contains(&[0.123456, 17.0]));
        assert_eq!(pieces[0].last(), Some(&points[699_999]));
        assert_eq!(pieces[1].first(), Some(&points[700_001]));
        assert!(pieces.iter().map(Vec::len).sum::<usize>() < 9000);
    }
}
