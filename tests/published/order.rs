//! Second order in the step, from the first step on.

use dcb_tests::mechanism::{method, stabilized};
use dcb_tests::motion::order::{ORDER_BOUND, PROBLEMS, QUANTITIES, convergence, orders};

#[test]
fn errors_are_of_second_order_in_the_step() {
    for problem in &PROBLEMS {
        for method in [method(0.8), stabilized(0.8)] {
            for (errors, quantity) in convergence(problem, method).iter().zip(QUANTITIES) {
                let orders = orders(errors);
                println!("{}, {quantity}: {errors:?} {orders:.2?}", problem.name);
                assert!(orders.iter().all(|order| (order - 2.0).abs() < ORDER_BOUND));
            }
        }
    }
}
