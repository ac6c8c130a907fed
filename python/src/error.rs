//! The crates' errors as exceptions with the same texts.

use std::fmt::Debug;

use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

create_exception!(
    tisserand,
    Error,
    PyException,
    "Base of this package's exceptions. `variant` is the name of the error in the Rust crates."
);
create_exception!(
    tisserand,
    InputError,
    Error,
    "What was given can't be used; the programs end with status 2."
);
create_exception!(
    tisserand,
    NumericalError,
    Error,
    "The computation failed; the programs end with status 1."
);
create_exception!(
    tisserand,
    InternalError,
    Error,
    "A defect of this package: please report it with what led to it."
);

/// Variant of what is wrong with the arguments themselves.
const ARGUMENT: &str = "Argument";

/// Adds the exceptions to the module.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    let base = py.get_type::<Error>();
    // Of those that the package's Python raises.
    base.setattr("variant", ARGUMENT)?;
    module.add("Error", base)?;
    module.add("InputError", py.get_type::<InputError>())?;
    module.add("NumericalError", py.get_type::<NumericalError>())?;
    module.add("InternalError", py.get_type::<InternalError>())
}

/// Who is at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// What was given.
    Input,
    /// The computation.
    Computation,
}

/// An error on its way into Python; it can be made without the interpreter.
#[derive(Debug)]
pub enum Failure {
    /// With its text, and the name of its variant.
    Known {
        /// Whose fault it is.
        fault: Fault,
        /// Text.
        message: String,
        /// Name of the variant.
        variant: String,
    },
    /// A Python function that was called raised this, or the user has pressed Ctrl-C.
    Raised(PyErr),
    /// Something panicked.
    Panicked(String),
}

impl Failure {
    /// What was given can't be used.
    pub fn input(message: impl Into<String>) -> Self {
        Self::Known {
            fault: Fault::Input,
            message: message.into(),
            variant: ARGUMENT.into(),
        }
    }

    fn of(error: &impl std::error::Error, is_unusable_input: bool) -> Self {
        Self::Known {
            fault: match is_unusable_input {
                true => Fault::Input,
                false => Fault::Computation,
            },
            message: error.to_string(),
            variant: variant(error),
        }
    }
}

/// The innermost name that tells errors apart: that of the variant, as `Debug` prints it.
fn variant(error: &impl Debug) -> String {
    let shown = format!("{error:?}");
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut rest = shown.as_str();
    loop {
        let end = rest.find(|c| !is_name(c)).unwrap_or(rest.len());
        let (name, behind) = rest.split_at(end);
        // `File(Line { .. })` is a line.
        match behind.strip_prefix('(') {
            Some(inner) if inner.starts_with(|c: char| c.is_ascii_uppercase()) => rest = inner,
            _ => return name.to_owned(),
        }
    }
}

macro_rules! failures {
    ($($error:ty),* $(,)?) => {$(
        impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::of(&error, error.is_unusable_input())
            }
        }
    )*};
}

failures!(
    dcb_formats::Error,
    dcb_reducer::Error,
    dcb_runtime::Error,
    dcb_superelement::Error,
);

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Known {
                fault,
                message,
                variant,
            } => {
                let raised = match fault {
                    Fault::Input => InputError::new_err(message),
                    Fault::Computation => NumericalError::new_err(message),
                };
                Python::attach(|py| {
                    // An exception without its attribute is still the exception.
                    let _ = raised.value(py).setattr("variant", variant);
                });
                raised
            }
            Failure::Raised(error) => error,
            Failure::Panicked(message) => InternalError::new_err(format!(
                "{message}; this is a defect of tisserand, and the object that was used may be damaged"
            )),
        }
    }
}
