//! Names of bodies as file names and as USD identifiers, each unique.

use std::collections::HashSet;

/// Names for files, one a body: what a file system may object to is `_`, repeated names are numbered.
///
/// ```
/// use taffeta_io::output::file_stems;
///
/// let names = ["sleeve", "sleeve", "front/left"].map(str::to_owned);
/// assert_eq!(file_stems(&names), ["sleeve", "sleeve_2", "front_left"]);
/// ```
pub fn file_stems(names: &[String]) -> Vec<String> {
    let safe = |name: &String| {
        let stem: String = name
            .chars()
            .map(|c| if c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ') { c } else { '_' })
            .take(80)
            .collect();
        match stem.trim_matches(['.', ' ']) {
            "" => "body".to_owned(),
            stem => stem.to_owned(),
        }
    };
    // Some file systems do not tell upper from lower case.
    unique(names.iter().map(safe), str::to_lowercase)
}

/// USD identifiers, one a body: letters, digits and `_`, not a digit first, repeated names are numbered.
///
/// ```
/// use taffeta_io::output::usd_identifiers;
///
/// let names = ["left sleeve", "2nd button"].map(str::to_owned);
/// assert_eq!(usd_identifiers(&names), ["left_sleeve", "_2nd_button"]);
/// ```
pub fn usd_identifiers(names: &[String]) -> Vec<String> {
    let safe = |name: &String| {
        let word: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        match word.chars().next() {
            None => "body".to_owned(),
            Some('0'..='9') => format!("_{word}"),
            Some(_) => word,
        }
    };
    unique(names.iter().map(safe), str::to_owned)
}

fn unique(names: impl Iterator<Item = String>, key: fn(&str) -> String) -> Vec<String> {
    let mut taken = HashSet::new();
    let mut choose = |name: String| {
        let numbered = (2..).map(|i| format!("{name}_{i}"));
        let mut candidates = std::iter::once(name.clone()).chain(numbered);
        candidates.find(|candidate| taken.insert(key(candidate))).unwrap_or(name)
    };
    names.map(&mut choose).collect()
}

#[cfg(test)]
mod tests {
    use super::{file_stems, usd_identifiers};

    #[test]
    fn names_become_safe_and_unique() {
        let names = ["flag", "Flag", "../up", "2 balls", "", "größe"].map(str::to_owned);
        assert_eq!(file_stems(&names), ["flag", "Flag_2", "_up", "2 balls", "body", "größe"]);
        let again = ["a b", "a.b", "2"].map(str::to_owned);
        assert_eq!(usd_identifiers(&again), ["a_b", "a_b_2", "_2"]);
    }
}
