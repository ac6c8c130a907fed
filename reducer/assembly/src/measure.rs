//! Scalar measures of the motion, as combinations of interface rows and rigid motions of bodies.

use faer::Mat;

use crate::part::Part;

/// What one body contributes.
#[derive(Clone, Debug, PartialEq)]
struct Term {
    body: usize,
    /// Interface rows and their weights.
    rows: Vec<(usize, f64)>,
    /// Weights of the translation of the centre and of the rotation, axes of the assembly.
    rigid: [f64; 6],
}

/// A linear measure of the motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Measure {
    terms: Vec<Term>,
}

impl Measure {
    /// A combination of interface rows of a body.
    pub fn of_rows(body: usize, rows: Vec<(usize, f64)>) -> Self {
        Self {
            terms: vec![Term {
                body,
                rows,
                rigid: [0.0; 6],
            }],
        }
    }

    /// A combination of the rigid motions of a body.
    pub fn of_frame(body: usize, rigid: [f64; 6]) -> Self {
        Self {
            terms: vec![Term {
                body,
                rows: Vec::new(),
                rigid,
            }],
        }
    }

    /// The same and so much of another.
    #[must_use]
    pub fn plus(mut self, factor: f64, other: &Self) -> Self {
        if factor != 0.0 {
            for term in &other.terms {
                self.terms.push(Term {
                    body: term.body,
                    rows: term
                        .rows
                        .iter()
                        .map(|(row, weight)| (*row, factor * weight))
                        .collect(),
                    rigid: term.rigid.map(|weight| factor * weight),
                });
            }
        }
        self
    }

    /// The measure over coordinates: rigid ones by `(6)` weights for each body, rows by weights for each body.
    pub fn each(&self, parts: &[Part], mut take: impl FnMut(usize, Source)) {
        for term in &self.terms {
            let mut rigid = term.rigid;
            for (row, weight) in &term.rows {
                take(term.body, Source::Row(*row, *weight));
                if let Some(motion) = parts[term.body].rigid_row(*row) {
                    for (whole, own) in rigid.iter_mut().zip(motion) {
                        *whole += weight * own;
                    }
                }
            }
            take(term.body, Source::Frame(rigid));
        }
    }
}

/// What a measure is made of.
pub(crate) enum Source {
    /// Elastic motion of a row, weighted.
    Row(usize, f64),
    /// Rigid motion, weighted: translation and rotation.
    Frame([f64; 6]),
}

/// Measures over the coordinates x of all bodies, and their rows.
pub(crate) struct Measured {
    /// (measures, all coordinates).
    pub motion: Mat<f64>,
    /// Weights of the interface rows of each body, (n_b, measures); without columns for rigid bodies.
    pub rows: Vec<Mat<f64>>,
}

impl Measured {
    pub fn of(measures: &[&Measure], parts: &[Part]) -> Self {
        let starts = starts(parts);
        let count = starts.last().copied().unwrap_or(0);
        let mut motion = Mat::zeros(measures.len(), count);
        let mut rows: Vec<Mat<f64>> = (parts.iter())
            .map(|part| {
                let n_b = part.flexible().map_or(0, |of| of.element.rows.len());
                Mat::zeros(n_b, measures.len())
            })
            .collect();
        for (i, measure) in measures.iter().enumerate() {
            measure.each(parts, |body, source| {
                let (part, start) = (&parts[body], starts[body]);
                match source {
                    Source::Row(row, weight) => {
                        rows[body][(row, i)] += weight;
                        if let Some(flexible) = part.flexible() {
                            let first = start + part.rigid_count();
                            for k in 0..flexible.stiffness.len() {
                                motion[(i, first + k)] += weight * flexible.shapes[(row, k)];
                            }
                        }
                    }
                    Source::Frame(weights) => {
                        for k in 0..part.rigid_count() {
                            for (axis, weight) in weights.iter().enumerate() {
                                motion[(i, start + k)] += weight * part.rigid[(axis, k)];
                            }
                        }
                    }
                }
            });
        }
        Self { motion, rows }
    }

    /// Flexibility without mass between the measures, (measures, measures).
    pub fn massless(&self, parts: &[Part]) -> Mat<f64> {
        let count = self.motion.nrows();
        let mut whole = Mat::zeros(count, count);
        for (part, rows) in parts.iter().zip(&self.rows) {
            if let Some(massless) = part.flexible().and_then(|of| of.massless.as_ref()) {
                whole += rows.transpose() * massless * rows;
            }
        }
        whole
    }
}

/// Where the coordinates of each body begin among all, and their number.
pub(crate) fn starts(parts: &[Part]) -> Vec<usize> {
    let mut starts = vec![0];
    for part in parts {
        let last = starts.last().copied().unwrap_or(0);
        starts.push(last + part.count());
    }
    starts
}

/// K over all coordinates, without joints and springs.
pub(crate) fn stiffness(parts: &[Part]) -> Vec<f64> {
    let of_part = |part: &Part| {
        let elastic = part
            .flexible()
            .map_or_else(Vec::new, |of| of.stiffness.clone());
        let mut all = vec![0.0; part.rigid_count()];
        all.extend(elastic);
        all
    };
    parts.iter().flat_map(of_part).collect()
}
