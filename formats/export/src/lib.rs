//! Other tools' files out: a superelement as other programs read it.
