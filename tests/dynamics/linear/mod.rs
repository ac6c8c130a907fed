//! Linear systems of mechanisms: against closed forms, against the nonlinear mechanism, in other units, truncated, and what is refused.

mod closed_forms;
mod nonlinear;
mod refusals;
mod support;
mod truncation;
