//! The words of messages: nearest names, lists of names, expected types.

use super::document::Path;

/// Message for a key that the table at `path` does not have.
pub(super) fn unknown_key(key: &str, path: Path, valid: &[&str]) -> String {
    let place = match path {
        Path::Root => String::new(),
        _ => format!(" in `{path}`"),
    };
    format!("unknown key `{key}`{place}{}", nearest_of(key, valid))
}

/// Message for a word at `path` that is not among the choices.
pub(super) fn unknown_word(word: &str, path: Path, valid: &[&str]) -> String {
    if matches!(path, Path::Key(_, "form")) && PAPER_FORMS.contains(&word) && !valid.contains(&"printed") {
        return format!(
            "`{path}`: `{word}` is a form to compare papers with, and only builds of taffeta with its feature \
             `paper-forms` have it. Valid here: {}",
            valid.join(", ")
        );
    }
    format!("`{path}` cannot be `{word}`{}", nearest_of(word, valid))
}

/// Forms that some builds leave out.
const PAPER_FORMS: [&str; 2] = ["printed", "paper-shader"];

/// `; did you mean `cols`? Valid here: rows, cols, size`
pub(super) fn nearest_of(name: &str, valid: &[&str]) -> String {
    if valid.is_empty() {
        return "; nothing is valid here".to_owned();
    }
    let list = valid.join(", ");
    match nearest(name, valid) {
        Some(nearest) => format!("; did you mean `{nearest}`? Valid here: {list}"),
        None => format!(". Valid here: {list}"),
    }
}

/// The candidate that is most likely meant by `name`, if one is like it.
pub(super) fn nearest<'a, S: AsRef<str>>(name: &str, candidates: &'a [S]) -> Option<&'a str> {
    let alike = |candidate: &'a S| (strsim::jaro_winkler(name, candidate.as_ref()), candidate.as_ref());
    let best = candidates.iter().map(alike).max_by(|a, b| a.0.total_cmp(&b.0));
    best.filter(|(similarity, _)| *similarity >= 0.8).map(|(_, nearest)| nearest)
}

/// What serde calls a type, in words for the user.
pub(super) fn expected(serde_words: &str) -> String {
    match serde_words {
        "f64" | "f32" => "a number".to_owned(),
        "u32" => "a whole number from 0 to 4294967295".to_owned(),
        "u64" | "usize" => "a whole number, 0 or more".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a string" => "text in quotes".to_owned(),
        "a sequence" => "a list".to_owned(),
        words if words.starts_with("struct ") || words == "a map" => "a table".to_owned(),
        words => match words.strip_prefix("an array of length ") {
            Some(length) => format!("a list of {length} entries"),
            None => words.to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_of_papers_that_is_not_built_in_is_told_from_one_that_nobody_has() {
        let solver = Path::Key(&Path::Root, "solver");
        let (form, method) = (Path::Key(&solver, "form"), Path::Key(&solver, "method"));
        assert_eq!(
            unknown_word("printed", form, &["compliant", "primal"]),
            "`solver.form`: `printed` is a form to compare papers with, and only builds of taffeta with its feature \
             `paper-forms` have it. Valid here: compliant, primal"
        );
        let elsewhere = [
            unknown_word("paper-shader", form, &["compliant", "printed"]),
            unknown_word("printed", method, &["springs", "ice"]),
        ];
        assert_eq!(
            elsewhere,
            [
                "`solver.form` cannot be `paper-shader`. Valid here: compliant, printed",
                "`solver.method` cannot be `printed`. Valid here: springs, ice"
            ]
        );
    }
}
