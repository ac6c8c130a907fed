//! Flexible bodies in motions with a closed form or a conserved quantity: a bar spun about its end, a free body, a cantilever
//! in turned positions.

use dcb_tests::mechanism::closed_form_motions::{
    cantilever, free_body_drifts, spun_bar, weight_deflections,
};

/// A bar of density ρ and modulus E that turns about its end at ω stretches by u = ρ ω² / (2 E) (x L² - x³ / 3)
/// (code_aster, test SSNV/V3.04.104). Softening, u ω² ρ against E u'', is below 1e-5 here.
#[test]
fn bar_spun_about_its_end_stretches() {
    let (tip, worst) = spun_bar();
    println!("tip {tip:.3e}, worst {worst:.2e} of it");
    assert!(worst < 2e-3);
}

/// Nothing acts on a free body: its linear momentum stays to rounding, angular momentum and energy to the order of the method.
#[test]
fn free_body_keeps_its_momenta() {
    let drifts = [4000, 8000].map(free_body_drifts);
    println!("{drifts:?}");
    assert!(drifts.iter().all(|drift| drift[0] < 1e-11));
    for k in 1..3 {
        assert!(drifts[1][k] < 1e-4);
        assert!(drifts[0][k] / drifts[1][k] > 3.4, "{drifts:?}");
    }
}

/// In axes of the turned clamp the end sinks by ρ A g L⁴ cos / (8 E I), and a standing beam is shorter by ρ g L² / (2 E). The
/// linear theory is of first order in the deflection, 6e-4 here.
#[test]
fn turned_cantilevers_bend_under_their_weight() {
    let (shortening, sag) = weight_deflections();
    for degrees in [0.0_f64, 30.0, 75.0, 120.0] {
        let angle = degrees.to_radians();
        let (_, across) = cantilever(angle);
        let expected = -sag * angle.cos();
        println!("{degrees} degrees: {across:.5e} for {expected:.5e}");
        assert!((across - expected).abs() < 5e-4 * sag);
    }
    let (along, across) = cantilever(std::f64::consts::FRAC_PI_2);
    println!(
        "standing: {along:.5e} for {:.5e}, {across:.1e}",
        -shortening
    );
    assert!((along + shortening).abs() < 5e-3 * shortening);
    assert!(across.abs() < 1e-6 * sag);
}
