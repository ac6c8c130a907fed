//! Cross-crate tests by question.
