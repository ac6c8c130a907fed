//! True errors of superelements that are made for some forces only, between these forces: the whole part's matrices against the numbers of the file.

use dcb_formats::component::Role;
use dcb_formats::scene::Compatibility;
use dcb_formats::{Component, Superelement};
use dcb_superelement::FrequencyBand;
use faer::linalg::solvers::Solve as _;
use faer::{Mat, c64};

use dcb_tests::error_estimate::{System, Truth};
use dcb_tests::oracle::Oracle;

/// Forces in units of the rows' own flexibility, orthonormal for each interface, and rows of output interfaces.
pub struct TruePorts {
    /// Over the rows of the component, (rows, ports).
    pub of_part: Mat<f64>,
    /// Over the rows of the superelement, (rows, ports).
    pub of_file: Mat<f64>,
    /// Interface of each.
    pub interface: Vec<usize>,
    /// Whether it is a force.
    pub attached: Vec<bool>,
    /// L G Lᵀ of the whole part between them.
    flexibility: Mat<f64>,
}

impl TruePorts {
    /// `forces` are those on each interface of the superelement, over its rows in the file; none for output interfaces. `rows` says where a row of the file is
    /// among those of the component.
    pub fn of(
        component: &Component,
        element: &Superelement,
        rows: &[usize],
        forces: &[Mat<f64>],
    ) -> Self {
        let oracle = Oracle::of(component);
        let l = &oracle.localization;
        let inertia = oracle.rigid.transpose() * &oracle.mass * &oracle.rigid;
        let rigid = l * &oracle.rigid;
        let inverse = inertia.partial_piv_lu().solve(rigid.transpose().to_owned());
        let moved = &rigid * inverse;
        let flexibility = l * &oracle.inverse * l.transpose();
        let mut kept = element.modes.eigenvalues.iter();
        let first = *kept.find(|square| **square > 0.0).expect("a mode");
        let scale: Vec<f64> = (0..l.nrows())
            .map(|i| (flexibility[(i, i)] + moved[(i, i)] / first).sqrt().recip())
            .collect();
        let (mut columns, mut interface, mut attached) = (Vec::new(), Vec::new(), Vec::new());
        for (index, of) in element.interfaces.iter().enumerate() {
            let own: Vec<usize> = (0..rows.len())
                .filter(|row| element.rows[*row].interface == index)
                .collect();
            let size = |i: usize| scale[rows[own[i]]];
            let unit = match of.role {
                Role::Output => Mat::identity(own.len(), own.len()),
                Role::Attachment => {
                    let given = &forces[index];
                    let scaled =
                        Mat::from_fn(own.len(), given.ncols(), |i, j| given[(i, j)] / size(i));
                    scaled.qr().compute_thin_Q()
                }
            };
            for column in unit.col_iter() {
                columns.push((
                    own.clone(),
                    (0..own.len())
                        .map(|i| column[i] * size(i))
                        .collect::<Vec<f64>>(),
                ));
                interface.push(index);
                attached.push(of.role == Role::Attachment);
            }
        }
        let spread = |count: usize, place: &dyn Fn(usize) -> usize| {
            let mut all = Mat::zeros(count, columns.len());
            for (j, (own, entries)) in columns.iter().enumerate() {
                for (row, entry) in own.iter().zip(entries) {
                    all[(place(*row), j)] = *entry;
                }
            }
            all
        };
        let of_part = spread(l.nrows(), &|row| rows[row]);
        Self {
            flexibility: of_part.transpose() * flexibility * &of_part,
            of_file: spread(rows.len(), &|row| row),
            of_part,
            interface,
            attached,
        }
    }

    /// True errors over a band. `motions` are those of the part that take part, where these aren't all.
    pub fn truth(
        &self,
        component: &Component,
        element: &Superelement,
        form: Compatibility,
        band: &FrequencyBand,
        motions: Option<&Mat<f64>>,
    ) -> Truth {
        let whole = System::whole(component).between(&self.of_part);
        let part = System::of_superelement(element, form).between(&self.of_file);
        let forced: Vec<usize> = (0..self.attached.len())
            .filter(|port| self.attached[*port])
            .collect();
        let (mut collocated, mut transfer) = (0.0_f64, 0.0_f64);
        for square in &band.squares {
            let exact = whole.response(*square, &forced);
            let off = part.response(*square, &forced) - &exact;
            let ratio = |same| self.norm(&off, &forced, same) / self.norm(&exact, &forced, same);
            collocated = collocated.max(ratio(true));
            if self.interface.iter().any(|of| *of != self.interface[0]) {
                transfer = transfer.max(ratio(false));
            }
        }
        let ones = vec![1.0; self.attached.len()];
        let taking_part = match motions {
            Some(motions) => System::whole(component)
                .within(motions)
                .between(&self.of_part),
            None => whole,
        };
        let exact = taking_part.held(&forced, &ones);
        let found = part.held(&forced, &ones);
        let below = exact.iter().take_while(|value| **value < band.top());
        let held = below
            .enumerate()
            .map(|(index, exact)| match found.get(index) {
                Some(found) => ((found / exact).sqrt() - 1.0).abs(),
                None => 1.0,
            });
        Truth {
            held: Some(held.fold(0.0, f64::max)),
            fixed: Some(self.static_error(element, &forced)),
            collocated,
            transfer: (transfer > 0.0).then_some(transfer),
        }
    }

    fn norm(&self, h: &Mat<c64>, forced: &[usize], same: bool) -> f64 {
        let mut sum = 0.0;
        for (j, column) in forced.iter().enumerate() {
            for i in 0..h.nrows() {
                if (self.interface[i] == self.interface[*column]) == same {
                    sum += h[(i, j)].norm_sqr();
                }
            }
        }
        sum.sqrt()
    }

    fn static_error(&self, element: &Superelement, forced: &[usize]) -> f64 {
        let (modes, residual) = (&element.modes, &element.residual);
        let stored = (residual.output_shapes.as_ref()).unwrap_or(&residual.flexibility);
        let shapes = &modes.interface_shapes;
        let flexible = Mat::from_fn(shapes.nrows(), shapes.ncols(), |i, k| {
            shapes[(i, k)] / modes.eigenvalues[k]
        });
        let found = stored + flexible * shapes.transpose();
        let found = self.of_file.transpose() * found * &self.of_file;
        let mut worst = 0.0_f64;
        for interface in 0..element.interfaces.len() {
            let (mut off, mut whole) = (0.0, 0.0);
            for column in forced
                .iter()
                .filter(|port| self.interface[**port] == interface)
            {
                for row in 0..self.interface.len() {
                    off += (found[(row, *column)] - self.flexibility[(row, *column)]).powi(2);
                    whole += self.flexibility[(row, *column)].powi(2);
                }
            }
            if whole > 0.0 {
                worst = worst.max(f64::sqrt(off / whole));
            }
        }
        worst
    }
}
