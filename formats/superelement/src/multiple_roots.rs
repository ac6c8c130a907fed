//! Where a list of eigenvalues may end.

/// Eigenvalues closer than this, relatively, are one multiple root, which is never cut. Meshes of symmetric components split a double root by
/// rounding only (1e-9 and less), nearly double roots of slightly unsymmetric meshes by 1e-4 and more.
pub const CLUSTER_TOLERANCE: f64 = 1e-5;

/// `wanted`, raised until the next of the ascending eigenvalues is separated by more than [`CLUSTER_TOLERANCE`].
pub fn extended_to_gap(eigenvalues: &[f64], wanted: usize) -> usize {
    let mut kept = wanted.min(eigenvalues.len());
    while kept > 0
        && kept < eigenvalues.len()
        && eigenvalues[kept] - eigenvalues[kept - 1] <= CLUSTER_TOLERANCE * eigenvalues[kept].abs()
    {
        kept += 1;
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_and_triples_stay_together() {
        let values = [1.0, 2.0, 2.000_001, 3.0, 3.0, 3.000_001, 5.0];
        let kept: Vec<usize> = (0..=8)
            .map(|wanted| extended_to_gap(&values, wanted))
            .collect();
        assert_eq!(kept, [0, 1, 3, 3, 6, 6, 6, 7, 7]);
    }
}
