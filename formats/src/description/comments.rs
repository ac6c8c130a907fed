//! Comments in JSON texts, which people write and JSON doesn't have.

use std::borrow::Cow;
use std::io::Read as _;
use std::path::Path;

use json_comments::CommentSettings;

use crate::Error;

/// The same text with blanks in place of `// ...` and `/* ... */`, so that places stay where they are.
///
/// # Errors
/// [`Error::File`] for a comment without an end.
pub fn without_comments<'a>(text: &'a [u8], path: &Path) -> Result<Cow<'a, [u8]>, Error> {
    let begins = |pair: &[u8]| pair == b"//" || pair == b"/*";
    if !text.windows(2).any(begins) {
        return Ok(Cow::Borrowed(text));
    }
    let mut blank = Vec::with_capacity(text.len());
    match CommentSettings::c_style()
        .strip_comments(text)
        .read_to_end(&mut blank)
    {
        Ok(_) => Ok(Cow::Owned(blank)),
        Err(_) => Err(Error::File {
            path: path.to_owned(),
            message: "has a comment without an end; expected */ somewhere after /*".into(),
        }),
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test says what went wrong by failing")]
mod tests {
    use super::*;

    #[test]
    fn comments_become_blanks_and_texts_stay() {
        let text = b"{\"a\": \"https://x\", // why\n\"b\": /* two */ 2}";
        let blank = without_comments(text, Path::new("x")).unwrap();
        let value: serde_json::Value = serde_json::from_slice(&blank).unwrap();
        assert_eq!(value, serde_json::json!({"a": "https://x", "b": 2}));
        assert_eq!(blank.len(), text.len());
        assert!(without_comments(b"{} /* on", Path::new("x")).is_err());
    }
}
