//! Stress and strain fields of a superelement.

use faer::{Mat, MatRef};

use crate::component::{StressComponent, StressPoint, StressQuantity};

/// Coefficients of a turned tensor below this are zero.
const ROUNDING: f64 = 1e-12;

/// Stress or strain at some places inside the component, as rows over the reduced basis; they see no rigid motion.
#[derive(Clone, Debug, PartialEq)]
pub struct StressField {
    /// Unique name.
    pub name: String,
    /// Stress or strain.
    pub quantity: StressQuantity,
    /// Components at every place, in body axes.
    pub components: Vec<StressComponent>,
    /// Places, body frame.
    pub points: Vec<StressPoint>,
    /// S Ψ, (places x components, n): place after place, at each its components.
    pub shapes: Mat<f64>,
    /// √(s G_o sᵀ) of each row, G_o the flexibility that the modes leave out: stress over √energy; `None` where nobody has computed it.
    pub omitted: Option<Vec<f64>>,
}

impl StressField {
    /// The row of a component at a place.
    pub fn row(&self, point: usize, component: usize) -> usize {
        point * self.components.len() + component
    }

    /// Over combinations of the basis, (n, columns); what is left out isn't known of these.
    #[must_use]
    pub fn over(&self, columns: MatRef<'_, f64>) -> Self {
        Self {
            shapes: &self.shapes * columns,
            omitted: None,
            ..self.without_shapes()
        }
    }

    /// In other axes, `axes` from these to them, a rotation or a reflection: σ' = Q σ Qᵀ. The components that follow from those that are here;
    /// `None` if there is none. What is left out is bounded by the sum of what its parts leave out.
    pub fn turned(&self, axes: [[f64; 3]; 3]) -> Option<Self> {
        let weights = |to: StressComponent| -> Option<Vec<f64>> {
            let all = StressComponent::ALL.map(|from| weight(axes, to, from));
            let is_lost = |from: &StressComponent| {
                all[from.index()].abs() > ROUNDING && !self.components.contains(from)
            };
            match StressComponent::ALL.iter().any(is_lost) {
                true => None,
                false => Some(
                    self.components
                        .iter()
                        .map(|from| all[from.index()])
                        .collect(),
                ),
            }
        };
        let made: Vec<(StressComponent, Vec<f64>)> = (StressComponent::ALL.into_iter())
            .filter_map(|to| Some((to, weights(to)?)))
            .collect();
        if made.is_empty() {
            return None;
        }
        let (old, new) = (self.components.len(), made.len());
        let shapes = Mat::from_fn(self.points.len() * new, self.shapes.ncols(), |i, j| {
            let (point, to) = (i / new, i % new);
            let from = made[to].1.iter().enumerate();
            from.map(|(k, weight)| weight * self.shapes[(point * old + k, j)])
                .sum()
        });
        let omitted = self.omitted.as_ref().map(|omitted| {
            let bound = |i: usize| {
                let from = made[i % new].1.iter().enumerate();
                from.map(|(k, weight)| weight.abs() * omitted[i / new * old + k])
                    .sum()
            };
            (0..shapes.nrows()).map(bound).collect()
        });
        Some(Self {
            components: made.into_iter().map(|(component, _)| component).collect(),
            shapes,
            omitted,
            ..self.without_shapes()
        })
    }

    fn without_shapes(&self) -> Self {
        Self {
            name: self.name.clone(),
            quantity: self.quantity,
            components: self.components.clone(),
            points: self.points.clone(),
            shapes: Mat::zeros(0, 0),
            omitted: None,
        }
    }
}

/// What one component contributes to another in turned axes.
fn weight(axes: [[f64; 3]; 3], to: StressComponent, from: StressComponent) -> f64 {
    let [(a, b), (c, d)] = [to, from].map(StressComponent::axes);
    match c == d {
        true => axes[a][c] * axes[b][c],
        false => axes[a][c] * axes[b][d] + axes[a][d] * axes[b][c],
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test says what went wrong by failing")]
mod tests {
    use super::*;
    use crate::component::von_mises;

    fn field(components: &[StressComponent], values: &[f64]) -> StressField {
        StressField {
            name: "here".into(),
            quantity: StressQuantity::Stress,
            components: components.to_vec(),
            points: vec![StressPoint {
                position: [0.0; 3],
                node: None,
            }],
            shapes: Mat::from_fn(values.len(), 1, |i, _| values[i]),
            omitted: Some(vec![1.0; values.len()]),
        }
    }

    #[test]
    fn turning_keeps_von_mises_and_trace() {
        let values = [3.0, -1.0, 2.0, 0.5, 0.7, -0.3];
        let of = field(&StressComponent::ALL, &values);
        let axes = *nalgebra::Rotation3::from_euler_angles(0.3, -0.8, 1.9).matrix();
        let rows: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| axes[(i, j)]));
        let turned = of.turned(rows).unwrap();
        let new: Vec<f64> = (0..6).map(|i| turned.shapes[(i, 0)]).collect();
        let before = von_mises(&of.components, &values);
        let after = von_mises(&turned.components, &new);
        assert!((before - after).abs() < 1e-14, "{before} {after}");
        let trace: f64 = new[..3].iter().sum();
        assert!((trace - 4.0).abs() < 1e-14, "{trace}");
        // By the tensor itself.
        let tensor = nalgebra::Matrix3::new(3.0, 0.5, -0.3, 0.5, -1.0, 0.7, -0.3, 0.7, 2.0);
        let whole = axes * tensor * axes.transpose();
        assert!((whole[(0, 1)] - new[3]).abs() < 1e-14);
        assert!((whole[(2, 0)] - new[5]).abs() < 1e-14);
    }

    #[test]
    fn what_needs_components_that_arent_there_is_left_out() {
        let of = field(&[StressComponent::Xx, StressComponent::Yy], &[3.0, 1.0]);
        // A quarter turn about z.
        let turned = of
            .turned([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
            .unwrap();
        assert_eq!(
            turned.components,
            [StressComponent::Xx, StressComponent::Yy]
        );
        assert_eq!((turned.shapes[(0, 0)], turned.shapes[(1, 0)]), (1.0, 3.0));
        let (sine, cosine) = 0.4_f64.sin_cos();
        let skew = [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(of.turned(skew), None);
    }
}
