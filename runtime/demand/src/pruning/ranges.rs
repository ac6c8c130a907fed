//! Lists of numbers in words.

/// Numbers from 1, in ranges: `2, 4–7`.
pub(super) fn ranges(places: &[usize]) -> String {
    let mut parts: Vec<(usize, usize)> = Vec::new();
    for place in places {
        match parts.last_mut() {
            Some((_, last)) if *last + 1 == *place => *last = *place,
            _ => parts.push((*place, *place)),
        }
    }
    let written: Vec<String> = parts
        .iter()
        .map(|(first, last)| match first == last {
            true => (first + 1).to_string(),
            false => format!("{}–{}", first + 1, last + 1),
        })
        .collect();
    written.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_told_in_ranges() {
        assert_eq!(ranges(&[1, 3, 4, 5, 6]), "2, 4–7");
        assert_eq!(ranges(&[]), "");
    }
}
