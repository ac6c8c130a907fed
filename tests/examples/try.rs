#![allow(missing_docs, clippy::unwrap_used)]
use dcb_tests::*;
fn main(){
    let file = reference::reference("ref_spatial.json");
    println!("{:?}", reference::numbers(&file["tet"]["sigma_residual"]));
    for (a,b) in [(0u32,15u32),(1,14),(2,13),(3,12),(15,0),(12,3)] {
        let mut c = dcb_samples::reference_tetrahedra();
        c.interfaces[0].nodes=vec![a]; c.interfaces[1].nodes=vec![b];
        let e = lowest(&c,6).superelement;
        println!("{a} {b} {:?}", e.residual.sigma_squared.iter().map(|s|s.sqrt()).collect::<Vec<_>>());
    }
    let c = dcb_samples::hard::symmetric_ring(8);
    let r = lowest(&c, 8);
    println!("{} {:?} {:?}", r.superelement.mode_count(), r.superelement.residual.sigma_squared, r.quality);
    println!("{:?}", dense::diagonal_roots(&r.superelement.residual.flexibility));
}
