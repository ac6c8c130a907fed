#![allow(missing_docs, clippy::unwrap_used)]
use dcb_tests::*;
use dcb_samples::spatial_beam::*;
fn main(){
    let mut beam = parts::beam(6, BeamTheory::EulerBernoulli, BeamMass::LumpedTranslations);
    let mut mass = dense::dense(&beam.mass);
    mass[(3, 3)] = 1e-3;
    beam.mass = dense::sparse(&mass);
    beam.component_masses = None;
    let o = oracle::Oracle::of(&beam);
    println!("{:?}", o.eigenvalues);
    for k in 0..17 {
        match dcb_reducer::reduce(&beam, &dcb_reducer::Reduction::lowest(k), &mut ()) {
            Ok(r)=>println!("{k} ok {:?} {:?} rank {} static {}", r.superelement.modes.eigenvalues, r.quality.sturm, r.quality.residual_rank, r.quality.static_directions),
            Err(e)=>println!("{k} {e}"),
        }
    }
    let c = dcb_samples::connecting_rod(0);
    let run=|t:usize| rayon::ThreadPoolBuilder::new().num_threads(t).build().unwrap().install(||lowest(&c,10));
    let one=run(1);
    for t in [1,2,2,4] { let o=run(t); let (a,b)=(&one.superelement,&o.superelement);
      println!("{t} modes {} resid {} inertia {} prov {} rec {}", a.modes==b.modes, a.residual==b.residual, a.inertia==b.inertia, a.provenance==b.provenance, one.recovery==o.recovery);
      println!(" f {} m {} m0 {} t {} s {}", a.residual.flexibility==b.residual.flexibility,a.residual.mass==b.residual.mass,a.residual.mass_diagonal0==b.residual.mass_diagonal0,a.residual.transform==b.residual.transform,a.residual.sigma_squared==b.residual.sigma_squared);
      if a.provenance!=b.provenance { println!("{}\n{}", a.provenance.quality, b.provenance.quality); }
    }
}
