//! "Did you mean ...?"

/// The candidate a misspelt word most likely stands for, if one is near: at most one edit in three letters, or the one
/// that begins with the word; letter case aside.
#[must_use]
pub fn closest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    let near = |c: &&str| strsim::damerau_levenshtein(&word, &c.to_lowercase());
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let (edits, best) = candidates.iter().map(|c| (near(c), *c)).min_by_key(|(edits, _)| *edits)?;
    if 3 * edits <= word.chars().count().max(3) {
        return Some(best);
    }
    candidates.into_iter().find(|c| word.len() >= 3 && c.to_lowercase().starts_with(&word))
}

/// A help line: the nearest of the candidates if one is near, then all of them.
#[must_use]
pub fn help(word: &str, what: &str, candidates: &[&str]) -> String {
    let list = candidates.join(", ");
    match closest(word, candidates.iter().copied()) {
        Some(near) => format!("did you mean `{near}`? {what}: {list}"),
        None => format!("{what}: {list}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_near_word_is_found_and_a_far_one_is_not() {
        let words = ["steps", "scheme", "strategy"];
        assert_eq!(closest("stepz", words), Some("steps"));
        assert_eq!(closest("SCHEME", words), Some("scheme"));
        assert_eq!(closest("stratgey", words), Some("strategy"));
        assert_eq!(closest("strat", words), Some("strategy"));
        assert_eq!(closest("colour", words), None);
        assert_eq!(closest("x", []), None);
    }
}
