//! Does the reduction stand where a plain method falls? Each case runs both: the plain one has to fail, by number, and ours has to hold
//! its bound or be refused by name.

use dcb_tests::hard::reduction::{GROUP, conditioning, refusals, rows, spectra};

dcb_tests::hard_reduction_cases!(tests);
