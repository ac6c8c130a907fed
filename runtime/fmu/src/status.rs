//! What calls answer, and whom they tell.

use std::ffi::{CStr, CString, c_char, c_void};

/// `fmi3Status`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// All is well.
    Ok,
    /// All is well, but something is worth telling.
    Warning,
    /// The step was not made and can be tried otherwise; never answered here.
    Discard,
    /// The call failed: the instance can be reset, set to a saved state or freed.
    Error,
    /// Nothing can be done any more.
    Fatal,
}

/// `fmi3LogMessageCallback`.
pub type LogMessage =
    Option<unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char)>;

/// Categories of messages, as the model description lists them.
const CATEGORIES: [&CStr; 3] = [c"logStatusWarning", c"logStatusError", c"logStatusFatal"];

/// Where messages go.
pub(crate) struct Log {
    environment: *mut c_void,
    callback: LogMessage,
    /// Whether warnings are told: errors are in any case.
    pub tells_warnings: bool,
}

impl Log {
    /// A log of an importer.
    pub fn new(environment: *mut c_void, callback: LogMessage, tells_warnings: bool) -> Self {
        Self {
            environment,
            callback,
            tells_warnings,
        }
    }

    /// Tells a message of this status.
    pub fn tell(&self, status: Status, message: &str) {
        let category = match status {
            Status::Ok | Status::Warning | Status::Discard if !self.tells_warnings => return,
            Status::Ok | Status::Warning | Status::Discard => CATEGORIES[0],
            Status::Error => CATEGORIES[1],
            Status::Fatal => CATEGORIES[2],
        };
        let Some(callback) = self.callback else {
            return;
        };
        let text = CString::new(message.replace('\0', "\u{fffd}")).unwrap_or_default();
        // SAFETY: the importer's function and environment, which live as long as its instance; both texts end with a zero byte.
        unsafe { callback(self.environment, status, category.as_ptr(), text.as_ptr()) };
    }

    /// Which messages are told, by the names of categories; the first unknown one where there is one.
    pub fn choose(&mut self, is_on: bool, categories: &[&CStr]) -> Result<(), String> {
        let unknown = categories.iter().find(|name| !CATEGORIES.contains(name));
        if let Some(unknown) = unknown {
            let known = CATEGORIES.map(CStr::to_string_lossy).join(", ");
            return Err(format!(
                "there is no category {:?} of messages, but {known}",
                unknown.to_string_lossy()
            ));
        }
        if categories.is_empty() || categories.contains(&CATEGORIES[0]) {
            self.tells_warnings = is_on;
        }
        Ok(())
    }
}
