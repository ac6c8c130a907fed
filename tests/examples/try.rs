#![allow(missing_docs, clippy::unwrap_used)]
use dcb_reducer::{Reduction, reduce, observer::{Observer, Stage}};
struct Clock(std::time::Instant, Option<Stage>);
impl Observer for Clock {
    fn begin(&mut self, s: Stage) { if let Some(p)=self.1 {eprintln!("  {:12} {:.3}s", p.name(), self.0.elapsed().as_secs_f64());} self.0=std::time::Instant::now(); self.1=Some(s);}
    fn progress(&mut self, _: f64) {}
}
fn run(name: &str, c: &dcb_formats::Component, n: usize) {
    let t = std::time::Instant::now();
    let mut clock = Clock(std::time::Instant::now(), None);
    eprintln!("== {name} n_e {}", c.dofs.len());
    match reduce(c, &Reduction::lowest(n), &mut clock) {
        Ok(r) => {
            let q = &r.quality;
            let f: Vec<f64> = r.superelement.modes.eigenvalues.iter().take(8).map(|x| x.sqrt()/6.283185307179586).collect();
            println!("{name}: {:.3}s n_e {} f {:?}", t.elapsed().as_secs_f64(), c.dofs.len(), f);
            println!("   worst mode res {:.1e} att {:.1e} e29 {:.1e} e30 {:.1e} e31 {:.1e} {:.1e} e32 {:.1e} L1 {:.1e} I3 {:.1e} rigid {:.1e} its {:?} sturm {:?} rank {} static {} frank {} cond {:.1e}", q.mode_residuals.iter().copied().fold(0.0,f64::max), q.attachment_residual, q.stiffness_orthogonality, q.mass_orthogonality, q.mass_orthonormality, q.stiffness_diagonality, q.flexibility_identity, q.l1_norm, q.i3_norm, q.rigid_defects.iter().copied().fold(0.0,f64::max), q.iterations, q.sturm, q.residual_rank, q.static_directions, q.flexibility_rank, q.flexibility_condition);
            println!("   mass {:.6} warnings {:?} broken {:?}", r.superelement.inertia.mass, r.superelement.provenance.warnings, q.broken_limits());
        }
        Err(e) => println!("{name}: ERROR {e}"),
    }
}
fn main() {
    let arg = std::env::args().nth(1).unwrap_or_default();
    use dcb_samples as s;
    if arg == "big" { run("conrod", &s::connecting_rod(std::env::args().nth(2).unwrap().parse().unwrap()), 30); return; }
    for n in [0,1,3,5,8,9,12,20] { run(&format!("rod4 nk {n}"), &s::planar_rod(4, &Default::default()), n); }
    run("hex", &s::reference_hexahedra(), 6);
    run("tet", &s::reference_tetrahedra(), 6);
    run("square", &s::hard::square_block(), 10);
    run("ring", &s::hard::symmetric_ring(8), 11);
    run("thin", &s::hard::thin_plate(), 10);
    run("slender", &s::hard::slender_block(), 10);
    run("two", &s::hard::two_loose_blocks(), 10);
    run("hinge", &s::hard::hinged_blocks(s::hard::Hinge::Edge), 10);
    run("hinge", &s::hard::hinged_blocks(s::hard::Hinge::Node), 10);
    run("grounded", &s::hard::grounded_block(), 10);
    run("orphan", &s::hard::orphan_dof_block(), 10);
    run("beam", &s::spatial_beam(&Default::default()), 10);
}
